// History: what was asked before and what came of it; searched, and saved as a table.

import { dayAndTime, Nothing, RobotChoice, useAsked } from "./asked.js";
import { html, useState } from "./lib.js";
import { stageWord } from "./orders.js";
import { Pill } from "./robots.js";
import { useStore } from "./store.js";
import { t } from "./texts.js";

const DAY_S = 86_400;
const MOST = 1000;
const GOOD = new Set(["done", "resumed", "sent"]);

function kindWord(entry) {
  const words = {
    claimed: t("asked"),
    refused: t("refused"),
    resumed: t("resumed"),
    stopped: t("stopped"),
  };
  return words[entry.kind] || entry.kind;
}

function pillOf(entry) {
  if (entry.kind === "refused" || entry.outcome === "failed") return "bad";
  if (entry.kind === "stopped") return "warn";
  return GOOD.has(entry.outcome) ? "good" : "quiet";
}

/** Return a field of a table as spreadsheets read it; nothing in it is a formula. */
export function field(value) {
  const text = /^[=+\-@\t\r]/.test(value) ? `'${value}` : value;
  return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

function save(entries) {
  const head = ["at", "who", "kind", "robot", "skill", "outcome", "ended"];
  const rows = entries.map((entry) => head.map((name) => field(entry[name] ?? "")).join(","));
  const url = URL.createObjectURL(new Blob([[head.join(","), ...rows].join("\r\n")], { type: "text/csv" }));
  const link = document.createElement("a");
  link.href = url;
  link.download = `rosic-history-${new Date().toISOString().slice(0, 10)}.csv`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

function Entry({ entry }) {
  const { robots } = useStore();
  return html`<tr>
    <td data-head=${t("Time")}>${dayAndTime(entry.at)}</td>
    <td data-head=${t("Who")}>${entry.who}</td>
    <th scope="row" data-head=${t("Robot")}>${robots.get(entry.robot)?.name || entry.robot || "—"}</th>
    <td data-head=${t("Skill")}>${entry.skill || "—"}</td>
    <td data-head=${t("What")}><${Pill} kind=${pillOf(entry)}>${kindWord(entry)}<//></td>
    <td data-head=${t("How it ended")}>${stageWord(entry.outcome.replaceAll("-", " ")) || "—"}</td>
  </tr>`;
}

/** The tab. */
export function History() {
  const [robot, choose] = useState("");
  const [days, since] = useState(1);
  const [sought, seek] = useState("");
  const asked = useAsked(
    `/v1/history?limit=${MOST}&since_s=${days * DAY_S}${robot && `&robot=${encodeURIComponent(robot)}`}`,
  );
  const words = sought.toLowerCase().split(/\s+/).filter(Boolean);
  const found = (asked.data || []).filter((entry) => {
    const text = [entry.who, entry.kind, entry.robot, entry.skill, entry.outcome].join(" ").toLowerCase();
    return words.every((word) => text.includes(word));
  });
  return html`<section class="panel" aria-labelledby="h-history">
    <h2 id="h-history">${t("What was asked, and what came of it")}</h2>
    <div class="row filters" role="search">
      <${RobotChoice} value=${robot} onChoose=${choose} every=${t("What I asked of any robot")} />
      <label class="field">
        ${t("Since")}
        <select value=${days} onChange=${(event) => since(Number(event.target.value))}>
          <option value="1">${t("yesterday")}</option>
          <option value="7">${t("a week ago")}</option>
          <option value="31">${t("a month ago")}</option>
          <option value="366">${t("a year ago")}</option>
        </select>
      </label>
      <label class="field wide">
        ${t("Search")}
        <input type="search" maxlength="100" value=${sought} onInput=${(event) => seek(event.target.value)} />
      </label>
      <button type="button" disabled=${!found.length} onClick=${() => save(found)}>${t("Save as a table")}</button>
    </div>
    <p class="quiet small" role="status">
      ${asked.data && t("{found} of {all} are shown.", { found: found.length, all: asked.data.length })}
    </p>
    ${found.length
      ? html`<div class="scroll tall" tabindex="0" role="region" aria-label=${t("History")}>
          <table class="stacked">
            <thead>
              <tr>
                <th scope="col">${t("Time")}</th>
                <th scope="col">${t("Who")}</th>
                <th scope="col">${t("Robot")}</th>
                <th scope="col">${t("Skill")}</th>
                <th scope="col">${t("What")}</th>
                <th scope="col">${t("How it ended")}</th>
              </tr>
            </thead>
            <tbody>
              ${found.map((each, index) => html`<${Entry} key=${`${each.at} ${index}`} entry=${each} />`)}
            </tbody>
          </table>
        </div>`
      : html`<${Nothing} asked=${asked} none=${t("Nothing is found. Look further back, or for something else.")} />`}
  </section>`;
}
