// The libraries of the page, in one place: components by Preact, their markup by htm.

import { h, render } from "./vendor/preact.mjs";
import { useEffect, useLayoutEffect, useRef, useState } from "./vendor/hooks.mjs";
import htm from "./vendor/htm.module.js";

/** Markup: whatever is put into it is text, never HTML. */
export const html = htm.bind(h);
export { render, useEffect, useLayoutEffect, useRef, useState };

/** A table, scrolled also by the keyboard where it is larger than its place. */
export const Table = ({ label, kind, tall = false, heads, children }) => html`<div
  class=${tall ? "scroll tall" : "scroll"}
  tabindex="0"
  role="region"
  aria-label=${label}
>
  <table class=${kind}>
    <thead>
      <tr>
        ${heads.map((head) => html`<th scope="col">${head}</th>`)}
      </tr>
    </thead>
    ${children}
  </table>
</div>`;

/** The moment, again and again: for what is told by how long it has lasted. */
export function useNow(everyMs) {
  const [now, setNow] = useState(() => performance.now());
  useEffect(() => {
    const timer = setInterval(() => setNow(performance.now()), everyMs);
    return () => clearInterval(timer);
  }, [everyMs]);
  return now;
}

/** A name that nobody else has: 16 random bytes in hexadecimal digits. */
export function newId() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}
