// Live control: a stick on the screen, arrow keys or a gamepad steer a robot while they are held.
//
// Letting go is a release, and so is everything that is not holding on: another page, another window,
// a connection that is gone. Each sample says when it was sent; the gateway drops what is late.

import { html, useEffect, useRef, useState } from "./lib.js";
import { listen, send } from "./store.js";
import { number, t } from "./texts.js";

const SAMPLE_MS = 66; // 15 a second
const DEAD_ZONE = 0.12;
const RADIUS = 70;
const DURATION = "duration";

/** Return which parameters the two directions of a stick steer: [forward, left]. */
export function axesOf(skill) {
  const numbers = Object.entries(skill.arguments.properties).filter(
    ([name, each]) => each.minimum !== undefined && name !== DURATION,
  );
  const named = (pattern) => numbers.find(([name]) => pattern.test(name))?.[0];
  const forward = named(/^(linear|x|vx|forward|speed|velocity)/) || numbers[0]?.[0];
  const left = named(/^(angular|turn|yaw|wz|rotation)/) || numbers.find(([n]) => n !== forward)?.[0];
  return [forward, left];
}

/** Return the value of a parameter for a deflection in [-1, 1], within its bounds. */
export function valueOf(schema, deflection) {
  const most = deflection >= 0 ? schema.maximum : -schema.minimum;
  return deflection * Math.max(0, most);
}

const KEYS = {
  ArrowUp: [1, 0],
  KeyW: [1, 0],
  ArrowDown: [-1, 0],
  KeyS: [-1, 0],
  ArrowLeft: [0, 1],
  KeyA: [0, 1],
  ArrowRight: [0, -1],
  KeyD: [0, -1],
};

function ofKeys(held) {
  let [forward, left] = [0, 0];
  for (const key of held) {
    forward += KEYS[key][0];
    left += KEYS[key][1];
  }
  return [Math.sign(forward), Math.sign(left)];
}

function ofGamepad() {
  for (const pad of navigator.getGamepads?.() || []) {
    if (!pad || !pad.connected) continue;
    const [side, ahead] = pad.axes;
    if (Math.hypot(side || 0, ahead || 0) > DEAD_ZONE) return [-(ahead || 0), -(side || 0)];
  }
  return null;
}

