// History: what was asked before and what came of it; searched, and saved as a table.

import { dayAndTime, Nothing, RobotChoice, useAsked } from "./asked.js";
import { html, Table, useEffect, useState } from "./lib.js";
import { stageWord } from "./orders.js";
import { Pill } from "./robots.js";
import { useStore } from "./store.js";
import { t } from "./texts.js";

const DAY_S = 86_400;
const MOST = 200;
const TYPING_MS = 300;
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

function Entry({ entry }) {
  const { robots } = useStore();
  return html`<tr>
    <td data-head=${t("Time")}>${dayAndTime(entry.at)}</td>
    <td data-head=${t("Who")}>${entry.who}</td>
    <th scope="row" data-head=${t("Robot")}>${robots.get(entry.robot)?.name || entry.robot || "—"}</th>
    <td data-head=${t("Asked")}>${entry.asked || entry.skill || "—"}</td>
    <td data-head=${t("Kind")}><${Pill} kind=${pillOf(entry)}>${kindWord(entry)}<//></td>
    <td data-head=${t("How it ended")}>${entry.came || stageWord(entry.outcome.replaceAll("-", " ")) || "—"}</td>
  </tr>`;
}

/** The tab. */
export function History() {
  const [robot, choose] = useState("");
  const [days, since] = useState(1);
  const [sought, seek] = useState("");
  const [text, settle] = useState("");
  useEffect(() => {
    const timer = setTimeout(() => settle(sought.trim()), TYPING_MS);
    return () => clearTimeout(timer);
  }, [sought]);
  const query = `since_s=${days * DAY_S}&robot=${encodeURIComponent(robot)}&text=${encodeURIComponent(text)}`;
  const asked = useAsked(`/v1/history?limit=${MOST}&${query}`);
  const found = asked.data || [];
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
      <a class="button" href=${`/v1/history/export?${query}`} download="rosic-history.csv">${t("Save as a table")}</a>
    </div>
    <p class="quiet small" role="status">
      ${asked.data &&
      (found.length < MOST
        ? t("{count} found", { count: found.length })
        : t("The newest {count} are shown; the table has more.", { count: MOST }))}
    </p>
    ${found.length
      ? html`<${Table}
          label=${t("History")}
          kind="stacked"
          tall
          heads=${[t("Time"), t("Who"), t("Robot"), t("Asked"), t("Kind"), t("How it ended")]}
        >
          <tbody>
            ${found.map((each, index) => html`<${Entry} key=${`${each.at} ${index}`} entry=${each} />`)}
          </tbody>
        <//>`
      : html`<${Nothing} asked=${asked} none=${t("Nothing is found. Look further back, or for something else.")} />`}
  </section>`;
}
