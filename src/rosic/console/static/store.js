// What the page knows, and the one connection by which it hears of it.
//
// The page knows nothing that the gateway has not said, and says so when it hears nothing: what was
// true before the connection was lost is shown as unknown.

import { newId, useEffect, useState } from "./lib.js";
import { ofBrowser, speak, t } from "./texts.js";

const PING_MS = 400;
const MISSED_AT_MOST = 2; // pings without a word: so a cut link is said within 2 s
const RETRY_MS = [200, 400, 800, 1500];
const ENDED = 4401;
const ORDERS_KEPT = 200;
const MESSAGES_KEPT = 200;
const TRACK_KEPT = 400;
const HISTORY_KEPT = 2000;
const UNHEARD_MS = 3000;
const CHOOSES = /^\/?(language|sprache)\b/i;

export const state = {
  phase: "starting", // starting, signed-out, signed-in
  me: null,
  link: "connecting", // connecting, up, lost
  notice: "",
  robots: new Map(),
  robotsTold: false, // whether one would have been heard of by now, if there is any
  words: new Map(), // robot -> what its skills and values are called, by name
  orders: new Map(),
  messages: new Map(),
  tracks: new Map(),
  history: new Map(), // robot -> value -> [[seconds], [values]]
  sentAt: new Map(), // order -> when this page first saw it sent and not received
  rates: null,
  stale: new Set(), // robots that were not heard of since the connection is back
  gone: new Map(), // robot -> its name, once it is not there any more
  abilities: new Set(), // what this gateway's connection can do besides
  stop: null,
  chosen: "", // robot
};

const watching = new Set();
const hearing = new Map();
let drawn = 0;

/** Have everybody who shows something look again, at most twenty times a second. */
export function changed() {
  if (drawn) return;
  drawn = setTimeout(() => {
    drawn = 0;
    for (const look of watching) look();
  }, 50);
}

/** Look at the state, now and whenever it changes. */
export function useStore() {
  const [, look] = useState(0);
  useEffect(() => {
    const again = () => look((n) => n + 1);
    watching.add(again);
    return () => watching.delete(again);
  }, []);
  return state;
}

/** Call somebody with every event of a kind; return what ends that. */
export function listen(kind, hear) {
  const those = hearing.get(kind) || new Set();
  hearing.set(kind, those.add(hear));
  return () => those.delete(hear);
}

/** Say something to whoever looks at the page, until it is dismissed. */
export function notice(sentence) {
  state.notice = sentence;
  changed();
}

// ---- REST ----

/** Ask the gateway; return { ok, status, data, why }: `why` is one sentence where it was not done. */
export const ask = (method, path, body, headers = {}) =>
  request(method, path, {
    headers: body === undefined ? headers : { "Content-Type": "application/json", ...headers },
    body: body === undefined ? undefined : JSON.stringify(body),
  });

/** Send a file to be kept. */
export const upload = (file) =>
  request("POST", `/v1/files?name=${encodeURIComponent(file.name)}`, {
    headers: { "Content-Type": "application/octet-stream" },
    body: file,
  });

async function request(method, path, sent) {
  let answer;
  try {
    answer = await fetch(path, { method, cache: "no-store", ...sent });
  } catch {
    return { ok: false, status: 0, data: null, why: t("The gateway does not answer.") };
  }
  let data = null;
  try {
    data = answer.status === 204 ? null : await answer.json();
  } catch {
    data = null;
  }
  if (answer.status === 401 && state.phase === "signed-in") {
    signedOut((data && data.detail) || t("Your session has ended."));
  }
  const why = answer.ok ? "" : (data && data.detail) || t("The gateway does not answer.");
  return { ok: answer.ok, status: answer.status, data, why };
}

// ---- the session ----

/** Find out whether somebody is signed in here. */
export async function begin() {
  await speak(ofBrowser());
  const me = await ask("GET", "/v1/me");
  if (me.ok) await signedIn(me.data);
  else if (me.status === 401) signedOut("");
  else {
    state.link = "lost";
    changed();
    setTimeout(begin, 1000);
  }
}

