// What the gateway tells only when it is asked: looked up while it is shown, and what is asked of it.

import { Message } from "./chat.js";
import { html, useEffect, useRef, useState } from "./lib.js";
import { ask, useStore } from "./store.js";
import { spoken, t } from "./texts.js";

const EVERY_MS = 10_000;
// What a question of the conversation is in until it is answered: asked first, or agreed to by others.
const WAITS = new Set(["asked", "agreed"]);
const NOTHING = { data: null, why: "", status: 0 };

/** Ask for something now and again while it is shown: { data, why, status, again }. Old data is none. */
export function useAsked(path, everyMs = EVERY_MS) {
  const { link } = useStore();
  const [found, know] = useState({ path: "", ...NOTHING });
  const look = useRef(() => {});
  const up = link === "up";
  useEffect(() => {
    if (!path || !up) return undefined;
    let over = false;
    let turn = 0;
    let timer = 0;
    look.current = async () => {
      clearTimeout(timer);
      const mine = ++turn;
      if (!document.hidden) {
        const answer = await ask("GET", path);
        if (over || mine !== turn) return;
        know((before) => {
          if (answer.ok) return { path, data: answer.data, why: "", status: answer.status };
          return { path, data: before.path === path ? before.data : null, why: answer.why, status: answer.status };
        });
      }
      timer = setTimeout(look.current, everyMs);
    };
    look.current();
    return () => {
      over = true;
      look.current = () => {};
      clearTimeout(timer);
    };
  }, [path, up]);
  return { ...(found.path === path ? found : NOTHING), again: () => look.current() };
}

/** Say a line as in the conversation, and return { ok, text, kind } of what was answered. */
export async function command(line) {
  const answer = await ask("POST", "/v1/chat", { text: line });
  if (!answer.ok) return { ok: false, kind: "bad", text: answer.why };
  return heard(answer.data);
}

/** Return { ok, text, kind } of an answer of the conversation. */
export function heard({ state, text }) {
  if (state === "not-done") return { ok: false, kind: "bad", text };
  if (state === "asked") return { ok: false, kind: "warn", text };
  return { ok: true, kind: "good", text };
}

/** What is done from a tab: { said, waits, act }; `act` takes what returns { kind, text }. */
export function useDeed() {
  const [said, say] = useState({ kind: "", text: "" });
  const [waits, wait] = useState(false);
  async function act(deed) {
    wait(true);
    const done = await deed();
    wait(false);
    say({ kind: done.kind, text: done.text });
    return done;
  }
  return { said, waits, act, say };
}

/** What came of it, in view where it was done. */
export const Said = ({ said }) =>
  html`<p class=${`said ${said.kind}`} role=${said.kind === "bad" ? "alert" : "status"}>${said.text}</p>`;

/** What stands where there is nothing to show: why, that it is looked up, or that there is none. */
export function Nothing({ asked, none }) {
  if (asked.why) return html`<p class="said bad" role="status">${asked.why}</p>`;
  return html`<p class="quiet">${asked.data === null ? t("One moment …") : none}</p>`;
}

/** Questions that wait for an answer in the conversation: here, too, so that nobody has to look. */
export function Questions() {
  const { messages } = useStore();
  const { said, act } = useDeed();
  const open = [...messages.values()].filter((each) => WAITS.has(each.state) && each.buttons.length);
  const tap = (message, button) =>
    act(async () => {
      const answer = await ask("POST", "/v1/chat", { message, button });
      return answer.ok ? heard(answer.data) : { kind: "bad", text: answer.why };
    });
  if (!open.length && !said.text) return null;
  return html`<section class="panel questions" aria-label=${t("Questions")}>
    ${open.length > 0 &&
    html`<ul class="messages-few">
      ${open.slice(-2).map((each) => html`<${Message} key=${each.id} message=${each} onTap=${tap} />`)}
    </ul>`}
    <${Said} said=${said} />
  </section>`;
}

/** Return a day and a time of day as they are written in the reader's language. */
export function dayAndTime(moment) {
  return new Date(moment).toLocaleString(spoken(), {
    weekday: "short",
    day: "numeric",
    month: "short",
    hour: "2-digit",
    minute: "2-digit",
    hourCycle: "h23",
  });
}

/** One of the robots that one may see, to choose; all of them where that makes sense. */
export function RobotChoice({ value, onChoose, every = "" }) {
  const { robots } = useStore();
  return html`<label class="field">
    ${t("Robot")}
    <select value=${value} onChange=${(event) => onChoose(event.target.value)}>
      ${every && html`<option value="">${every}</option>`}
      ${[...robots.values()].map((each) => html`<option value=${each.id}>${each.name}</option>`)}
    </select>
  </label>`;
}
