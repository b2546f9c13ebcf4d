// Passkeys: made by whoever has signed in, and shown instead of a code from then on.

import { Nothing, Said, dayAndTime, useAsked, useDeed } from "./asked.js";
import { html, useState } from "./lib.js";
import { ask, signedInAs } from "./store.js";
import { t } from "./texts.js";

/** Whether this browser can hold one for this page: it needs a name, and a safe way to it. */
export const possible = () =>
  Boolean(window.PublicKeyCredential) && isSecureContext && !/^[\d.]+$|:/.test(location.hostname);

const bytesOf = (text) =>
  Uint8Array.from(atob(text.replace(/-/g, "+").replace(/_/g, "/")), (letter) => letter.charCodeAt(0));

const textOf = (buffer) =>
  btoa(String.fromCharCode(...new Uint8Array(buffer)))
    .replace(/\+/g, "-")
    .replace(/\//g, "_")
    .replace(/=+$/, "");

const described = (credentials) => (credentials || []).map((each) => ({ ...each, id: bytesOf(each.id) }));

function answered(credential) {
  const { response } = credential;
  const parts = {};
  for (const name of ["clientDataJSON", "attestationObject", "authenticatorData", "signature", "userHandle"]) {
    if (response[name]) parts[name] = textOf(response[name]);
  }
  return {
    id: credential.id,
    rawId: textOf(credential.rawId),
    type: credential.type,
    response: parts,
    clientExtensionResults: credential.getClientExtensionResults(),
  };
}

const NOT_FOUND = 404; // its routes are not there without their library
const notHere = () => t("Passkeys are not installed on this gateway.");
const NOT_SHOWN = () => ({ ok: false, kind: "warn", text: t("No passkey was shown. Nothing was done.") });
const refused = (answer) => ({ ok: false, kind: "bad", text: answer.why });

/** Make one for whoever is signed in. */
async function make(name) {
  const asked = await ask("POST", "/v1/passkeys/options", {});
  if (!asked.ok) return refused(asked);
  const options = asked.data;
  let made;
  try {
    made = await navigator.credentials.create({
      publicKey: {
        ...options,
        challenge: bytesOf(options.challenge),
        user: { ...options.user, id: bytesOf(options.user.id) },
        excludeCredentials: described(options.excludeCredentials),
      },
    });
  } catch {
    return NOT_SHOWN();
  }
  const answer = await ask("POST", "/v1/passkeys", { credential: answered(made), name });
  if (!answer.ok) return refused(answer);
  return { ok: true, kind: "good", text: t("From now on {name} signs you in here.", { name: answer.data.name }) };
}

/** Sign in with whichever one its owner chooses; return why it was not possible. */
export async function signInByPasskey() {
  const asked = await ask("POST", "/v1/sessions/passkey/options", {});
  if (asked.status === NOT_FOUND) return notHere();
  if (!asked.ok) return asked.why;
  const options = asked.data;
  let shown;
  try {
    shown = await navigator.credentials.get({
      publicKey: {
        ...options,
        challenge: bytesOf(options.challenge),
        allowCredentials: described(options.allowCredentials),
      },
    });
  } catch {
    return NOT_SHOWN().text;
  }
  const answer = await ask("POST", "/v1/sessions/passkey", { credential: answered(shown) });
  if (answer.ok) await signedInAs(answer.data);
  return answer.why;
}

/** One's own passkeys, to make and to remove. */
export function Passkeys() {
  const asked = useAsked("/v1/passkeys", 60_000);
  const { said, waits, act } = useDeed();
  const [name, write] = useState("");
  const add = (event) => {
    event.preventDefault();
    act(() => make(name.trim())).then(() => {
      write("");
      asked.again();
    });
  };
  const remove = (key) =>
    act(async () => {
      const answer = await ask("DELETE", `/v1/passkeys/${encodeURIComponent(key.id)}`);
      return answer.ok ? { kind: "good", text: t("{name} signs nobody in any more.", { name: key.name }) } : refused(answer);
    }).then(asked.again);
  if (asked.status === NOT_FOUND) return html`<p class="quiet">${notHere()}</p>`;
  return html`<p class="quiet">
      ${t("A passkey signs you in by your finger, your face or a key, without a code from your chat.")}
    </p>
    ${asked.data?.length
      ? html`<ul class="list">
          ${asked.data.map(
            (key) => html`<li key=${key.id}>
              <span><b>${key.name}</b> <span class="quiet">${dayAndTime(key.made)}</span></span>
              <button type="button" class="plain" disabled=${waits} aria-label=${t("Remove {name}", { name: key.name })} onClick=${() => remove(key)}>
                ${t("Remove")}
              </button>
            </li>`,
          )}
        </ul>`
      : html`<${Nothing} asked=${asked} none=${t("You have no passkey here yet.")} />`}
    ${possible()
      ? html`<form class="row" onSubmit=${add}>
          <label class="field">
            ${t("What to call it")}
            <input maxlength="64" required autocomplete="off" value=${name} onInput=${(event) => write(event.target.value)} />
          </label>
          <button type="submit" class="main" disabled=${waits}>${t("Make a passkey")}</button>
        </form>`
      : html`<p class="quiet small">${t("This page is reached by a number or without encryption: passkeys need a name.")}</p>`}
    <${Said} said=${said} />`;
}
