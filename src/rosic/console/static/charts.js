// What robots measure, over time: charts by uPlot.

import { html, useEffect, useRef, useState } from "./lib.js";
import { called } from "./robots.js";
import { ask, recall, state, useStore } from "./store.js";
import { clock, number, spoken, t, unitSign } from "./texts.js";

const HEIGHT = 190;
const PICTURE_MS = 5000;
const STILL_MS = 20_000; // a picture of what does not move is worth less than the work
const KEPT_S = 900;

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

function axis(extra = {}) {
  return {
    stroke: colour("--mute"),
    grid: { stroke: colour("--line"), width: 1 },
    ticks: { stroke: colour("--line"), width: 1 },
    font: "12px system-ui, sans-serif",
    ...extra,
  };
}

const timeOf = (seconds) =>
  new Date(seconds * 1000).toLocaleTimeString(spoken(), {
    hour: "2-digit",
    minute: "2-digit",
    second: "2-digit",
    hourCycle: "h23",
  });

/** One value over time. */
function Chart({ data, label }) {
  const place = useRef(null);
  const plot = useRef(null);
  useEffect(() => {
    const there = place.current;
    const options = {
      width: there.clientWidth || 400,
      height: HEIGHT,
      legend: { show: false },
      cursor: { points: { size: 6 } },
      axes: [
        axis({ values: (_, ticks) => ticks.map(timeOf), space: 90 }),
        axis({ size: 58, values: (_, ticks) => ticks.map((each) => number(each, 3)) }),
      ],
      series: [{}, { stroke: colour("--accent"), width: 2, points: { show: false } }],
    };
    plot.current = new uPlot(options, data, there);
    const resized = new ResizeObserver(() =>
      plot.current.setSize({ width: there.clientWidth, height: HEIGHT }),
    );
    resized.observe(there);
    return () => {
      resized.disconnect();
      plot.current.destroy();
    };
  }, [label]);
  const newest = data[0].length && data[0][data[0].length - 1];
  useEffect(() => plot.current?.setData([[...data[0]], [...data[1]]]), [newest, data[0].length]);
  return html`<div class="chart" ref=${place}></div>`;
}

/** The telemetry of one robot: a value to choose, its newest and its history. */
export function Telemetry({ robot }) {
  const { history, link } = useStore();
  const [wanted, choose] = useState("");
  const of = history.get(robot.id) || new Map();
  const numbers = Object.keys(robot.presence.values).filter(
    (name) => typeof robot.presence.values[name] === "number",
  );
  const words = Object.entries(robot.presence.values).filter(
    ([, value]) => typeof value !== "number",
  );
  const name = numbers.includes(wanted) ? wanted : numbers[0];
  const unit = unitSign((name && robot.units[name]) || "");
  const data = (name && of.get(name)) || [[], []];
  useEffect(() => {
    if (!name || link !== "up") return;
    const path = `/v1/robots/${encodeURIComponent(robot.id)}/telemetry?since_s=${KEPT_S}`;
    ask("GET", `${path}&value=${encodeURIComponent(name)}`).then((answer) => {
      if (answer.ok) recall(robot.id, name, answer.data.samples);
    });
  }, [robot.id, name, link === "up"]);
  if (!numbers.length && !words.length) {
    return html`<p class="quiet">${t("{robot} measures nothing that is shown here.", { robot: robot.name })}</p>`;
  }
  return html`<div>
    ${name &&
    html`<div class="row">
        <label class="field">
          ${t("Value")}
          <select value=${name} onChange=${(event) => choose(event.target.value)}>
            ${numbers.map((each) => html`<option value=${each}>${called(robot, each)}</option>`)}
          </select>
        </label>
        <p class="newest"><b>${number(robot.presence.values[name], 2)}</b> ${unit}</p>
      </div>
      <${Chart} data=${data} label=${`${robot.id} ${name}`} />
      <p class="quiet small">${t("What the gateway kept of it, and what came since.")}</p>`}
    ${words.length > 0 &&
    html`<dl class="facts">
      ${words.map(([key, value]) => html`<div><dt>${called(robot, key)}</dt><dd>${value}</dd></div>`)}
    </dl>`}
  </div>`;
}

/** What a robot's camera sees, again and again while it can be had. */
export function Camera({ robot }) {
  const [shown, show] = useState({ url: "", why: "" });
  const offers = robot.views.includes("picture");
  useEffect(() => {
    if (!offers) return undefined;
    let over = false;
    let timer = 0;
    let url = "";
    async function look() {
      let next = PICTURE_MS;
      if (!document.hidden && state.link === "up") {
        const answer = await fetch(`/v1/robots/${encodeURIComponent(robot.id)}/views/picture?low=true`).catch(
          () => null,
        );
        if (over) return;
        if (answer?.ok) {
          const before = url;
          url = URL.createObjectURL(await answer.blob());
          show({ url, why: "", taken: answer.headers.get("rosic-taken") });
          if (before) setTimeout(() => URL.revokeObjectURL(before), 1000);
          if (state.robots.get(robot.id)?.presence.at_rest) next = STILL_MS;
        } else {
          const problem = await answer?.json().catch(() => null);
          show({ url: "", why: problem?.detail || t("There is no picture now.") });
          next = Math.max(STILL_MS, 1000 * (problem?.retry_after_s || 0));
        }
      }
      timer = setTimeout(look, next);
    }
    look();
    return () => {
      over = true;
      clearTimeout(timer);
      if (url) URL.revokeObjectURL(url);
    };
  }, [robot.id, offers]);
  if (!offers) return html`<p class="quiet">${t("{robot} has no camera.", { robot: robot.name })}</p>`;
  if (!shown.url) return html`<p class="quiet ${shown.why ? "" : "camera"}">${shown.why || t("One moment …")}</p>`;
  return html`<figure>
    <img class="camera" src=${shown.url} alt=${t("What {robot} sees now", { robot: robot.name })} />
    ${shown.taken && html`<figcaption class="quiet small">${t("Taken at {time}.", { time: clock(shown.taken) })}</figcaption>`}
  </figure>`;
}
