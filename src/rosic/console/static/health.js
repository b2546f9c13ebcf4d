// Health: what the doctor finds of the record, the disk, messengers and robots.

import { Nothing, useAsked } from "./asked.js";
import { html } from "./lib.js";
import { Pill } from "./robots.js";
import { state } from "./store.js";
import { t } from "./texts.js";

const EVERY_MS = 15_000;
const KINDS = { good: "good", look: "bad", "not-measured": "unknown" };
const FIRST = { look: 0, "not-measured": 1, good: 2 };

function verdictWord(name) {
  const words = { good: t("good"), look: t("look at this"), "not-measured": t("not measured") };
  return words[name] || name;
}

/** The tab: what has to be looked at comes first. */
export function Health() {
  const asked = useAsked("/v1/health", EVERY_MS);
  const found = [...(asked.data || [])].sort((one, other) => FIRST[one.verdict] - FIRST[other.verdict]);
  return html`<section class="panel" aria-labelledby="h-health">
    <h2 id="h-health">${t("What the doctor finds")}</h2>
    ${found.length
      ? html`<ul class="list findings">
          ${found.map(
            (each) => html`<li key=${`${each.about} ${each.text}`}>
              <div>
                <p><b>${state.robots.get(each.about)?.name || each.about}</b></p>
                <p>${each.text}</p>
              </div>
              <${Pill} kind=${KINDS[each.verdict] || "unknown"}>${verdictWord(each.verdict)}<//>
            </li>`,
          )}
        </ul>`
      : html`<${Nothing} asked=${asked} none=${t("Nothing was looked at.")} />`}
  </section>`;
}
