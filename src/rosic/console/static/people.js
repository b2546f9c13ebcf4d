// People: who is known here and what they may; one's own ways to sign in.

import { command, Nothing, Said, useAsked, useDeed } from "./asked.js";
import { Invitations, Requests } from "./invite.js";
import { html, Table, useState } from "./lib.js";
import { Passkeys } from "./passkeys.js";
import { Pill } from "./robots.js";
import { useStore } from "./store.js";
import { t } from "./texts.js";

const ANY = "";

function Person({ person, me, act, waits, again }) {
  const own = person.id === me.id;
  const [sure, askFirst] = useState(false);
  const say = (line) => act(() => command(line)).then(again);
  return html`<tr>
    <th scope="row" data-head=${t("Name")}>
      <span>${person.name}${own && html` <span class="quiet">${t("(you)")}</span>`}</span>
    </th>
    <td data-head=${t("Kind")}>${person.kind === "program" ? t("program") : t("person")}</td>
    <td data-head=${t("Roles")}>${person.named.join(", ") || "—"}</td>
    <td data-head=${t("Accounts")}>${person.accounts.join(", ") || "—"}</td>
    <td data-head=${t("Access")}>
      ${person.locked ? html`<${Pill} kind="bad">${t("locked out")}<//>` : html`<${Pill} kind="good">${t("let in")}<//>`}
    </td>
    <td class="acts"><div class="row">
      ${!own &&
      (person.locked
        ? html`<button type="button" disabled=${waits} onClick=${() => say(`/unlock ${person.id}`)}>
            ${t("Let in again")}
          </button>`
        : html`<button type="button" disabled=${waits} onClick=${() => say(`/lock ${person.id}`)}>
            ${t("Lock out")}
          </button>`)}
      ${!own &&
      (sure
        ? html`<button
              type="button"
              class="danger"
              disabled=${waits}
              onClick=${() => {
                askFirst(false);
                say(`/revoke ${person.id}`);
              }}
            >
              ${t("Take every right of {name}", { name: person.name })}
            </button>
            <button type="button" class="plain" onClick=${() => askFirst(false)}>${t("Leave it")}</button>`
        : html`<button type="button" onClick=${() => askFirst(true)}>${t("Take rights away")}</button>`)}
    </div></td>
  </tr>`;
}

function Known({ asked }) {
  const { me } = useStore();
  const { said, waits, act } = useDeed();
  if (!asked.data) return html`<${Nothing} asked=${asked} none="" />`;
  return html`<${Table}
    label=${t("Who is known here")}
    kind="stacked"
    tall
    heads=${[t("Name"), t("Kind"), t("Roles"), t("Accounts"), t("Access"), html`<span class="hidden">${t("What can be done")}</span>`]}
  >
    <tbody>
      ${asked.data.map(
        (each) =>
          html`<${Person} key=${each.id} person=${each} me=${me} act=${act} waits=${waits} again=${asked.again} />`,
      )}
    </tbody>
  <//>
    <${Said} said=${said} />`;
}

/** Return a name; where two share it, with what tells them apart. */
function named(person, people) {
  const shared = people.some((each) => each.id !== person.id && each.name === person.name);
  return shared ? `${person.name} (${person.roles.join(", ") || "—"}, ${person.id})` : person.name;
}

function Give({ people, again }) {
  const { robots } = useStore();
  const { said, waits, act } = useDeed();
  const others = people.filter((each) => each.kind === "person");
  const roles = [...new Set(people.flatMap((each) => each.roles))].sort();
  const [whom, name] = useState("");
  const [role, choose] = useState("operator");
  const [robot, only] = useState(ANY);
  const [hours, last] = useState("2");
  const give = (event) => {
    event.preventDefault();
    const until = hours ? ` for ${hours}h` : "";
    act(() => command(`/grant ${whom} ${role}${robot && ` ${robot}`}${until}`)).then(again);
  };
  return html`<form class="give" aria-label=${t("Give a right")} onSubmit=${give}>
    <label class="field">
      ${t("To whom")}
      <select required value=${whom} onChange=${(event) => name(event.target.value)}>
        <option value=""></option>
        ${others.map((each) => html`<option value=${each.id}>${named(each, others)}</option>`)}
      </select>
    </label>
    <label class="field">
      ${t("Role")}
      <input list="roles" required maxlength="64" autocomplete="off" value=${role} onInput=${(event) => choose(event.target.value)} />
      <datalist id="roles">${roles.map((each) => html`<option value=${each}></option>`)}</datalist>
    </label>
    <label class="field">
      ${t("Robot")}
      <select value=${robot} onChange=${(event) => only(event.target.value)}>
        <option value=${ANY}>${t("wherever the role reaches")}</option>
        ${[...robots.values()].map((each) => html`<option value=${each.id}>${each.name}</option>`)}
      </select>
    </label>
    <label class="field">
      ${t("For how long")}
      <select value=${hours} onChange=${(event) => last(event.target.value)}>
        <option value="1">${t("an hour")}</option>
        <option value="2">${t("two hours")}</option>
        <option value="8">${t("a shift")}</option>
        <option value="168">${t("a week")}</option>
        <option value="">${t("until it is taken back")}</option>
      </select>
    </label>
    <button type="submit" class="main" disabled=${waits}>${t("Give the right")}</button>
    <${Said} said=${said} />
  </form>`;
}

/** The tab. */
export function People() {
  const asked = useAsked("/v1/people");
  return html`<div class="people">
    <section class="panel" aria-labelledby="h-requests">
      <h2 id="h-requests">${t("Who waits for an answer")}</h2>
      <${Requests} />
    </section>
    <section class="panel" aria-labelledby="h-invite">
      <h2 id="h-invite">${t("Invite somebody")}</h2>
      <${Invitations} />
    </section>
    <section class="panel known" aria-labelledby="h-known">
      <h2 id="h-known">${t("Who is known here")}</h2>
      <${Known} asked=${asked} />
    </section>
    ${asked.data &&
    html`<section class="panel" aria-labelledby="h-give">
      <h2 id="h-give">${t("Give a right")}</h2>
      <${Give} people=${asked.data} again=${asked.again} />
    </section>`}
    <section class="panel" aria-labelledby="h-passkeys">
      <h2 id="h-passkeys">${t("My passkeys")}</h2>
      <${Passkeys} />
    </section>
  </div>`;
}