/** The controls of one robot. */
export function Jog({ robot, skills }) {
  const [chosen, choose] = useState(skills[0].id);
  const [share, setShare] = useState(0.5);
  const [said, say] = useState("");
  const [shown, show] = useState([0, 0]);
  const pad = useRef(null);
  const skill = skills.find((each) => each.id === chosen) || skills[0];
  const [forward, left] = axesOf(skill);
  const steer = useRef({ held: new Set(), stick: null, going: false, ended: true, first: 0, n: 0 });

  useEffect(() => {
    const now = steer.current;
    const told = [
      listen("jog", (event) => {
        if (event.robot !== robot.id || event.first !== now.first) return;
        if (event.over) now.ended = true;
        say(event.text);
      }),
      listen("gone", () => {
        letGo();
        say(t("The connection is lost: the robot comes to rest by itself."));
      }),
    ];
    function deflection() {
      if (now.stick) return now.stick;
      if (now.held.size) return ofKeys(now.held);
      return ofGamepad();
    }
    function sample() {
      const deflected = deflection();
      if (deflected && !document.hasFocus()) {
        if (now.going) release();
        now.ended = true; // whoever comes back lets go first
        return;
      }
      if (!deflected) {
        if (now.going) release();
        now.ended = false;
        return;
      }
      show(deflected);
      if (now.ended) return; // nothing goes on by itself: whoever wants that lets go first
      const { properties } = skill.arguments;
      const values = {};
      if (forward) values[forward] = share * valueOf(properties[forward], deflected[0]);
      if (left) values[left] = share * valueOf(properties[left], deflected[1]);
      now.n += 1;
      if (!now.going) now.first = now.n;
      now.going = send({ op: "jog", robot: robot.id, skill: skill.id, values, sent_ms: Date.now(), n: now.n });
      if (!now.going) now.ended = true;
    }
    function release() {
      now.going = now.ended = false;
      show([0, 0]);
      send({ op: "jog", robot: robot.id, skill: skill.id, values: {}, sent_ms: Date.now(), n: ++now.n, release: true });
    }
    function letGo() {
      now.held.clear();
      now.stick = null;
      if (now.going) release();
      now.ended = true; // what is still held goes on only once it was let go
      show([0, 0]);
    }
    /** A stick or a key is taken in hand: that is a new beginning, unless another is held. */
    function press() {
      if (now.stick || now.held.size) return;
      if (now.going) release();
      now.ended = false;
    }
    const timer = setInterval(sample, SAMPLE_MS);
    const away = () => letGo();
    addEventListener("blur", away);
    document.addEventListener("visibilitychange", away);
    Object.assign(now, { letGo, press });
    return () => {
      letGo();
      clearInterval(timer);
      removeEventListener("blur", away);
      document.removeEventListener("visibilitychange", away);
      told.forEach((end) => end());
    };
  }, [robot.id, chosen, share]);

  function at(event) {
    const box = pad.current.getBoundingClientRect();
    const x = (event.clientX - box.left - box.width / 2) / (box.width / 2);
    const y = (event.clientY - box.top - box.height / 2) / (box.height / 2);
    const far = Math.max(1, Math.hypot(x, y));
    return [-y / far, -x / far];
  }
  const take = (event) => {
    event.preventDefault();
    pad.current.focus();
    pad.current.setPointerCapture(event.pointerId);
    steer.current.press?.();
    steer.current.stick = at(event);
  };
  const move = (event) => steer.current.stick && (steer.current.stick = at(event));
  const key = (event, down) => {
    if (!(event.code in KEYS) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    if (!down) steer.current.held.delete(event.code);
    else if (!event.repeat) {
      steer.current.press?.();
      steer.current.held.add(event.code);
    }
  };
  const letGo = () => steer.current.letGo?.();

  return html`<div class="jogging">
    ${skills.length > 1 &&
    html`<label class="field">
      ${t("Skill")}
      <select value=${chosen} onChange=${(event) => choose(event.target.value)}>
        ${skills.map((each) => html`<option value=${each.id}>${each.name}</option>`)}
      </select>
    </label>`}
    <svg
      class="stick"
      ref=${pad}
      viewBox="-100 -100 200 200"
      tabindex="0"
      role="application"
      aria-label=${t("Stick: hold an arrow key or W, A, S, D to drive; let go to come to rest")}
      onPointerDown=${take}
      onPointerMove=${move}
      onPointerUp=${() => (steer.current.stick = null)}
      onPointerCancel=${() => (steer.current.stick = null)}
      onLostPointerCapture=${() => (steer.current.stick = null)}
      onKeyDown=${(event) => key(event, true)}
      onKeyUp=${(event) => key(event, false)}
      onBlur=${letGo}
    >
      <circle class="rim" r="96" />
      <path class="cross" d="M0-80V80M-80 0H80" />
      <path class="cross" d="M-9-70L0-82L9-70M-9 70L0 82L9 70M-70-9L-82 0L-70 9M70-9L82 0L70 9" />
      <circle class="knob" r="34" cx=${-shown[1] * RADIUS * 0.9} cy=${-shown[0] * RADIUS * 0.9} />
    </svg>
    <label class="field">
      ${t("At most {share} % of what is allowed", { share: number(share * 100, 0) })}
      <input
        type="range"
        min="0.1"
        max="1"
        step="0.1"
        value=${share}
        onInput=${(event) => setShare(Number(event.target.value))}
      />
    </label>
    <p class="quiet small">
      ${t("Hold the stick, an arrow key or a gamepad. Letting go brings the robot to rest.")}
    </p>
    <p class="said" role="status">${said}</p>
  </div>`;
}