/** Sign in by a code; return why it was not possible. */
export async function signIn(code) {
  const answer = await ask("POST", "/v1/sessions", { code });
  if (answer.ok) await signedIn(answer.data);
  return answer.why;
}

export async function signOut() {
  await ask("DELETE", "/v1/sessions/current");
  signedOut("");
}

/** Somebody has signed in here by a way of their own. */
export const signedInAs = (me) => signedIn(me);

/** Speak as whoever is signed in wants to be spoken to now. */
export async function relearn() {
  const me = await ask("GET", "/v1/me");
  if (!me.ok || state.phase !== "signed-in") return;
  state.me = me.data;
  await speak(me.data.language);
  learnWords();
  changed();
}

let learning = 0;

/** Learn what skills and values of robots are called to whoever is signed in: events leave that out. */
function learnWords() {
  clearTimeout(learning);
  learning = setTimeout(async () => {
    const found = await ask("GET", "/v1/robots");
    if (!found.ok) return;
    for (const { id, words } of found.data) state.words.set(id, words);
    changed();
  }, 50);
}

async function signedIn(me) {
  state.me = me;
  state.phase = "signed-in";
  state.notice = "";
  connect();
  changed();
}

function signedOut(why) {
  state.phase = "signed-out";
  state.me = null;
  for (const each of ["robots", "words", "orders", "messages", "tracks", "history", "sentAt", "gone", "stale"]) {
    state[each].clear();
  }
  state.rates = null;
  state.robotsTold = false;
  state.notice = why;
  run = ""; // whoever signs in next has lost no connection
  state.chosen = "";
  drop();
  changed();
}

// ---- the connection ----

let socket = null;
let run = "";
let tries = 0;
let missed = 0; // counted, not timed: a page that stood still itself has missed nothing
let looked = 0;
let asked = [];
let retry = 0;
let unheard = 0;
let choosing = false; // a language; the answer says when it counts

function connect() {
  drop();
  clearTimeout(retry);
  const mine = new WebSocket(`${location.origin.replace("http", "ws")}/v1/events`);
  socket = mine;
  missed = 0;
  mine.onmessage = (message) => socket === mine && hear(JSON.parse(message.data));
  mine.onclose = (closed) => socket === mine && gone(closed.code, closed.reason);
}

function drop() {
  const before = socket;
  socket = null;
  if (before) before.close();
}

/** Send something at once; return whether there is a connection that hears. */
export function send(said) {
  if (!socket || socket.readyState !== WebSocket.OPEN || state.link !== "up") return false;
  socket.send(JSON.stringify(said));
  return true;
}

async function gone(code, reason) {
  const wasUp = state.link === "up";
  drop();
  if (state.phase !== "signed-in") return;
  state.link = "lost";
  state.rates = null;
  for (const each of hearing.get("gone") || []) each();
  changed();
  if (code === ENDED) {
    signedOut(reason || t("Your session has ended."));
    return;
  }
  if (!wasUp && tries > 0) {
    const me = await ask("GET", "/v1/me"); // a refused handshake does not say why
    if (state.phase !== "signed-in") return;
    if (me.status === 0) await new Promise((wake) => setTimeout(wake, 100));
  }
  clearTimeout(retry);
  retry = setTimeout(connect, RETRY_MS[Math.min(tries++, RETRY_MS.length - 1)]);
}

setInterval(() => {
  if (!socket) return;
  if (missed > MISSED_AT_MOST) gone(0, "");
  else send({ op: "ping", id: "" });
  const late = performance.now() - looked > 2 * PING_MS;
  looked = performance.now();
  if (!late) missed += 1;
}, PING_MS);

function subscribe(topics) {
  asked = topics;
  send({ op: "subscribe", topics });
}

