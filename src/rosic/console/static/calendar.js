// A week of a robot: whose it is, and a time to drag out of it, by hand or by the arrow keys.

import { html, useEffect, useRef } from "./lib.js";
import { spoken, t } from "./texts.js";
import { DAY_MIN, dayAfter, dayText, minutesOn, snapped, STEP_MIN, timeText, within } from "./week.js";

const FIRST_SHOWN_MIN = 7 * 60;
const USUAL_MIN = 60;
const KEYS = {
  ArrowUp: [0, -STEP_MIN],
  ArrowDown: [0, STEP_MIN],
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
};

const share = (minutes) => `${(minutes / DAY_MIN) * 100}%`;
const placed = (from, to) => ({ top: share(from), height: share(to - from) });

/** Return a time in words: Tuesday, 1 December, 14:00 to 15:00. */
export function timeWords({ day, from, to }) {
  const date = day.toLocaleDateString(spoken(), { weekday: "long", day: "numeric", month: "long" });
  return t("{day}, {from} to {to}", { day: date, from: timeText(from), to: timeText(to) });
}

function onDay(bookings, day) {
  return bookings
    .map((booking) => ({
      booking,
      from: minutesOn(day, new Date(booking.start)),
      to: minutesOn(day, new Date(booking.end)),
    }))
    .filter(({ from, to }) => to > from);
}

function Booked({ booking, from, to, picked, onPick, onGiveBack }) {
  const words = `${timeText(from)}–${timeText(to)} ${booking.who}`;
  const kind = `booked ${booking.own ? "own" : "others"} ${picked ? "picked" : ""}`;
  if (!booking.own) {
    return html`<li class=${kind} style=${placed(from, to)}><span>${words}</span></li>`;
  }
  const key = (event) => event.key === "Delete" && onGiveBack(booking);
  return html`<li class=${kind} style=${placed(from, to)}>
    <button
      type="button"
      aria-label=${t("{time}, yours: choose it to move it or to give it back", { time: words })}
      aria-pressed=${picked}
      onClick=${() => onPick(booking)}
      onKeyDown=${key}
    >
      ${words}
    </button>
  </li>`;
}

