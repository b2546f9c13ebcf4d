// Forms that are made from what a robot's profile says of its skills.

import { html, newId, useEffect, useRef, useState } from "./lib.js";
import { ask, useStore } from "./store.js";
import { number, spoken, t, unitSign } from "./texts.js";

function firstOf(schema) {
  const values = {};
  for (const [name, each] of Object.entries(schema.properties)) {
    if (each.default !== undefined) values[name] = String(each.default);
    else values[name] = each.enum ? each.enum[0] : "";
  }
  return values;
}

function Field({ id, name, skill, required, value, onInput }) {
  const schema = skill.arguments.properties[name];
  const unit = unitSign(skill.units[name] || "");
  const bounded = schema.minimum !== undefined;
  const change = (event) => onInput(name, event.target.value);
  return html`<div class="param">
    <label for=${id}>${skill.titles[name]}${!required && html` <span class="quiet">${t("(optional)")}</span>`}</label>
    ${schema.enum
      ? html`<select id=${id} value=${value} onChange=${change}>
          ${schema.enum.map((each) => html`<option value=${each}>${skill.words[each]}</option>`)}
        </select>`
      : html`<span class="with-unit">
          <input
            id=${id}
            type=${bounded ? "number" : "text"}
            inputmode=${bounded ? "decimal" : "text"}
            min=${schema.minimum}
            max=${schema.maximum}
            step=${schema.type === "integer" ? 1 : "any"}
            required=${required}
            maxlength=${bounded ? undefined : 400}
            value=${value}
            onInput=${change}
            aria-describedby=${bounded ? `${id}-range` : undefined}
          />
          ${unit && html`<span class="unit">${unit}</span>`}
        </span>`}
    ${bounded &&
    html`<small id=${`${id}-range`} class="quiet">
      ${t("{least} to {most}", { least: number(schema.minimum, 3), most: number(schema.maximum, 3) })}${unit.startsWith("°") ? "" : "\u00a0"}${unit}
    </small>`}
  </div>`;
}

function argumentsOf(schema, values) {
  const given = {};
  for (const [name, each] of Object.entries(schema.properties)) {
    const text = values[name].trim();
    if (text === "") continue;
    given[name] = each.type === "string" ? text : Number(text);
  }
  return given;
}

const NOTHING = { kind: "", text: "" };

/** An answer is of the robot as it was: resumed it makes every one old, let go or back a refusal. */
function isOld({ kind }, { resumed, free, back }) {
  return resumed || (kind === "bad" && (free || back));
}

function useChanged(robot, tell) {
  const { stopped, holder, presence } = robot;
  const now = { stopped, holder, online: presence.online };
  const before = useRef(now);
  useEffect(() => {
    const was = before.current;
    before.current = now;
    tell({
      resumed: was.stopped && !stopped,
      free: was.holder !== "" && was.holder !== holder,
      back: was.online === false && presence.online !== false,
    });
  }, [stopped, holder, presence.online]);
}

function SkillForm({ robot, skill }) {
  const [values, fill] = useState(() => firstOf(skill.arguments));
  const [said, say] = useState(NOTHING);
  const [waits, wait] = useState(false);
  const required = skill.arguments.required || [];
  useChanged(robot, (what) => say((before) => (isOld(before, what) ? NOTHING : before)));
  const path = `/v1/robots/${encodeURIComponent(robot.id)}/orders`;

  async function give(event, dry) {
    event.preventDefault();
    const form = event.target.form || event.target;
    if (!form.reportValidity()) return;
    wait(true);
    const order = { skill: skill.id, arguments: argumentsOf(skill.arguments, values) };
    const answer = dry
      ? await ask("POST", `${path}/check`, order)
      : await ask("POST", path, order, { "Idempotency-Key": newId() });
    wait(false);
    if (!answer.ok) say({ kind: "bad", text: answer.why });
    else if (dry) {
      const { allowed, sent, needs } = answer.data;
      const text = allowed
        ? t("This would be sent: {sent}", { sent })
        : t("This would be sent: {sent}. First needed: {needs}", { sent, needs: needs.join(", ") });
      say({ kind: allowed ? "good" : "warn", text });
    } else if (answer.data.state === "asked") {
      say({ kind: "warn", text: t("Answer the question in the conversation.") });
    } else if (answer.data.state === "unknown") say({ kind: "warn", text: answer.data.text });
    else say({ kind: "good", text: t("Given: {sent}", { sent: answer.data.sent }) });
  }

  return html`<form class="skill" onSubmit=${(event) => give(event, false)} aria-label=${skill.name}>
    <div class="params">
      ${Object.keys(skill.arguments.properties).map(
        (name) => html`<${Field}
          key=${name}
          id=${`${robot.id}-${skill.id}-${name}`}
          name=${name}
          skill=${skill}
          required=${required.includes(name)}
          value=${values[name]}
          onInput=${(key, value) => fill((before) => ({ ...before, [key]: value }))}
        />`,
      )}
    </div>
    <div class="row">
      <button type="submit" class="main" disabled=${waits}>${t("Give the order")}</button>
      <button type="button" disabled=${waits} onClick=${(event) => give(event, true)}>
        ${t("Check only")}
      </button>
      ${skill.asks && html`<span class="quiet small">${t("Somebody is asked first.")}</span>`}
    </div>
    <p class=${`said ${said.kind}`} role="status">${said.text}</p>
  </form>`;
}

/** What may be asked of a robot: one form for each skill. */
export function Skills({ robot, onSkills }) {
  const { link } = useStore();
  const [skills, know] = useState(null);
  const [why, tell] = useState("");
  useEffect(() => {
    let over = false;
    ask("GET", `/v1/robots/${encodeURIComponent(robot.id)}/skills`).then((answer) => {
      if (over) return;
      know(answer.ok ? answer.data : []);
      tell(answer.why);
      if (answer.ok) onSkills(answer.data);
    });
    return () => {
      over = true;
    };
  }, [robot.id, link === "up", spoken()]);
  if (why) return html`<p class="said bad" role="alert">${why}</p>`;
  if (!skills) return html`<p class="quiet">${t("One moment …")}</p>`;
  if (!skills.length) {
    return html`<p class="quiet">${t("You may ask nothing of {robot}.", { robot: robot.name })}</p>`;
  }
  return html`<div class="skills">
    ${skills.map(
      (skill, index) => html`<details key=${`${robot.id} ${skill.id}`} open=${index === 0}>
        <summary>${skill.name}</summary>
        <${SkillForm} robot=${robot} skill=${skill} />
      </details>`,
    )}
  </div>`;
}
