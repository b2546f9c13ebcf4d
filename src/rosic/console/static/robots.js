// How a robot is shown: its connection, what it does, who has it.

import { html } from "./lib.js";
import { Resume } from "./resume.js";
import { state } from "./store.js";
import { number, t, unitSign } from "./texts.js";

/** Whether what is known of a robot is not of now. */
export const isOld = (robot) => state.link !== "up" || state.stale.has(robot.id);

/** Return [kind, words] of the connection of a robot, as far as it is known now. */
export function connection(robot) {
  if (state.link !== "up") return ["unknown", t("unknown: no connection to the gateway")];
  if (state.stale.has(robot.id)) return ["unknown", t("not heard of yet")];
  const { online, age_s: age, late } = robot.presence;
  if (online === true && late) return ["warn", t("no sign of life")];
  if (online === true) return ["good", t("connected")];
  if (online === null) return ["unknown", t("its link cannot tell")];
  if (age === null) return ["bad", t("not connected")];
  return ["bad", t("connection lost")];
}

/** A word with a sign before it, so that nothing is told by its colour alone. */
export function Pill({ kind, children }) {
  const sign = { good: "●", bad: "✕", warn: "▲", unknown: "?", quiet: "○" }[kind];
  return html`<span class=${`pill ${kind}`}><span aria-hidden="true">${sign}</span>${"\u00a0"}${children}</span>`;
}

/** Return what a robot's skill or value is called in the reader's language. */
export const called = (robot, name) => state.words.get(robot.id)?.[name] || name;

/** Return what a robot does, in words. */
export function doing(robot) {
  if (isOld(robot)) return "—";
  const { doing: skill, at_rest: rest } = robot.presence;
  if (skill) return called(robot, skill);
  if (rest === true) return t("at rest");
  return rest === false ? t("moving") : "—";
}

/** Return a pose in words. */
export function poseText(pose) {
  if (!pose) return "—";
  const turn = pose.yaw_rad === null ? "" : ` · ${number((pose.yaw_rad * 180) / Math.PI, 0)}°`;
  const height = Math.abs(pose.z_m) > 0.005 ? ` · z\u00a0${number(pose.z_m)}\u00a0m` : "";
  return `x\u00a0${number(pose.x_m)}\u00a0m · y\u00a0${number(pose.y_m)}\u00a0m${height}${turn}`;
}

/** Return the charge of a robot in words and in [0, 1]; null where it tells none. */
export function battery(robot) {
  const value = robot.presence.values.battery;
  if (typeof value !== "number") return null;
  const unit = unitSign(robot.units.battery || "");
  const share = unit === "%" ? value / 100 : null;
  return { text: `${number(value, 1)}\u00a0${unit}`.trim(), share };
}

/** What stands where no robot is: they come soon after the connection, or there is none to be seen. */
export const NoRobot = () =>
  html`<p class="quiet">${state.robotsTold ? t("You may see no robot here.") : t("One moment …")}</p>`;

/** A robot at a glance. */
export function RobotCard({ robot, chosen, onChoose }) {
  const [kind, words] = connection(robot);
  const charge = battery(robot);
  const old = isOld(robot);
  return html`<li class=${`robot ${kind} ${chosen ? "chosen" : ""} ${old ? "old" : ""}`}>
    <div class="robot-head">
      <button type="button" class="robot-name" aria-pressed=${chosen} onClick=${onChoose}>
        ${robot.name}
      </button>
      <${Pill} kind=${kind}>${words}<//>
    </div>
    ${robot.stopped &&
    html`<p class="robot-stopped row"><${Pill} kind=${old ? "unknown" : "bad"}>${t("stopped")}<//> <${Resume} robot=${robot} old=${old} /></p>`}
    <dl class="facts">
      <div><dt>${t("Does")}</dt><dd>${doing(robot)}</dd></div>
      <div><dt>${t("Held by")}</dt><dd>${robot.holder || t("nobody")}</dd></div>
      ${charge &&
      html`<div>
        <dt>${t("Battery")}</dt>
        <dd>
          ${charge.share !== null &&
          html`<meter min="0" max="1" low="0.2" optimum="1" value=${charge.share} aria-label=${t("Battery")}></meter> `}
          ${charge.text}
        </dd>
      </div>`}
      <div><dt>${t("Place")}</dt><dd>${poseText(robot.presence.pose)}</dd></div>
    </dl>
  </li>`;
}
