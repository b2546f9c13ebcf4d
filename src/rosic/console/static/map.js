// Where robots say that they are, and the way they came.

import { html, useState } from "./lib.js";
import { poseText } from "./robots.js";
import { state, useStore } from "./store.js";
import { t } from "./texts.js";

const MARGIN_M = 1;
const LEAST_M = 4;
const COLOURS = 6;

function frames(robots) {
  const found = new Map();
  for (const { presence } of robots) {
    if (presence.pose) found.set(presence.pose.frame, (found.get(presence.pose.frame) || 0) + 1);
  }
  return [...found.keys()].sort((one, other) => found.get(other) - found.get(one));
}

function bounds(points) {
  const xs = points.map((p) => p.x);
  const ys = points.map((p) => p.y);
  const [left, right] = [Math.min(...xs), Math.max(...xs)];
  const [low, high] = [Math.min(...ys), Math.max(...ys)];
  const width = Math.max(right - left + 2 * MARGIN_M, LEAST_M * 1.6);
  const height = Math.max(high - low + 2 * MARGIN_M, LEAST_M);
  return { x: (left + right - width) / 2, y: (low + high - height) / 2, width, height };
}

const apart = (one, other) => Math.hypot(one.x - other.x, one.y - other.y);

const APART_AT_MOST = 40; // robots: of more, each is drawn where it is

/** Return where robots are drawn: those that would hide each other one below the other. */
function besideEachOther(points, size) {
  if (points.length > APART_AT_MOST) return points;
  const drawn = [];
  for (const point of points) {
    const at = { ...point };
    const hides = (other) => apart(at, other) < 1.2 * size;
    // Each time below another one at least: but not where a robot says that it is beyond all numbers.
    for (let left = 2 * drawn.length; left > 0 && drawn.some(hides); left--) at.y -= 2.3 * size;
    drawn.push(at);
  }
  return drawn;
}

/** Return how wide a square is: a robot may say that it is anywhere, and lines cost time. */
function squareOf({ width, height }) {
  const wide = Math.max(width / 1.6, height);
  if (wide <= 300) return height > 30 ? 5 : 1;
  return 10 ** Math.ceil(Math.log10(wide / 60));
}

/** Return the multiples of a step within a length; by count, as far out adding a step adds nothing. */
function multiples(from, length, step) {
  const first = Math.ceil(from / step);
  const count = Math.floor((from + length) / step) - first + 1;
  return Array.from({ length: Math.max(0, Math.min(count, 500)) }, (_, at) => (first + at) * step);
}

function Grid({ box, step }) {
  const lines = [];
  for (const x of multiples(box.x, box.width, step)) {
    lines.push(html`<line x1=${x} x2=${x} y1=${-box.y} y2=${-box.y - box.height} />`);
  }
  for (const y of multiples(box.y, box.height, step)) {
    lines.push(html`<line x1=${box.x} x2=${box.x + box.width} y1=${-y} y2=${-y} />`);
  }
  return html`<g class="grid">${lines}</g>`;
}

/** The robots of one frame on a map with a grid. */
export function PoseMap() {
  const { robots, tracks, link } = useStore();
  const [wanted, choose] = useState("");
  const all = frames(robots.values());
  const frame = all.includes(wanted) ? wanted : all[0];
  const there = [...robots.values()].filter(({ presence: { pose } }) => pose && pose.frame === frame);
  if (!there.length) return html`<p class="quiet">${t("No robot says where it is.")}</p>`;
  const ways = there.map((robot) =>
    (tracks.get(robot.id) || []).filter((point) => point.frame === frame),
  );
  const now = there.map(({ presence: { pose } }) => ({ x: pose.x_m, y: pose.y_m }));
  const drawn = besideEachOther(now, bounds([...now, ...ways.flat()]).height / 22);
  const box = bounds([...now, ...drawn, ...ways.flat()]);
  const size = box.height / 22;
  const step = squareOf(box);
  const moved = drawn.some((at, index) => at.y !== now[index].y);
  const told = there.map((robot) => `${robot.name}: ${poseText(robot.presence.pose)}`).join("; ");
  return html`<figure class="map">
    ${all.length > 1 &&
    html`<label class="field">
      ${t("Frame")}
      <select value=${frame} onChange=${(event) => choose(event.target.value)}>
        ${all.map((each) => html`<option value=${each}>${each}</option>`)}
      </select>
    </label>`}
    <svg
      role="img"
      aria-label=${told}
      class=${link === "up" ? "" : "old"}
      viewBox=${`${box.x} ${-box.y - box.height} ${box.width} ${box.height}`}
    >
      <${Grid} box=${box} step=${step} />
      ${there.map((robot, index) => {
        const pose = robot.presence.pose;
        const at = drawn[index];
        const way = ways[index].map((point) => `${point.x},${-point.y}`).join(" ");
        const degrees = (-(pose.yaw_rad || 0) * 180) / Math.PI;
        return html`<g class=${`c${index % COLOURS}`} key=${robot.id}>
          <polyline class="way" points=${way} stroke-width=${size / 6} />
          <line class="way" x1=${pose.x_m} y1=${-pose.y_m} x2=${at.x} y2=${-at.y} stroke-width=${size / 12} />
          <g transform=${`translate(${at.x} ${-at.y}) rotate(${degrees})`}>
            <circle r=${size * 0.62} />
            ${pose.yaw_rad !== null &&
            html`<path class="nose" d=${`M${size * 0.5} 0L${-size * 0.25} ${size * 0.32}L${-size * 0.08} 0L${-size * 0.25} ${-size * 0.32}Z`} />`}
          </g>
          <text x=${at.x} y=${-at.y - size * 0.9} font-size=${size * 0.85} text-anchor="middle">
            ${robot.name}
          </text>
        </g>`;
      })}
    </svg>
    <figcaption>
      ${t("Frame {frame}; a square is {step} m wide.", { frame: frame || "–", step })}${" "}
      ${moved && t("Robots that stand close together are drawn one below the other; a line leads to where each is.")}
    </figcaption>
  </figure>`;
}
