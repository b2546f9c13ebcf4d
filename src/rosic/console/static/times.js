// Times: whose a robot is and when; booked, moved and given back on a calendar.

import { command, dayAndTime, heard, Nothing, RobotChoice, Said, useAsked, useDeed } from "./asked.js";
import { Calendar, timeWords } from "./calendar.js";
import { asked } from "./invite.js";
import { html, useEffect, useState } from "./lib.js";
import { NoRobot } from "./robots.js";
import { ask, useStore } from "./store.js";
import { spoken, t } from "./texts.js";
import { dayAfter, dayIn, dayText, lengthOf, minutesIn, minutesOn, momentOf, mondayOf, timeText, within } from "./week.js";

const AHEAD_DAYS = 60;
const DAYS = 7;
const QUEUE_MS = 4_000;
const moment = (date) => encodeURIComponent(date.toISOString());
const path = (booking) => `/v1/bookings/${encodeURIComponent(booking.id)}`;

async function book(robot, time) {
  const start = momentOf(time.day, time.from).toISOString();
  return ask("POST", "/v1/bookings", { robot, start, minutes: lengthOf(time) });
}

async function giveBack(booking) {
  const answer = await ask("DELETE", path(booking));
  return answer.ok ? heard(answer.data) : { ok: false, kind: "bad", text: answer.why };
}

const booked = (name, time) =>
  ({ ok: true, kind: "good", text: t("{robot} is yours: {time}.", { robot: name, time: timeWords(time) }) });
const refused = (answer) => ({ ok: false, kind: "bad", text: answer.why });

/** Move a booking: one act, which leaves it where it was if it is refused. */
async function move(name, booking, time) {
  const start = momentOf(time.day, time.from).toISOString();
  const answer = await ask("PATCH", path(booking), { start, minutes: lengthOf(time) });
  return answer.ok ? booked(name, time) : refused(answer);
}

function TimeForm({ robot, name, chosen, onChoose, moving, onLeave, onBook, deed }) {
  const set = (changes) => onChoose(within({ ...chosen, ...changes }));
  const day = (event) => {
    const found = dayIn(event.target.value);
    if (found) set({ day: found });
  };
  const from = (event) => {
    const found = minutesIn(event.target.value);
    if (found !== null) set({ from: found, to: found + chosen.to - chosen.from });
  };
  const to = (event) => {
    const found = minutesIn(event.target.value);
    if (found !== null) set({ to: found > chosen.from ? found : found + 1440 });
  };
  return html`<form
    class="time-form"
    aria-label=${moving ? t("Move a booking") : t("Book a time")}
    onSubmit=${(event) => {
      event.preventDefault();
      onBook();
    }}
  >
    ${!chosen &&
    html`<p class="quiet">
      ${t("Drag over the calendar to choose a time of {robot}, or tap an hour. With the keyboard: arrow keys, then Enter.", { robot: name })}
    </p>`}
    ${chosen &&
    html`<label class="field">${t("Day")}<input type="date" required value=${dayText(chosen.day)} onChange=${day} /></label>
      <label class="field">
        ${t("From")}<input type="time" required value=${timeText(chosen.from)} onChange=${from} />
      </label>
      <label class="field">${t("To")}<input type="time" required value=${timeText(chosen.to)} onChange=${to} /></label>
      <div class="row">
        <button type="submit" class="main" disabled=${deed.waits}>
          ${moving ? t("Move it here") : t("Book {robot}", { robot: name })}
        </button>
        ${moving &&
        html`<button type="button" disabled=${deed.waits} onClick=${() => deed.act(() => giveBack(moving)).then(onLeave)}>
          ${t("Give it back")}
        </button>`}
        <button type="button" class="plain" onClick=${onLeave}>${t("Leave it")}</button>
      </div>`}
    <${Said} said=${deed.said} />
  </form>`;
}

function MyTimes({ mine, deed, again }) {
  const { robots } = useStore();
  const own = mine.data?.filter((booking) => booking.own) || [];
  if (!own.length) return html`<${Nothing} asked=${mine} none=${t("You have booked nothing.")} />`;
  return html`<ul class="list">
    ${own.map((booking) => {
      const robot = robots.get(booking.robot)?.name || booking.robot;
      const end = new Date(booking.end);
      const until = timeText(end.getHours() * 60 + end.getMinutes());
      return html`<li key=${booking.id}>
        <span><b>${robot}</b> ${dayAndTime(booking.start)}–${until}</span>
        <button
          type="button"
          class="plain"
          disabled=${deed.waits}
          aria-label=${t("Give {robot} back, {time}", { robot, time: dayAndTime(booking.start) })}
          onClick=${() => deed.act(() => giveBack(booking)).then(again)}
        >
          ${t("Give it back")}
        </button>
      </li>`;
    })}
  </ul>`;
}

