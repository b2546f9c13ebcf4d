// STOP: always in view, on the space bar, and true when it says "at rest".

import { html, newId, useEffect } from "./lib.js";
import { ask, changed, listen, send, state, useStore } from "./store.js";
import { clock, t } from "./texts.js";

const PONG_MS = 500;
const ANSWER_MS = 20_000;

/** Stop every robot that one may see: over the connection, and over REST if nothing answers. */
export function stopAll() {
  const id = newId();
  state.stop = { id, phase: "stopping", text: "" };
  held = new Set();
  const handed = send({ op: "stop", robots: [], id });
  if (handed) {
    send({ op: "ping", id: `after ${id}` });
    const hears = listen("pong", (pong) => pong.id === `after ${id}` && answered());
    const lost = listen("gone", () => answered() && byRest(id));
    const late = setTimeout(() => answered() && byRest(id), PONG_MS);
    let waits = true;
    function answered() {
      const first = waits;
      waits = false;
      clearTimeout(late);
      hears();
      lost();
      return first;
    }
    const after = listen("gone", () => {
      after();
      if (state.stop?.id === id && state.stop.phase === "stopping") byRest(id);
    });
  } else byRest(id);
  setTimeout(() => end(id, null, ""), ANSWER_MS);
  changed();
}

async function byRest(id) {
  const answer = await ask("POST", "/v1/stop", {});
  if (answer.ok) end(id, answer.data.at_rest, answer.data.text);
  else end(id, null, answer.status ? answer.why : t("The gateway does not answer."));
}

function end(id, atRest, text) {
  if (state.stop?.id !== id || state.stop.phase !== "stopping") return;
  const at = new Date().toISOString();
  state.stop = { id, phase: atRest === true ? "at-rest" : "not-confirmed", text, at };
  for (const robot of state.robots.values()) if (robot.stopped) held.add(robot.id);
  changed();
}

let held = new Set(); // robots that stand by the newest stop

/** What was said of a stop is true until one of its robots goes on. */
function moved({ robot }) {
  const { stop } = state;
  if (!stop) return;
  const resumed = held.has(robot.id) && !robot.stopped;
  if (resumed) held.delete(robot.id);
  else if (robot.stopped) held.add(robot.id);
  const rests = (id) => state.robots.get(id)?.presence.at_rest === true;
  const over = {
    "at-rest": resumed || robot.presence.at_rest === false,
    "not-confirmed": resumed && [...held].every(rests),
  };
  if (over[stop.phase]) state.stop = null;
}

listen("robot", moved);

listen("stop", ({ id, stop }) => end(id, stop.at_rest, stop.text));
listen("problem", ({ id, problem }) => id && end(id, null, problem.detail));

const TYPING = "input, textarea, [contenteditable]";
const NOT_TYPED = ["range", "checkbox", "radio", "button", "submit", "reset", "file", "image"];

/** Whether a space is a letter there; where nothing is typed, as on a slider, it is a stop. */
const types = (field) => Boolean(field) && !NOT_TYPED.includes(field.type);

function onKey(event) {
  if (event.code !== "Space" || types(event.target.closest?.(TYPING)) || event.isComposing) return;
  event.preventDefault();
  if (event.type === "keydown" && !event.repeat && state.phase === "signed-in") stopAll();
}

let pressedAt = -Infinity;

function onPress(event) {
  if (!event.isPrimary || event.button !== 0) return;
  pressedAt = performance.now();
  stopAll();
}

function onClick() {
  if (performance.now() - pressedAt > 1000) stopAll(); // by a key, or by what reads the page aloud
}

function dismiss() {
  state.stop = null;
  changed();
}

/** What came of the newest stop: a part of the header, which lies over nothing that cannot be scrolled
 *  from under it. What is not confirmed cannot be put away. */
export function StopSaid() {
  const { stop } = useStore();
  const said = {
    stopping: t("Stopping …"),
    "at-rest": t("At rest"),
    "not-confirmed": t("Not confirmed: look!"),
  };
  return html`<p
    class=${`stop-said ${stop ? stop.phase : ""}`}
    role="status"
    aria-live="assertive"
    tabindex=${stop ? "0" : undefined}
  >
    ${stop && html`<strong>${said[stop.phase]}</strong> ${stop.at && html`<time>${clock(stop.at)}</time>${" "}`}<span>${stop.text}</span>`}
    ${stop?.phase === "at-rest" &&
    html` <button type="button" class="plain" onClick=${dismiss}>${t("Dismiss")}</button>`}
  </p>`;
}

/** The bar that is in view on every page. */
export function StopBar() {
  useEffect(() => {
    addEventListener("keydown", onKey, true);
    addEventListener("keyup", onKey, true);
    return () => {
      removeEventListener("keydown", onKey, true);
      removeEventListener("keyup", onKey, true);
    };
  }, []);
  return html`<section class="stopbar" aria-label=${t("Stop")}>
    <button
      class="stop"
      type="button"
      aria-keyshortcuts="Space"
      onPointerDown=${onPress}
      onClick=${onClick}
    >
      <span class="stop-word">STOP</span> <span class="stop-how">${t("all robots")}<span class="by-key"> · ${t("space bar")}</span></span>
    </button>
  </section>`;
}
