// The conversation on the page: what could be typed in a chat, and buttons to tap.

import { html, useEffect, useRef, useState } from "./lib.js";
import { ask, relearn, useStore } from "./store.js";
import { spoken, t } from "./texts.js";

function time(ns) {
  return new Date(ns / 1e6).toLocaleTimeString(spoken(), {
    hour: "2-digit",
    minute: "2-digit",
    hourCycle: "h23",
  });
}

const SHOWN = ["image/png", "image/jpeg", "image/webp", "image/gif"];

/** A file that came with a message: a picture is seen, and each is saved; one that is gone says so. */
function MessageFile({ file }) {
  const [why, tell] = useState("");
  const path = `/v1/chat/${encodeURIComponent(file.id)}/file`;
  const gone = () => tell(t("{file} is not kept any more.", { file: file.name }));
  async function save(event) {
    // Looked up before it is saved: a browser would save the refusal, or say nothing.
    event.preventDefault();
    const answer = await fetch(path, { cache: "no-store" }).catch(() => null);
    if (!answer) return tell(t("The gateway does not answer."));
    if (!answer.ok) {
      if (answer.status === 404) return gone();
      const problem = await answer.json().catch(() => null);
      return tell(problem?.detail || t("The gateway does not answer."));
    }
    const link = document.createElement("a");
    link.href = URL.createObjectURL(await answer.blob());
    link.download = file.name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
    return tell("");
  }
  if (why) return html`<p class="quiet small file-gone" role="status">${why}</p>`;
  return html`<div class="message-file">
    ${SHOWN.includes(file.media_type) &&
    html`<img src=${path} alt=${file.name} loading="lazy" onError=${gone} />`}
    <a href=${path} download=${file.name} aria-label=${t("Save {file}", { file: file.name })} onClick=${save}>
      ${file.name}
    </a>
  </div>`;
}

/** One message, with its buttons. */
export function Message({ message, onTap }) {
  return html`<li class=${message.own ? "own" : `theirs ${message.state}`}>
    <p class="who">${message.own ? t("You") : "ROSIC"} <time>${time(message.sent_ns)}</time></p>
    <p class="text">${message.text}</p>
    ${message.file && html`<${MessageFile} file=${message.file} />`}
    ${message.buttons.map(
      (row) => html`<div class="buttons">
        ${row.map(
          (button) => html`<button type="button" onClick=${() => onTap(message.id, button.nonce)}>
            ${button.label}
          </button>`,
        )}
      </div>`,
    )}
  </li>`;
}

/** The conversation, and a line to write. */
export function Chat() {
  const { messages, link } = useStore();
  const [line, write] = useState("");
  const [why, tell] = useState("");
  const end = useRef(null);
  const all = [...messages.values()];
  const newest = all.length ? `${all[all.length - 1].id} ${all[all.length - 1].changed}` : "";
  useEffect(() => {
    const there = end.current;
    if (there) there.scrollTop = there.scrollHeight;
  }, [newest]);

  async function say(event) {
    event.preventDefault();
    const text = line.trim();
    if (!text) return;
    write("");
    const answer = await ask("POST", "/v1/chat", { text, wait_s: 0 });
    tell(answer.why);
    if (!answer.ok) write((now) => now || text);
  }

  async function tap(message, button) {
    tell("");
    const answer = await ask("POST", "/v1/chat", { message, button });
    // That a button is used up stands in no message.
    tell(answer.ok && answer.data.state === "not-done" ? answer.data.text : answer.why);
    relearn(); // it may have been a language
  }

  return html`<div class="chat">
    <ol class="messages" ref=${end} tabindex="0" aria-live="polite" aria-label=${t("Conversation")}>
      ${all.length === 0 &&
      html`<li class="hint quiet">${t("Write as you would in your messenger: omni move 0.5 m left. help says what there is.")}</li>`}
      ${all.map((each) => html`<${Message} key=${each.id} message=${each} onTap=${tap} />`)}
    </ol>
    <p class="why" role="alert">${why}</p>
    <form class="say" onSubmit=${say}>
      <label class="hidden" for="line">${t("Message")}</label>
      <input
        id="line"
        autocomplete="off"
        maxlength="4096"
        placeholder=${t("Message")}
        value=${line}
        onInput=${(event) => write(event.target.value)}
      />
      <button type="submit" class="main" disabled=${link !== "up"}>${t("Send")}</button>
    </form>
  </div>`;
}