function Sharing({ robot }) {
  const { me } = useStore();
  const { said, waits, act } = useDeed();
  const [whom, name] = useState("");
  const path = `/v1/robots/${encodeURIComponent(robot.id)}`;
  const queue = useAsked(`/v1/queue?robot=${encodeURIComponent(robot.id)}`, QUEUE_MS);
  const mine = queue.data?.find((each) => each.own);
  const say = (method, what, word, main = false) =>
    html`<button
      type="button"
      class=${main ? "main" : ""}
      disabled=${waits}
      onClick=${() => act(() => asked(method, `${path}/${what}`)).then(queue.again)}
    >
      ${word}
    </button>`;
  const hand = (event) => {
    event.preventDefault();
    act(() => command(`/handover ${whom.trim()}`));
  };
  return html`<p>${t("{robot} is held by {who}", { robot: robot.name, who: robot.holder || t("nobody") })}</p>
    ${queue.data?.length
      ? html`<ol class="list" aria-label=${t("Who waits for {robot}", { robot: robot.name })}>
          ${queue.data.map(
            (each) => html`<li key=${each.place}>
              <span>${each.place}. <b>${each.who}</b></span>
              ${each.offered && html`<span class="quiet">${t("it is their turn")}</span>`}
            </li>`,
          )}
        </ol>`
      : html`<${Nothing} asked=${queue} none=${t("Nobody waits for it.")} />`}
    <div class="row">
      ${mine?.offered && say("POST", "queue/take", t("It is my turn: take it"), true)}
      ${mine
        ? say("DELETE", "queue", t("Wait no longer"))
        : robot.holder !== me.name && say("POST", "queue", t("Wait for it"))}
      ${robot.holder === me.name && say("POST", "release", t("I have done with it"))}
      ${robot.holder && robot.holder !== me.name && say("POST", "take-over", t("Take it over"))}
    </div>
    <form class="row hand" onSubmit=${hand}>
      <label class="field">
        ${t("Hand my robots and tasks over to")}
        <input required maxlength="64" autocomplete="off" value=${whom} onInput=${(event) => name(event.target.value)} />
      </label>
      <button type="submit" disabled=${waits}>${t("Hand over")}</button>
    </form>
    <${Said} said=${said} />`;
}

const NARROW = matchMedia("(max-width: 760px)");

/** How many days there is room for: a week, or three days on a phone. */
function useDays() {
  const [narrow, know] = useState(NARROW.matches);
  useEffect(() => {
    const look = () => know(NARROW.matches);
    NARROW.addEventListener("change", look);
    return () => NARROW.removeEventListener("change", look);
  }, []);
  return narrow ? 3 : DAYS;
}

/** The tab. */
export function Times({ robot: wanted, onRobot }) {
  const { robots } = useStore();
  const robot = robots.get(wanted) || [...robots.values()][0];
  const count = useDays();
  const beginOf = (day) => (count === DAYS ? mondayOf(day) : dayAfter(day, 0));
  const [shown, turn] = useState(() => new Date());
  const first = beginOf(shown);
  const [chosen, choose] = useState(null);
  const [moving, take] = useState(null);
  const deed = useDeed();
  const end = dayAfter(first, count);
  const [today] = useState(() => dayAfter(new Date(), 0));
  const week = useAsked(
    robot && `/v1/bookings?robot=${encodeURIComponent(robot.id)}&from=${moment(first)}&to=${moment(end)}`,
  );
  const mine = useAsked(`/v1/bookings?from=${moment(today)}&to=${moment(dayAfter(today, AHEAD_DAYS))}`);
  if (!robot) return html`<section class="panel"><${NoRobot} /></section>`;

  const leave = () => {
    choose(null);
    take(null);
    week.again();
    mine.again();
  };
  const showWeekOf = (time) => {
    choose(time);
    if (time && (time.day < first || time.day >= end)) turn(time.day);
  };
  const pick = (booking) => {
    const start = new Date(booking.start);
    const day = dayAfter(start, 0);
    take(booking);
    deed.say({ kind: "", text: "" });
    showWeekOf(within({ day, from: minutesOn(day, start), to: minutesOn(day, new Date(booking.end)) }));
  };
  const bookIt = () =>
    deed
      .act(async () => {
        if (moving) return move(robot.name, moving, chosen);
        const answer = await book(robot.id, chosen);
        return answer.ok ? booked(robot.name, chosen) : refused(answer);
      })
      .then((done) => (done.ok ? leave() : week.again()));
  const months = first.toLocaleDateString(spoken(), { month: "long", year: "numeric" });
  return html`<div class="times">
    <section class="panel week-of" aria-labelledby="h-week">
      <div class="row week-bar">
        <h2 id="h-week">${months}</h2>
        <${RobotChoice} value=${robot.id} onChoose=${(id) => (leave(), onRobot(id))} />
        <span class="row pager">
          <button type="button" aria-label=${t("Earlier")} onClick=${() => turn(dayAfter(first, -count))}>‹</button>
          <button type="button" onClick=${() => turn(new Date())}>${t("Today")}</button>
          <button type="button" aria-label=${t("Later")} onClick=${() => turn(dayAfter(first, count))}>›</button>
        </span>
      </div>
      ${week.why && html`<p class="said bad" role="status">${week.why}</p>`}
      <${Calendar}
        first=${first}
        count=${count}
        bookings=${week.data || []}
        chosen=${chosen}
        onChoose=${showWeekOf}
        moving=${moving}
        onPick=${pick}
        onGiveBack=${(booking) => deed.act(() => giveBack(booking)).then(leave)}
        onBook=${bookIt}
      />
    </section>
    <section class="panel" aria-labelledby="h-book">
      <h2 id="h-book">${moving ? t("Move a booking") : t("Book a time")}</h2>
      <${TimeForm}
        robot=${robot}
        name=${robot.name}
        chosen=${chosen}
        onChoose=${showWeekOf}
        moving=${moving}
        onLeave=${leave}
        onBook=${bookIt}
        deed=${deed}
      />
    </section>
    <section class="panel" aria-labelledby="h-mine">
      <h2 id="h-mine">${t("My times")}</h2>
      <${MyTimes} mine=${mine} deed=${deed} again=${leave} />
    </section>
    <section class="panel" aria-labelledby="h-sharing">
      <h2 id="h-sharing">${t("Waiting and handing over")}</h2>
      <${Sharing} key=${robot.id} robot=${robot} />
    </section>
  </div>`;
}
