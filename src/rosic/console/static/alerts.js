// Alerts: what is wrong now, and that somebody has seen it.

import { command, dayAndTime, heard, Nothing, Said, useAsked, useDeed } from "./asked.js";
import { html } from "./lib.js";
import { Pill } from "./robots.js";
import { ask, state, useStore } from "./store.js";
import { t } from "./texts.js";

const PATH = "/v1/alerts";

/** How many alarms nobody has seen yet, for the tab's name. */
export function useAlertCount() {
  const { data } = useAsked(PATH, 15_000);
  return data ? data.filter((alert) => !alert.seen_by).length : 0;
}

function Alert({ alert, again }) {
  const { said, waits, act } = useDeed();
  const robot = state.robots.get(alert.robot)?.name || alert.robot;
  const see = async () => {
    const answer = await ask("POST", `/v1/robots/${encodeURIComponent(alert.robot)}/alerts/seen`, {});
    return answer.ok ? heard(answer.data) : { kind: "bad", text: answer.why };
  };
  const mute = () => command(`/mute ${alert.robot} ${alert.name} 1h`);
  return html`<li class=${`alert ${alert.seen_by ? "seen" : ""}`}>
    <div>
      <p class="row"><${Pill} kind=${alert.seen_by ? "warn" : "bad"}>${robot}: ${alert.text}<//></p>
      <p class="measured">${alert.measured}</p>
      <p class="quiet small">
        ${t("since {time}", { time: dayAndTime(alert.at) })}
        ${alert.seen_by && html` · ${t("seen by {who}", { who: alert.seen_by })}`}
      </p>
      <${Said} said=${said} />
    </div>
    <div class="row">
      ${!alert.seen_by &&
      html`<button type="button" class="main" disabled=${waits} onClick=${() => act(see).then(again)}>
        ${t("I have seen it")}
      </button>`}
      <button type="button" disabled=${waits} onClick=${() => act(mute).then(again)}>${t("Silent for an hour")}</button>
      <a class="button" href=${`#drive/${encodeURIComponent(alert.robot)}`}>${t("To the robot")}</a>
    </div>
  </li>`;
}

/** The tab. */
export function Alerts() {
  useStore();
  const asked = useAsked(PATH, 5_000);
  const { data, again } = asked;
  return html`<section class="panel" aria-labelledby="h-alerts">
    <h2 id="h-alerts">${t("What is wrong now")}</h2>
    ${data?.length
      ? html`<ul class="alerts">
          ${data.map((each) => html`<${Alert} key=${`${each.robot} ${each.name}`} alert=${each} again=${again} />`)}
        </ul>`
      : html`<${Nothing} asked=${asked} none=${t("Nothing is wrong, as far as is measured.")} />`}
  </section>`;
}
