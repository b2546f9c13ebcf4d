// Letting a robot go on after a stop: said as in the conversation, wherever it stands stopped.

import { command } from "./asked.js";
import { html, useEffect, useState } from "./lib.js";
import { t } from "./texts.js";

/** Beside the word that a robot is stopped; what has to be confirmed is asked in the conversation. */
export function Resume({ robot, old = false }) {
  const [said, say] = useState({ kind: "", text: "" });
  const [waits, wait] = useState(false);
  useEffect(() => say({ kind: "", text: "" }), [robot.id, robot.stopped]);
  if (!robot.stopped) return null;
  async function resume() {
    wait(true);
    const done = await command(`resume ${robot.id}`);
    wait(false);
    say(done.ok ? { kind: "", text: "" } : done);
  }
  return html`<button
      type="button"
      class="resume"
      disabled=${waits || old}
      onClick=${resume}
    >
      ${t("Resume {robot}", { robot: robot.name })}
    </button>
    ${said.text && html`<span class=${`said ${said.kind}`} role="alert">${said.text}</span>`}`;
}
