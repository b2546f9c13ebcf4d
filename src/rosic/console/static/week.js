// Days and times of a calendar, in the reader's own zone; minutes of a day are as its clock shows.

export const STEP_MIN = 15;
export const DAY_MIN = 1440;

/** Return midnight of so many days after a day. */
export function dayAfter(day, days) {
  return new Date(day.getFullYear(), day.getMonth(), day.getDate() + days);
}

/** Return the Monday of the week of a moment. */
export function mondayOf(moment) {
  return dayAfter(moment, -((moment.getDay() + 6) % 7));
}

/** Return the moment at which the clock of a day shows so many minutes after midnight. */
export function momentOf(day, minutes) {
  return new Date(day.getFullYear(), day.getMonth(), day.getDate(), 0, minutes);
}

/** Return how many minutes after midnight the clock of a day shows; 0 or 1440 outside of it. */
export function minutesOn(day, moment) {
  if (moment <= day) return 0;
  if (moment >= dayAfter(day, 1)) return DAY_MIN;
  return moment.getHours() * 60 + moment.getMinutes();
}

const two = (number) => String(number).padStart(2, "0");

/** Return a day as its field has it: 2026-12-01. */
export const dayText = (day) => `${day.getFullYear()}-${two(day.getMonth() + 1)}-${two(day.getDate())}`;

/** Return minutes after midnight as a clock shows them: 14:15. */
export const timeText = (minutes) => `${two(Math.floor(minutes / 60) % 24)}:${two(minutes % 60)}`;

/** Return the day of a field; null where it is none. */
export function dayIn(text) {
  const found = text.match(/^(\d{4})-(\d\d)-(\d\d)$/);
  return found && new Date(Number(found[1]), Number(found[2]) - 1, Number(found[3]));
}

/** Return the minutes after midnight of a field; null where it is none. */
export function minutesIn(text) {
  const found = text.match(/^(\d\d):(\d\d)/);
  return found && Number(found[1]) * 60 + Number(found[2]);
}

/** Return minutes as a multiple of what a calendar is drawn in. */
export const snapped = (minutes) => Math.round(minutes / STEP_MIN) * STEP_MIN;

/** Return a time that lies in its day: { day, from, to }. */
export function within({ day, from, to }) {
  const long = Math.min(Math.max(to - from, STEP_MIN), DAY_MIN);
  const start = Math.min(Math.max(from, 0), DAY_MIN - long);
  return { day, from: start, to: start + long };
}

/** Return how long a time is, in minutes that really pass. */
export const lengthOf = ({ day, from, to }) =>
  Math.round((momentOf(day, to) - momentOf(day, from)) / 60_000);
