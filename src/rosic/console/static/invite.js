// Inviting somebody, with a code to scan; and who waits to be let in or asks for a right.

import { dayAndTime, heard, Nothing, Said, useAsked, useDeed } from "./asked.js";
import { html, useState } from "./lib.js";
import { Pill } from "./robots.js";
import { ask, useStore } from "./store.js";
import { t } from "./texts.js";

const refused = (answer) => ({ ok: false, kind: "bad", text: answer.why });
const EVERY_MS = 4_000;

/** Ask for something that is answered as in the conversation. */
export async function asked(method, path, body) {
  const answer = await ask(method, path, body);
  return answer.ok ? heard(answer.data) : refused(answer);
}

function Request({ one, act, waits, again }) {
  const path = `/v1/access-requests/${encodeURIComponent(one.id)}`;
  const say = (word, body) => act(() => asked("POST", `${path}/${word}`, body)).then(again);
  return html`<li>
    <div>
      <p><b>${one.who}</b>${" "}${one.kind === "newcomer" ? t("wants to come in") : t("asks for a right")}</p>
      <p>${one.what}</p>
      ${one.words && html`<p>${t("Compare these words with theirs:")} <b class="words">${one.words}</b></p>`}
      <p class="quiet small">${t("until {time}", { time: dayAndTime(one.until) })}</p>
    </div>
    ${one.own
      ? html`<${Pill} kind="quiet">${t("yours: others answer")}<//>`
      : html`<div class="row">
          <button
            type="button"
            class="main"
            disabled=${waits}
            aria-label=${t("Allow {name}", { name: one.who })}
            onClick=${() => say("allow", {})}
          >
            ${t("Allow")}
          </button>
          <button
            type="button"
            disabled=${waits}
            aria-label=${t("Refuse {name}", { name: one.who })}
            onClick=${() => say("deny", {})}
          >
            ${t("Refuse")}
          </button>
        </div>`}
  </li>`;
}

/** Who waits for an answer, and what one waits for oneself. */
export function Requests() {
  const found = useAsked("/v1/access-requests", EVERY_MS);
  const { said, waits, act } = useDeed();
  return html`${found.data?.length
      ? html`<ul class="list requests">
          ${found.data.map(
            (one) => html`<${Request} key=${one.id} one=${one} act=${act} waits=${waits} again=${found.again} />`,
          )}
        </ul>`
      : html`<${Nothing} asked=${found} none=${t("Nobody waits for an answer.")} />`}
    <${Said} said=${said} />`;
}

function NewInvitation({ made, onClose }) {
  const link = made.links[0];
  return html`<div class="new-invitation" role="group" aria-label=${t("The new invitation")}>
    <img class="qr" src=${made.qr} alt=${t("Code to scan: it opens a chat and hands the code in")} />
    <div>
      <p>${t("Gives {rights}. The code is good until {time}, once, and is shown only now.", { rights: made.invitation.gives, time: dayAndTime(made.invitation.expires) })}</p>
      <p class="code">${made.code}</p>
      <p>${link ? html`<a href=${link.url} rel="noreferrer" target="_blank">${link.url}</a>` : t("To be typed: {words}", { words: made.typed })}</p>
      <button type="button" class="plain" onClick=${onClose}>${t("I have it")}</button>
    </div>
  </div>`;
}

/** A form that invites, and the invitations that are open. */
export function Invitations() {
  const { robots } = useStore();
  const found = useAsked("/v1/invitations");
  const { said, waits, act, say } = useDeed();
  const [role, choose] = useState("operator");
  const [robot, only] = useState("");
  const [hours, last] = useState("8");
  const [name, call] = useState("");
  const [made, show] = useState(null);
  if (!found.data) return html`<${Nothing} asked=${found} none="" />`;
  const invite = (event) => {
    event.preventDefault();
    const rights = `${role.trim()}${robot && ` on ${robot}`}${hours && ` for ${hours} hours`}`;
    act(async () => {
      const answer = await ask("POST", "/v1/invitations", { rights, name: name.trim() });
      if (!answer.ok) return refused(answer);
      show(answer.data);
      return { ok: true, kind: "good", text: "" };
    }).then(found.again);
  };
  const withdraw = (one) =>
    act(() => asked("DELETE", `/v1/invitations/${encodeURIComponent(one.id)}`)).then(found.again);
  return html`${made && html`<${NewInvitation} made=${made} onClose=${() => (show(null), say({ kind: "", text: "" }))} />`}
    <form class="give" aria-label=${t("Invite somebody")} onSubmit=${invite}>
      <label class="field">
        ${t("Role")}
        <input required maxlength="64" autocomplete="off" value=${role} onInput=${(event) => choose(event.target.value)} />
      </label>
      <label class="field">
        ${t("Robot")}
        <select value=${robot} onChange=${(event) => only(event.target.value)}>
          <option value="">${t("wherever the role reaches")}</option>
          ${[...robots.values()].map((each) => html`<option value=${each.id}>${each.name}</option>`)}
        </select>
      </label>
      <label class="field">
        ${t("For how long")}
        <select value=${hours} onChange=${(event) => last(event.target.value)}>
          <option value="2">${t("two hours")}</option>
          <option value="8">${t("a shift")}</option>
          <option value="168">${t("a week")}</option>
          <option value="">${t("until it is taken back")}</option>
        </select>
      </label>
      <label class="field">
        ${t("Name")}${" "}${t("(optional)")}
        <input maxlength="64" autocomplete="off" value=${name} onInput=${(event) => call(event.target.value)} />
      </label>
      <button type="submit" class="main" disabled=${waits}>${t("Invite")}</button>
      <${Said} said=${said} />
    </form>
    ${found.data.length > 0 &&
    html`<ul class="list" aria-label=${t("Open invitations")}>
      ${found.data.map(
        (one) => html`<li key=${one.id}>
          <span>
            <b>${one.gives}</b>${" "}
            <span class="quiet">${t("by {who}, until {time}", { who: one.by, time: dayAndTime(one.expires) })}</span>
          </span>
          <button type="button" class="plain" disabled=${waits} onClick=${() => withdraw(one)}>${t("Take it back")}</button>
        </li>`,
      )}
    </ul>`}`;
}
