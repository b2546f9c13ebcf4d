// Health: what the doctor finds of the record, the disk, messengers and robots; what is measured.

import { Nothing, useAsked } from "./asked.js";
import { html, Table } from "./lib.js";
import { stageWord } from "./orders.js";
import { Pill } from "./robots.js";
import { state } from "./store.js";
import { spoken, t } from "./texts.js";

const EVERY_MS = 15_000;
const KINDS = { good: "good", look: "bad", "not-measured": "unknown" };
const FIRST = { look: 0, "not-measured": 1, good: 2 };

function verdictWord(name) {
  const words = { good: t("good"), look: t("look at this"), "not-measured": t("not measured") };
  return words[name] || name;
}

function aboutWord(name) {
  const words = { data: t("Record"), record: t("Record"), disk: t("Disk"), space: t("Disk"), memory: t("Memory") };
  return state.robots.get(name)?.name || words[name] || name;
}

/** Return what a figure is of: a robot by its name, stages by their words. */
function labelWord([kind, of]) {
  if (kind === "robot") return state.robots.get(of)?.name || of;
  return kind === "hop" ? of.split("-").map(stageWord).join(" → ") : stageWord(of);
}

function number(value, kind) {
  if (kind === "histogram") return t("{value} ms on average", { value: (value * 1000).toLocaleString(spoken(), { maximumFractionDigits: 1 }) });
  return value.toLocaleString(spoken(), { maximumFractionDigits: 2 });
}

function Metrics() {
  const asked = useAsked("/v1/metrics", EVERY_MS);
  const found = asked.data || [];
  return html`<section class="panel" aria-labelledby="h-metrics">
    <h2 id="h-metrics">${t("What is measured")}</h2>
    ${found.length
      ? html`<${Table}
          label=${t("What is measured")}
          kind="figures"
          heads=${[t("Measure"), t("Of what"), t("Value")]}
        >
          ${found.map(
            (each) => html`<tbody key=${each.name}>
              ${each.figures.map(
                (figure, at) => html`<tr key=${JSON.stringify(figure.labels)}>
                  ${at === 0 &&
                  html`<th scope="rowgroup" rowspan=${each.figures.length}>${each.about}<code class="quiet small">${each.name}</code></th>`}
                  <td>${Object.entries(figure.labels).map(labelWord).join(", ") || "—"}</td>
                  <td class="number">
                    ${number(figure.value, each.kind)}
                    ${figure.count !== null && html`<span class="quiet small">${t("{count} times", { count: figure.count })}</span>`}
                  </td>
                </tr>`,
              )}
            </tbody>`,
          )}
        <//>`
      : html`<${Nothing} asked=${asked} none=${t("Nothing was looked at.")} />`}
  </section>`;
}

/** The tab: what has to be looked at comes first. */
export function Health() {
  const asked = useAsked("/v1/health", EVERY_MS);
  const found = [...(asked.data || [])].sort((one, other) => FIRST[one.verdict] - FIRST[other.verdict]);
  return html`<div class="health">
    <section class="panel" aria-labelledby="h-health">
    <h2 id="h-health">${t("What the doctor finds")}</h2>
    ${found.length
      ? html`<ul class="list findings">
          ${found.map(
            (each) => html`<li key=${`${each.about} ${each.text}`}>
              <div>
                <p><b>${aboutWord(each.about)}</b></p>
                <p>${each.text}</p>
              </div>
              <${Pill} kind=${KINDS[each.verdict] || "unknown"}>${verdictWord(each.verdict)}<//>
            </li>`,
          )}
        </ul>`
      : html`<${Nothing} asked=${asked} none=${t("Nothing was looked at.")} />`}
    </section>
    ${!asked.why && html`<${Metrics} />`}
  </div>`;
}
