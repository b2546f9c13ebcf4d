// Commands that were sent beside commands that were received: a difference stands out.

import { html, Table, useNow } from "./lib.js";
import { Pill } from "./robots.js";
import { state, useStore } from "./store.js";
import { clock, number, t } from "./texts.js";

const MISSED_MS = 2000;
const SHOWN = 25;

const stageAt = (order, name) => order.stages.find((stage) => stage.stage === name)?.at;

/** Return what stands in the column of what the robot received: { kind, words }. */
export function received(order, now) {
  const at = stageAt(order, "received");
  if (at) return { kind: "good", words: order.sent, at };
  if (order.state === "refused") return { kind: "bad", words: t("refused: not done") };
  const sent = stageAt(order, "sent");
  if (!sent) return { kind: "quiet", words: order.over ? t("never sent") : t("not sent yet") };
  if (order.over && order.state === "sent") return { kind: "warn", words: t("this robot does not acknowledge") };
  const since = state.sentAt.get(order.id);
  if (order.over || (since !== undefined && now - since > MISSED_MS)) {
    return { kind: "bad", words: t("sent, and not received") };
  }
  return { kind: "quiet", words: t("waiting for the robot") };
}

function duration(ms) {
  return ms < 1000 ? `${number(ms, 0)} ms` : `${number(ms / 1000, 1)} s`;
}

/** Return the hops of an order: [name of a stage, milliseconds since the one before]. */
export function hops(order) {
  const steps = order.stages.map((stage) => [stage.stage, Date.parse(stage.at)]);
  if (order.ended) steps.push([order.state, Date.parse(order.ended)]);
  return steps.map(([name, at], index) => [name, index ? at - steps[index - 1][1] : null]);
}

/** Return the word for a stage or an ending. */
export function stageWord(name) {
  const words = {
    asked: t("asked"),
    accepted: t("accepted"),
    queued: t("queued"),
    sent: t("sent"),
    received: t("received"),
    running: t("running"),
    ended: t("ended"),
    done: t("done"),
    failed: t("failed"),
    cancelled: t("cancelled"),
    unknown: t("unknown"),
    refused: t("refused"),
  };
  return words[name] || name;
}

const KINDS = { done: "good", failed: "bad", refused: "bad", unknown: "warn", cancelled: "warn" };

function Row({ order, now }) {
  const got = received(order, now);
  const robot = state.robots.get(order.robot)?.name || order.robot;
  const share = !order.over && order.fraction !== null ? ` ${number(order.fraction * 100, 0)}\u00a0%` : "";
  return html`<tr class=${got.kind === "bad" ? "mismatch" : ""}>
    <td data-head=${t("Time")}>
      ${order.stages.length ? clock(order.stages[0].at) : "—"}<br /><small>${order.who}</small>
    </td>
    <th scope="row" data-head=${t("Robot")}>${robot}</th>
    <td data-head=${t("Sent to the robot")}>
      ${stageAt(order, "sent") ? order.sent : html`<span class="quiet">${order.sent}</span>`}
    </td>
    <td data-head=${t("Received by the robot")} class=${`received ${got.kind}`}>
      <${Pill} kind=${got.kind}>${got.words}<//>
    </td>
    <td data-head=${t("Now")}>
      <${Pill} kind=${order.over ? KINDS[order.state] || "quiet" : "quiet"}>
        ${stageWord(order.state)}${share}
      <//>
      ${order.note && html`<br /><small>${order.note}</small>`}
    </td>
    <td data-head=${t("Hops")}>
      <ol class="hops">
        ${hops(order).map(
          ([name, ms]) =>
            html`<li>${stageWord(name)}${ms !== null && html` <b>${duration(ms)}</b>`}</li>`,
        )}
      </ol>
    </td>
  </tr>`;
}

/** The newest orders, whoever gave them. */
export function Orders({ robot = "", most = SHOWN }) {
  const { orders } = useStore();
  const now = useNow(500);
  const shown = [...orders.values()]
    .filter((order) => order.id && (!robot || order.robot === robot))
    .reverse()
    .slice(0, most);
  if (!shown.length) return html`<p class="quiet">${t("Nothing was sent yet.")}</p>`;
  return html`<${Table}
    label=${t("Commands")}
    kind="orders"
    heads=${[t("Time"), t("Robot"), t("Sent to the robot"), t("Received by the robot"), t("Now"), t("Hops")]}
  >
    <tbody>
      ${shown.map((order) => html`<${Row} key=${order.id} order=${order} now=${now} />`)}
    </tbody>
  <//>`;
}
