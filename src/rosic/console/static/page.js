// The page: which part of it is shown, who is signed in, and STOP beside all of it.

import { Drive } from "./drive.js";
import { html, render, useEffect, useState } from "./lib.js";
import { Live } from "./live.js";
import { SignIn, takeLinkedCode } from "./signin.js";
import { StopBar } from "./stop.js";
import { begin, changed, notice, signOut, state, useStore } from "./store.js";
import { t } from "./texts.js";

const partOf = () => {
  const [part, robot = ""] = location.hash.replace(/^#/, "").split("/");
  return { part: part === "drive" ? part : "live", robot: decodeURIComponent(robot) };
};

function useAddress() {
  const [at, go] = useState(partOf);
  useEffect(() => {
    const moved = () => {
      takeLinkedCode();
      go(partOf());
    };
    addEventListener("hashchange", moved);
    return () => removeEventListener("hashchange", moved);
  }, []);
  return at;
}

function Link() {
  const { link } = useStore();
  const words = {
    up: t("Gateway connected"),
    connecting: t("Connecting …"),
    lost: t("No connection to the gateway"),
  };
  return html`<p class=${`link ${link}`} role="status">
    <span aria-hidden="true">${link === "up" ? "●" : "✕"}</span> ${words[link]}
  </p>`;
}

function Page() {
  const { phase, me, notice: said, link } = useStore();
  const { part, robot } = useAddress();
  useEffect(() => {
    document.title = phase === "signed-in" && link !== "up" ? `✕ ROSIC` : "ROSIC";
  }, [phase, link]);
  if (phase === "starting") {
    return html`<main class="sign-in" id="main"><p class="quiet" role="status">ROSIC …</p></main>`;
  }
  if (phase === "signed-out") return html`<${SignIn} />`;
  const parts = [
    ["live", t("Live")],
    ["drive", t("Drive")],
  ];
  return html`<a class="skip" href="#main-part" onClick=${skip}>${t("To the content")}</a>
    <header class="top">
      <h1>ROSIC</h1>
      <nav aria-label=${t("Parts")}>
        ${parts.map(
          ([name, word]) =>
            html`<a href=${`#${name}`} aria-current=${part === name ? "page" : undefined}>${word}</a>`,
        )}
      </nav>
      <${Link} />
      <p class="me">
        <span>${me.name}</span>
        <button type="button" class="plain" onClick=${signOut}>${t("Sign out")}</button>
      </p>
    </header>
    <${StopBar} />
    ${said &&
    html`<p class="notice top-notice" role="status">
      ${said} <button type="button" class="plain" onClick=${() => notice("")}>${t("Dismiss")}</button>
    </p>`}
    <main id="main-part" tabindex="-1">
      ${link === "lost" &&
      html`<p class="notice lost" role="alert">
        ${t("No connection to the gateway: nothing here is of now. It is tried again by itself.")}
      </p>`}
      ${part === "drive"
        ? html`<${Drive} robot=${robot} onRobot=${(id) => (location.hash = `drive/${encodeURIComponent(id)}`)} />`
        : html`<${Live} />`}
    </main>`;
}

function skip(event) {
  event.preventDefault();
  document.getElementById("main-part").focus();
}

takeLinkedCode();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
render(html`<${Page} />`, document.getElementById("page"));
if (state.phase === "starting") begin();
