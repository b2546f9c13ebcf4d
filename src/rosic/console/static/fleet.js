// Fleet: tasks for whichever robot can, missions of several of them, and what everybody does.

import { dayAndTime, Nothing, Said, useAsked, useDeed } from "./asked.js";
import { asked } from "./invite.js";
import { html, Table, useState } from "./lib.js";
import { Pill } from "./robots.js";
import { useStore } from "./store.js";
import { t } from "./texts.js";

const EVERY_MS = 4_000;
const KINDS = { running: "good", assigned: "good", queued: "quiet", paused: "warn", failed: "bad", unknown: "bad" };

function stateWord(name) {
  const words = {
    queued: t("waits"),
    assigned: t("has a robot"),
    running: t("under way"),
    paused: t("held"),
    failed: t("failed"),
    unknown: t("in doubt"),
  };
  return words[name] || name;
}

function actWord(name) {
  const words = { pause: t("Hold"), go: t("Go on"), cancel: t("End"), done: t("It was done") };
  return words[name];
}

const ACTS = {
  queued: ["pause", "cancel"],
  assigned: ["pause", "cancel"],
  running: ["pause", "cancel"],
  paused: ["go", "cancel"],
  failed: ["go", "cancel"],
  unknown: ["go", "done", "cancel"],
};

function Task({ task, act, waits, again }) {
  const { robots } = useStore();
  const path = `/v1/tasks/${encodeURIComponent(task.id)}`;
  const robot = task.robot && (robots.get(task.robot)?.name || task.robot);
  return html`<li>
    <div>
      <p><b>${task.id}</b> ${task.what}</p>
      <p class="row">
        <${Pill} kind=${KINDS[task.state] || "quiet"}>${stateWord(task.state)}<//>
        ${robot && html`<span>${robot}</span>`}
        <progress max=${task.steps} value=${task.done} aria-label=${t("Steps of task {id} that are done", { id: task.id })}></progress>
        <span class="quiet small">${t("{done} of {all} steps", { done: task.done, all: task.steps })}</span>
      </p>
      <p class="quiet small">${t("by {who}, since {time}", { who: task.who, time: dayAndTime(task.given) })}</p>
      ${task.waits && html`<p class="small">${task.waits}</p>`}
    </div>
    <div class="row">
      ${(ACTS[task.state] || ["cancel"]).map(
        (name) => html`<button
          type="button"
          disabled=${waits}
          aria-label=${t("{act}: task {id}", { act: actWord(name), id: task.id })}
          onClick=${() => act(() => asked("POST", `${path}/${name}`)).then(again)}
        >
          ${actWord(name)}
        </button>`,
      )}
    </div>
  </li>`;
}

function GiveTask({ act, waits, again }) {
  const { robots } = useStore();
  const all = [...robots.values()];
  const groups = [...new Set(all.flatMap((each) => each.groups))].sort();
  const [on, choose] = useState("any");
  const [steps, write] = useState("");
  const give = (event) => {
    event.preventDefault();
    const lines = steps.split("\n").map((each) => each.trim()).filter(Boolean);
    act(() => asked("POST", "/v1/tasks", { on, steps: lines })).then((done) => {
      if (done.ok) write("");
      again();
    });
  };
  return html`<form class="task-form" aria-label=${t("Give a task")} onSubmit=${give}>
    <label class="field">
      ${t("For")}
      <select value=${on} onChange=${(event) => choose(event.target.value)}>
        <option value="any">${t("any robot that can")}</option>
        ${groups.map((each) => html`<option value=${each}>${t("any of {group}", { group: each })}</option>`)}
        ${all.map((each) => html`<option value=${each.id}>${each.name}</option>`)}
      </select>
    </label>
    <label class="field">
      ${t("Steps, one in each line")}
      <textarea
        required
        rows="3"
        maxlength="2000"
        placeholder=${t("move 0.5 m left")}
        value=${steps}
        onInput=${(event) => write(event.target.value)}
      ></textarea>
    </label>
    <button type="submit" class="main" disabled=${waits}>${t("Give the task")}</button>
  </form>`;
}

function Mission({ mission, act, waits, again }) {
  const [values, write] = useState("");
  const path = `/v1/missions/${encodeURIComponent(mission.name)}/start`;
  const start = (event) => {
    event.preventDefault();
    act(() => asked("POST", path, { values: values.trim() })).then(again);
  };
  return html`<li>
    <form class="row" aria-label=${mission.title || mission.name} onSubmit=${start}>
      <b>${mission.title || mission.name}</b>
      ${mission.parameters.length > 0 &&
      html`<label class="field">
        ${mission.parameters.join(", ")}
        <input maxlength="300" autocomplete="off" value=${values} onInput=${(event) => write(event.target.value)} />
      </label>`}
      <button type="submit" disabled=${waits} aria-label=${t("Start {mission}", { mission: mission.title || mission.name })}>
        ${t("Start")}
      </button>
    </form>
  </li>`;
}

