// The page: which part of it is shown, who is signed in, and STOP beside all of it.

import { Alerts, useAlertCount } from "./alerts.js";
import { Questions } from "./asked.js";
import { Drive } from "./drive.js";
import { Files } from "./files.js";
import { Fleet } from "./fleet.js";
import { Health } from "./health.js";
import { History } from "./history.js";
import { html, render, useEffect, useLayoutEffect, useRef, useState } from "./lib.js";
import { Live } from "./live.js";
import { People } from "./people.js";
import { dropLinkedCode, SignIn, takeLinkedCode } from "./signin.js";
import { StopBar, StopSaid } from "./stop.js";
import { begin, changed, notice, signOut, state, useStore } from "./store.js";
import { t } from "./texts.js";
import { Times } from "./times.js";

const FIRST = "live";
const TABS = {
  live: { word: () => t("Live"), Tab: Live },
  drive: { word: () => t("Drive"), Tab: Drive },
  times: { word: () => t("Times"), Tab: Times },
  people: { word: () => t("People"), Tab: People },
  fleet: { word: () => t("Fleet"), Tab: Fleet },
  alerts: { word: () => t("Alerts"), Tab: Alerts },
  files: { word: () => t("Files"), Tab: Files },
  history: { word: () => t("History"), Tab: History },
  health: { word: () => t("Health"), Tab: Health },
};

function partOf() {
  const [part, named = ""] = location.hash.replace(/^#/, "").split("/");
  let robot = "";
  try {
    robot = decodeURIComponent(named);
  } catch {
    robot = ""; // an address may be typed
  }
  if (robot) state.chosen = robot; // on every tab, until another one is
  return { part: Object.hasOwn(TABS, part) ? part : FIRST, robot: robot || state.chosen };
}

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

function Tabs({ part }) {
  const count = useAlertCount();
  const here = useRef(null);
  useEffect(() => {
    const show = () => here.current?.scrollIntoView({ block: "nearest", inline: "nearest" });
    show();
    addEventListener("resize", show);
    return () => removeEventListener("resize", show);
  }, [part]);
  return html`<nav aria-label=${t("Parts")}>
    ${Object.entries(TABS).map(
      ([name, { word }]) =>
        html`<a
          href=${`#${name}`}
          ref=${part === name ? here : undefined}
          aria-current=${part === name ? "page" : undefined}
          >${word()}${name === "alerts" && count > 0 && html` <b class="count">${count}</b>`}</a
        >`,
    )}
  </nav>`;
}

function Page() {
  const { phase, me, notice: said, link } = useStore();
  const { part, robot } = useAddress();
  useEffect(() => {
    document.title = phase === "signed-in" && link !== "up" ? `✕ ROSIC` : "ROSIC";
  }, [phase, link]);
  useEffect(() => {
    if (phase === "signed-in") dropLinkedCode();
  }, [phase]);
  useLayoutEffect(() => void scrollTo(0, 0), [part]);
  if (phase === "starting") {
    return html`<main class="sign-in" id="main"><p class="quiet" role="status">ROSIC …</p></main>`;
  }
  if (phase === "signed-out") return html`<${SignIn} />`;
  const { Tab } = TABS[part];
  return html`<a class="skip" href="#main-part" onClick=${skip}>${t("To the content")}</a>
    <header class="top">
      <h1>ROSIC</h1>
      <${Link} />
      <p class="me">
        <span>${me.name}</span>
        <button type="button" class="plain" onClick=${signOut}>${t("Sign out")}</button>
      </p>
      <${Tabs} part=${part} />
      <${StopSaid} />
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
      ${part !== "drive" && html`<${Questions} key=${`questions ${part}`} />`}
      <${Tab} key=${part} robot=${robot} onRobot=${(id) => (location.hash = `${part}/${encodeURIComponent(id)}`)} />
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
