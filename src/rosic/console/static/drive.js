// Drive: the forms of a robot, the conversation, and live control where the gateway has it.

import { Chat } from "./chat.js";
import { Jog } from "./jog.js";
import { html, useEffect, useState } from "./lib.js";
import { Orders } from "./orders.js";
import { connection, doing, isOld, NoRobot, Pill } from "./robots.js";
import { Resume } from "./resume.js";
import { Skills } from "./skills.js";
import { state, useStore } from "./store.js";
import { t } from "./texts.js";

/** Nobody steers another robot than the one that they chose because that one is gone. */
function Missing({ chosen, all, onRobot }) {
  const name = state.gone.get(chosen) || chosen;
  if (!all.length) {
    return html`<section class="panel"><${NoRobot} /></section>`;
  }
  return html`<section class="panel gone" role="alert">
    <p>${chosen && t("{robot} is not here any more, or you may not see it. Choose another one.", { robot: name })}</p>
    <p class="row">
      ${all.map(
        (each) => html`<button type="button" onClick=${() => onRobot(each.id)}>${each.name}</button>`,
      )}
    </p>
  </section>`;
}

/** Why there is nothing to steer by: a robot that takes velocities has a time-out for them. */
function noJog(robot, offered) {
  if (!offered) return t("This gateway offers no live control.");
  if (robot.watchdog_s === null) return t("{robot} cannot be driven live.", { robot: robot.name });
  return t("You may not drive {robot} live.", { robot: robot.name });
}

/** One robot at a time. */
export function Drive({ robot: wanted, onRobot }) {
  const { robots, abilities } = useStore();
  const [known, know] = useState(null);
  const all = [...robots.values()];
  const [first, settle] = useState("");
  useEffect(() => {
    if (!wanted && !first && all.length) settle(all[0].id);
  }, [wanted, first, all.length]);
  const chosen = wanted || first;
  const robot = robots.get(chosen);
  if (!robot) return html`<${Missing} chosen=${chosen} all=${all} onRobot=${onRobot} />`;
  const [kind, words] = connection(robot);
  const old = isOld(robot);
  const skills = known || [];
  const offered = abilities.has("jog");
  const streamed = skills.filter((skill) => skill.streams);
  return html`<div class="drive">
    <section class="panel choose" aria-label=${t("Robot")}>
      <label class="field big">
        ${t("Robot")}
        <select
          value=${robot.id}
          onChange=${(event) => {
            know(null);
            onRobot(event.target.value);
          }}
        >
          ${all.map((each) => html`<option value=${each.id}>${each.name}</option>`)}
        </select>
      </label>
      <p class=${`row ${old ? "old" : ""}`}>
        <${Pill} kind=${kind}>${words}<//>
        ${robot.stopped && html`<${Pill} kind=${old ? "unknown" : "bad"}>${t("stopped")}<//> <${Resume} robot=${robot} old=${old} />`}
        <span>${doing(robot)}</span>
        <span class="quiet">${t("Held by")}: ${robot.holder || t("nobody")}</span>
      </p>
    </section>
    <section class="panel forms" aria-labelledby="h-forms">
      <h2 id="h-forms">${t("Orders")}</h2>
      <${Skills} key=${robot.id} robot=${robot} onSkills=${know} />
    </section>
    <section class="panel jog" aria-labelledby="h-jog">
      <h2 id="h-jog">${t("Live control")}</h2>
      ${offered && streamed.length
        ? html`<${Jog} key=${robot.id} robot=${robot} skills=${streamed} />`
        : known && html`<p class="quiet">${noJog(robot, offered)}</p>`}
    </section>
    <section class="panel talk" aria-labelledby="h-chat">
      <h2 id="h-chat">${t("Conversation")}</h2>
      <${Chat} />
    </section>
    <section class="panel commands" aria-labelledby="h-sent">
      <h2 id="h-sent">${t("Commands sent to the robot, and received by it")}</h2>
      <${Orders} robot=${robot.id} most=${8} />
    </section>
  </div>`;
}