function Run({ run, act, waits, again }) {
  const path = `/v1/missions/runs/${encodeURIComponent(run.id)}`;
  return html`<li>
    <span class="row">
      <b>${run.id}</b>
      <progress max=${run.tasks} value=${run.done} aria-label=${t("Tasks of mission {id} that are done", { id: run.id })}></progress>
      <span class="quiet small">${t("{done} of {all} tasks", { done: run.done, all: run.tasks })}</span>
      ${run.resting > 0 && html`<${Pill} kind="warn">${t("{count} wait for a person", { count: run.resting })}<//>`}
    </span>
    <span class="row">
      ${["pause", "go", "cancel"].map(
        (name) => html`<button
          type="button"
          disabled=${waits}
          aria-label=${t("{act}: mission {id}", { act: actWord(name), id: run.id })}
          onClick=${() => act(() => asked("POST", `${path}/${name}`)).then(again)}
        >
          ${actWord(name)}
        </button>`,
      )}
    </span>
  </li>`;
}

function hours(seconds) {
  const minutes = Math.round(seconds / 60);
  return t("{hours} h {minutes} min", { hours: Math.floor(minutes / 60), minutes: minutes % 60 });
}

function Busy({ time, head, of }) {
  const percent = Math.round(time.share * 100);
  return html`<td data-head=${head}>
    <span>
      <meter min="0" max="1" value=${time.share} aria-label=${of}></meter>
      <span class="number">${percent}\u00a0%</span>
      <span class="quiet small">${hours(time.worked_s)}</span>
    </span>
  </td>`;
}

function Utilisation() {
  const { robots } = useStore();
  const asked = useAsked("/v1/utilisation", EVERY_MS);
  const found = asked.data || [];
  const named = (each) => robots.get(each.robot)?.name || each.robot;
  return html`<section class="panel busy-robots" aria-labelledby="h-busy">
    <h2 id="h-busy">${t("How busy robots were")}</h2>
    ${found.length
      ? html`<${Table}
          label=${t("How busy robots were")}
          kind="busy stacked"
          heads=${[t("Robot"), t("Today"), t("Last 7 days")]}
        >
          <tbody>
            ${found.map(
              (each) => html`<tr key=${each.robot}>
                <th scope="row" data-head=${t("Robot")}>
                  <span>${named(each)} ${each.at_work && html`<${Pill} kind="good">${t("at work")}<//>`}</span>
                </th>
                <${Busy} time=${each.today} head=${t("Today")} of=${t("{robot}, today", { robot: named(each) })} />
                <${Busy} time=${each.week} head=${t("Last 7 days")} of=${t("{robot}, last 7 days", { robot: named(each) })} />
              </tr>`,
            )}
          </tbody>
        <//>`
      : html`<${Nothing} asked=${asked} none=${t("You may see no robot here.")} />`}
  </section>`;
}

/** The tab. */
export function Fleet() {
  const tasks = useAsked("/v1/tasks", EVERY_MS);
  const missions = useAsked("/v1/missions", EVERY_MS);
  const ofTasks = useDeed();
  const ofMissions = useDeed();
  const runs = missions.data?.runs || [];
  const known = missions.data?.missions || [];
  return html`<div class="people">
    <section class="panel" aria-labelledby="h-tasks">
      <h2 id="h-tasks">${t("Tasks")}</h2>
      ${tasks.data?.length
        ? html`<ul class="list">
            ${tasks.data.map((each) => html`<${Task} key=${each.id} task=${each} ...${ofTasks} again=${tasks.again} />`)}
          </ul>`
        : html`<${Nothing} asked=${tasks} none=${t("No task is open.")} />`}
      ${tasks.data && html`<${GiveTask} ...${ofTasks} again=${tasks.again} />`}
      <${Said} said=${ofTasks.said} />
    </section>
    <section class="panel" aria-labelledby="h-missions">
      <h2 id="h-missions">${t("Missions")}</h2>
      ${runs.length > 0 &&
      html`<ul class="list" aria-label=${t("Missions under way")}>
        ${runs.map((each) => html`<${Run} key=${each.id} run=${each} ...${ofMissions} again=${missions.again} />`)}
      </ul>`}
      ${known.length
        ? html`<ul class="list">
            ${known.map(
              (each) => html`<${Mission} key=${each.name} mission=${each} ...${ofMissions} again=${missions.again} />`,
            )}
          </ul>`
        : html`<${Nothing} asked=${missions} none=${t("There is no mission that you may start.")} />`}
      <${Said} said=${ofMissions.said} />
    </section>
    <${Utilisation} />
  </div>`;
}