/** Some days from a first one. `chosen` is { day, from, to } in minutes of that day, or null. */
export function Calendar({ first, count, bookings, chosen, onChoose, moving, onPick, onGiveBack, onBook }) {
  const scroll = useRef(null);
  const columns = useRef(null);
  const drag = useRef(null);
  const days = Array.from({ length: count }, (_, index) => dayAfter(first, index));
  const now = new Date();
  useEffect(() => {
    const there = scroll.current;
    there.scrollTop = (there.scrollHeight * FIRST_SHOWN_MIN) / DAY_MIN;
  }, []);

  function at(event) {
    const box = columns.current.getBoundingClientRect();
    const index = Math.floor(((event.clientX - box.left) / box.width) * count);
    return {
      day: days[Math.min(Math.max(index, 0), count - 1)],
      minutes: ((event.clientY - box.top) / box.height) * DAY_MIN,
    };
  }

  function press(event) {
    if (!event.isPrimary || event.button !== 0 || event.target.closest(".booked")) return;
    const { day, minutes } = at(event);
    const held = event.target.closest(".chosen-time");
    if (held && chosen) {
      const resizes = Boolean(event.target.closest(".longer"));
      drag.current = { resizes, grip: minutes - chosen.from };
    } else if (event.pointerType === "touch") return; // a finger scrolls; a tap chooses an hour
    else drag.current = { from: Math.floor(minutes / STEP_MIN) * STEP_MIN, day };
    event.preventDefault();
    event.currentTarget.focus();
    event.currentTarget.setPointerCapture(event.pointerId);
  }

  function pull(event) {
    const held = drag.current;
    if (!held) return;
    const { day, minutes } = at(event);
    held.moved = true;
    if (held.resizes) onChoose(within({ ...chosen, to: Math.max(snapped(minutes), chosen.from + STEP_MIN) }));
    else if (held.grip !== undefined) {
      const from = snapped(minutes - held.grip);
      onChoose(within({ day, from, to: from + chosen.to - chosen.from }));
    } else {
      const to = snapped(minutes);
      const [first, last] = to > held.from ? [held.from, to] : [to, held.from + STEP_MIN];
      onChoose(within({ day: held.day, from: first, to: last }));
    }
  }

  function letGo(event) {
    const held = drag.current;
    drag.current = null;
    if (held ? held.moved || held.from === undefined : event.pointerType !== "touch") return;
    if (event.target.closest(".booked, .chosen-time")) return;
    const { day, minutes } = at(event);
    const from = Math.floor(minutes / (2 * STEP_MIN)) * 2 * STEP_MIN;
    onChoose(within({ day, from, to: from + USUAL_MIN }));
  }

  function key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("button")) return;
    if (event.key === "Escape") onChoose(null);
    else if (event.key === "Enter" && chosen) onBook();
    else if (event.key in KEYS) {
      const [side, along] = KEYS[event.key];
      if (!chosen) {
        const hour = Math.min((now.getHours() + 1) * 60, DAY_MIN - USUAL_MIN);
        const today = days.find((day) => dayText(day) === dayText(now));
        const from = today ? hour : 9 * 60;
        onChoose({ day: today || first, from, to: from + USUAL_MIN });
      } else if (event.shiftKey) onChoose(within({ ...chosen, to: chosen.to + along }));
      else {
        const day = dayAfter(chosen.day, side);
        onChoose(within({ day, from: chosen.from + along, to: chosen.to + along }));
      }
    } else return;
    event.preventDefault();
    requestAnimationFrame(() => columns.current?.querySelector(".chosen-time")?.scrollIntoView({ block: "nearest" }));
  }

  const hours = Array.from({ length: 24 }, (_, hour) => hour);
  return html`<div class="week" ref=${scroll}>
    <div class="week-head">
      <span></span>
      <div>
      ${days.map(
        (day) => html`<span class=${dayText(day) === dayText(now) ? "today" : ""}>
          ${day.toLocaleDateString(spoken(), { weekday: "short" })} <b>${day.getDate()}</b>
        </span>`,
      )}
      </div>
    </div>
    <div class="week-body">
      <ol class="hours" aria-hidden="true">
        ${hours.map((hour) => html`<li style=${{ top: share(hour * 60) }}>${timeText(hour * 60)}</li>`)}
      </ol>
      <div
        class="days"
        ref=${columns}
        tabindex="0"
        role="group"
        aria-roledescription=${t("calendar")}
        aria-label=${t("Choose a time: arrow keys move it, with Shift they make it longer or shorter, Enter books it, Escape leaves it")}
        onPointerDown=${press}
        onPointerMove=${pull}
        onPointerUp=${letGo}
        onPointerCancel=${() => (drag.current = null)}
        onKeyDown=${key}
      >
        ${days.map(
          (day) => html`<ol class=${`day ${dayText(day) === dayText(now) ? "today" : ""}`} key=${dayText(day)}>
            ${onDay(bookings, day).map(
              (each) => html`<${Booked}
                key=${each.booking.id}
                ...${each}
                picked=${moving?.id === each.booking.id}
                onPick=${onPick}
                onGiveBack=${onGiveBack}
              />`,
            )}
            ${chosen &&
            dayText(chosen.day) === dayText(day) &&
            html`<li class="chosen-time" key="chosen" style=${placed(chosen.from, chosen.to)}>
              ${timeText(chosen.from)}–${timeText(chosen.to)}<i class="longer" aria-hidden="true"></i>
            </li>`}
            ${dayText(day) === dayText(now) &&
            html`<li class="now" key="now" aria-hidden="true" style=${{ top: share(minutesOn(day, now)) }}></li>`}
          </ol>`,
        )}
      </div>
    </div>
    <p class="hidden" role="status">${chosen ? timeWords(chosen) : ""}</p>
  </div>`;
}