const heard = {
  hello({ me, run: now, abilities }) {
    state.me = me;
    speak(me.language).then(changed);
    state.link = "up";
    tries = 0;
    if (run) {
      notice(
        run === now
          ? t("The connection is back.")
          : t("The gateway was restarted. The page is back by itself."),
      );
    }
    run = now;
    state.abilities = new Set(abilities || []);
    forgetUnheard();
    learnWords();
    subscribe(["robots", "orders", "chat", "rates"]);
  },
  robot({ robot }) {
    if (!state.robots.has(robot.id)) learnWords();
    state.robots.set(robot.id, robot);
    state.robotsTold = true;
    state.stale.delete(robot.id);
    state.gone.delete(robot.id);
    keepTrack(robot);
  },
  "robot-gone"({ robot }) {
    forget(robot);
  },
  order({ order }) {
    state.orders.set(order.id, order);
    noteSent(order);
    while (state.orders.size > ORDERS_KEPT) {
      const oldest = state.orders.keys().next().value;
      state.orders.delete(oldest);
      state.sentAt.delete(oldest);
    }
  },
  message({ message }) {
    state.messages.set(message.id, message);
    if (message.own && CHOOSES.test(message.text)) choosing = true;
    else if (choosing && !message.own) {
      choosing = false;
      relearn();
    }
    if (state.messages.size > MESSAGES_KEPT) {
      state.messages.delete(state.messages.keys().next().value);
    }
  },
  rates({ messengers, robots }) {
    state.rates = {
      messengers,
      robots: new Map(robots.map((each) => [each.robot, each])),
    };
  },
  problem({ id }) {
    // An older gateway counts no rates: then they are not shown.
    if (!id && asked.includes("rates")) subscribe(asked.filter((topic) => topic !== "rates"));
  },
};

function hear(event) {
  missed = 0;
  if (heard[event.event]) heard[event.event](event);
  for (const each of hearing.get(event.event) || []) each(event);
  if (event.event !== "pong") changed();
}

// ---- what is kept of what was heard ----

function forget(robot) {
  const known = state.robots.get(robot);
  if (known) state.gone.set(robot, known.name);
  state.robots.delete(robot);
  state.stale.delete(robot);
}

/** After a break every robot is told of anew; what is not is not there any more. */
function forgetUnheard() {
  state.stale = new Set(state.robots.keys());
  clearTimeout(unheard);
  unheard = setTimeout(() => {
    if (state.link !== "up") return;
    for (const robot of state.stale) forget(robot);
    state.robotsTold = true;
    changed();
  }, UNHEARD_MS);
}

/** Put what the gateway kept of a value before what this page has heard of it. */
export function recall(robot, name, samples) {
  const of = state.history.get(robot) || new Map();
  state.history.set(robot, of);
  const [times, values] = of.get(name) || [[], []];
  const before = samples
    .map(({ at, value }) => [Date.parse(at) / 1000, value])
    .filter(([at]) => !times.length || at < times[0]);
  of.set(name, [
    [...before.map(([at]) => at), ...times],
    [...before.map(([, value]) => value), ...values],
  ]);
  changed();
}

function noteSent(order) {
  const stages = order.stages.map((stage) => stage.stage);
  const open = stages.includes("sent") && !stages.includes("received");
  if (!open) state.sentAt.delete(order.id);
  else if (!state.sentAt.has(order.id)) state.sentAt.set(order.id, performance.now());
}

function keepTrack(robot) {
  const pose = robot.presence.pose;
  if (!pose) return;
  const track = state.tracks.get(robot.id) || [];
  const last = track[track.length - 1];
  if (last && last.frame === pose.frame && Math.hypot(last.x - pose.x_m, last.y - pose.y_m) < 0.01) {
    return;
  }
  track.push({ x: pose.x_m, y: pose.y_m, frame: pose.frame });
  if (track.length > TRACK_KEPT) track.shift();
  state.tracks.set(robot.id, track);
}

setInterval(() => {
  if (state.link !== "up") return;
  const now = Date.now() / 1000;
  for (const robot of state.robots.values()) {
    if (robot.presence.online === false) continue;
    const of = state.history.get(robot.id) || new Map();
    state.history.set(robot.id, of);
    for (const [name, value] of Object.entries(robot.presence.values)) {
      if (typeof value !== "number") continue;
      const series = of.get(name) || [[], []];
      of.set(name, series);
      series[0].push(now);
      series[1].push(value);
      if (series[0].length > HISTORY_KEPT) series.forEach((each) => each.shift());
    }
  }
  if (state.robots.size) changed();
}, 1000);

export { newId };
