// Signing in: one field for the code that one's own chat gives.

import { html, useEffect, useState } from "./lib.js";
import { possible, signInByPasskey } from "./passkeys.js";
import { changed, signIn, useStore } from "./store.js";
import { t } from "./texts.js";

let linked = "";

function plain(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text; // it is no code, and the gateway says so
  }
}

/** Take a code out of the address: it is good once, and belongs into no history. */
export function takeLinkedCode() {
  const found = location.hash.match(/^#code=([^&]{1,64})$/);
  if (!found) return;
  linked = plain(found[1]);
  history.replaceState(null, "", location.pathname);
  changed();
}

/** Whoever is signed in needs none. */
export function dropLinkedCode() {
  linked = "";
}

/** What stands there while nobody is signed in. */
export function SignIn() {
  const { notice } = useStore();
  const [code, write] = useState("");
  const [why, tell] = useState("");
  const [waits, wait] = useState(false);

  async function enter(given) {
    if (!given.trim()) return;
    wait(true);
    const refused = await signIn(given.trim());
    if (refused) {
      tell(refused);
      wait(false);
    }
  }
  async function show() {
    wait(true);
    const refused = await signInByPasskey();
    if (refused) {
      tell(refused);
      wait(false);
    }
  }
  // Also where the page stood here already: a link that is opened again changes its address only.
  useEffect(() => {
    if (!linked || waits) return;
    const taken = linked;
    linked = "";
    write(taken);
    enter(taken);
  });

  return html`<main class="sign-in" id="main">
    <div class="panel">
      <h1>ROSIC</h1>
      ${notice && html`<p class="notice" role="status">${notice}</p>`}
      <p>${t("Write /signin to ROSIC in your own chat. It answers with a code.")}</p>
      <form
        onSubmit=${(event) => {
          event.preventDefault();
          enter(code);
        }}
      >
        <label for="code">${t("Code")}</label>
        <input
          id="code"
          value=${code}
          autocomplete="one-time-code"
          autocapitalize="characters"
          spellcheck="false"
          maxlength="64"
          required
          autofocus
          placeholder="XXXX-XXXX"
          aria-describedby="why"
          onInput=${(event) => write(event.target.value)}
        />
        <button type="submit" class="main" disabled=${waits}>${t("Sign in")}</button>
      </form>
      ${possible() &&
      html`<button type="button" disabled=${waits} onClick=${show}>${t("Sign in with a passkey")}</button>`}
      <p class="why" id="why" role="alert">${why}</p>
      <p class="quiet">
        ${t("No chat with ROSIC yet? Ask whoever runs it for an invitation. The code is good for 5 minutes, once; show it to nobody.")}
      </p>
      <p class="quiet">
        ${t("To stop a robot now, write stop in your chat, or use the stop on the robot itself.")}
      </p>
    </div>
  </main>`;
}
