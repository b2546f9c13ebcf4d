// Live: the panel of rates, connections, commands sent and commands received, as they happen.

import { Camera, Telemetry } from "./charts.js";
import { html, Table } from "./lib.js";
import { PoseMap } from "./map.js";
import { Orders } from "./orders.js";
import { NoRobot, RobotCard } from "./robots.js";
import { useStore } from "./store.js";
import { number, t } from "./texts.js";

const rate = (value) => `${number(value, 1)}\u00a0/s`;

function bytes(value) {
  if (value === undefined) return "—";
  return value < 1000 ? `${number(value, 0)}\u00a0B/s` : `${number(value / 1000, 1)}\u00a0kB/s`;
}

function Rates() {
  const { rates, robots } = useStore();
  const messengers = rates ? rates.messengers : [];
  return html`<${Table}
    label=${t("Data rate")}
    kind="rates"
    heads=${[t("Messenger or robot"), t("Sent"), t("Received")]}
  >
    <tbody>
      ${messengers.map(
        (each) => html`<tr key=${`m ${each.name}`}>
          <th scope="row">${each.name}</th>
          <td>${rate(each.out_per_s)} <small>${bytes(each.out_bytes_s)}</small></td>
          <td>${rate(each.in_per_s)} <small>${bytes(each.in_bytes_s)}</small></td>
        </tr>`,
      )}
      ${[...robots.values()].map((robot) => {
        const each = rates?.robots.get(robot.id);
        return html`<tr key=${`r ${robot.id}`}>
          <th scope="row">${robot.name}</th>
          <td>${each ? rate(each.sent_per_s) : "—"}</td>
          <td>${each ? rate(each.received_per_s) : "—"}</td>
        </tr>`;
      })}
    </tbody>
  <//>`;
}

/** The page on the wall. */
export function Live({ robot: wanted, onRobot }) {
  const { robots } = useStore();
  const all = [...robots.values()];
  const robot = robots.get(wanted) || all.find((each) => each.presence.pose) || all[0];
  return html`<div class="live">
    <section class="panel robots" aria-labelledby="h-robots">
      <h2 id="h-robots">${t("Connection status")}</h2>
      ${all.length
        ? html`<ul class="cards">
            ${all.map(
              (each) =>
                html`<${RobotCard}
                  key=${each.id}
                  robot=${each}
                  chosen=${each.id === robot?.id}
                  onChoose=${() => onRobot(each.id)}
                />`,
            )}
          </ul>`
        : html`<${NoRobot} />`}
    </section>
    <section class="panel commands" aria-labelledby="h-commands">
      <h2 id="h-commands">${t("Commands sent to the robot, and received by it")}</h2>
      <${Orders} />
    </section>
    <section class="panel rate" aria-labelledby="h-rates">
      <h2 id="h-rates">${t("Data rate")}</h2>
      <${Rates} />
    </section>
    <section class="panel where" aria-labelledby="h-map">
      <h2 id="h-map">${t("Map")}</h2>
      <${PoseMap} />
    </section>
    ${robot &&
    html`<section class="panel telemetry" aria-labelledby="h-telemetry">
        <h2 id="h-telemetry">${t("Telemetry of {robot}", { robot: robot.name })}</h2>
        <${Telemetry} key=${robot.id} robot=${robot} />
      </section>
      <section class="panel view" aria-labelledby="h-camera">
        <h2 id="h-camera">${t("Camera of {robot}", { robot: robot.name })}</h2>
        <${Camera} key=${robot.id} robot=${robot} />
      </section>`}
  </div>`;
}
