// What the page says, in the language of whoever reads it; the catalogue is the gateway's.

const LANGUAGES = ["en", "de"];
let words = {};
let language = "en";

/** Return a sentence in the reader's language; fields in braces are filled. */
export function t(template, parts = {}) {
  const found = words[template] || template;
  return found.replace(/\{(\w+)\}/g, (field, name) => (name in parts ? String(parts[name]) : field));
}

/** Return the language that is spoken now. */
export const spoken = () => (language === "en" ? "en-GB" : language);

/** Speak a language from now on; English where it is not to be had. */
export async function speak(wanted) {
  const code = LANGUAGES.includes(wanted) ? wanted : "en";
  if (code !== language) {
    let found = {};
    if (code !== "en") {
      try {
        const answer = await fetch(`/console/texts/${code}.json`);
        if (!answer.ok) return;
        found = await answer.json();
      } catch {
        return;
      }
    }
    words = found;
    language = code;
  }
  document.documentElement.lang = language;
}

/** Return the first language that this browser asks for and the page speaks. */
export function ofBrowser() {
  const asked = (navigator.languages || [navigator.language]).map((each) => each.slice(0, 2));
  return asked.find((each) => LANGUAGES.includes(each)) || "en";
}

/** Return a number as it is written in the reader's language. */
export function number(value, digits = 2) {
  return value.toLocaleString(spoken(), { maximumFractionDigits: digits });
}

/** Return a unit as it is written everywhere. */
export const unitSign = (unit) => unit.replace(/^deg\b/, "°");

/** Return the time of day of a moment (RFC 3339). */
export function clock(moment) {
  return new Date(moment).toLocaleTimeString(spoken(), {
    hour: "2-digit",
    minute: "2-digit",
    second: "2-digit",
    hourCycle: "h23",
  });
}
