"""A good profile, and ways to spoil it."""

from __future__ import annotations

import tomllib
from pathlib import Path

MARK = "#!"
ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
# What else is installed here is not ROSIC's.
SHIPPED_KINDS = tuple(sorted(PROJECT["entry-points"]["rosic.robots"]))

GOOD = """\
id: rover
title: Rover
words: [buggy]
groups: [fleet1]
link: { kind: ros2, namespace: /rover }
stop: { service: /rover/stop, type: std_srvs/srv/Trigger, zero: /rover/cmd_vel }
link_loss: hold
busy: refuse
queue_length: 16
watchdog_s: 0.5
at_rest:
  topic: /rover/odom
  type: nav_msgs/msg/Odometry
  field: "twist.twist.linear.x, twist.twist.angular.z"
  below: 0.01
rest_timeout_s: 5
skills:
  move:
    title: Move
    class: motion
    words: [shift]
    lifetime_s: 5
    parameters:
      direction:
        choices:
          forward: [ahead]
          back: [backwards]
        default: forward
      distance: { unit: m, min: 0.1, max: 5 }
      steps: { min: 1, max: 9, integer: true, default: 3 }
    action:
      name: /rover/move
      type: rosic_interfaces/action/Move
      goal: { direction: $direction, distance_m: $distance, steps: $steps }
      timeout_s: 60
      start: start_at
  drive:
    class: motion
    parameters:
      speed: { unit: m/s, min: -1, max: 1 }
      duration: { unit: s, min: 0.1, max: 5 }
    topic:
      name: /rover/cmd_vel
      type: geometry_msgs/msg/Twist
      message: { linear.x: $speed }
      stream_hz: 10
  light:
    class: task
    parameters:
      state: { choices: { on: [], off: [] }, means: { on: { value: true }, off: { value: false } } }
    service:
      name: /rover/light
      type: std_srvs/srv/SetBool
      request: { data: $state.value }
  tune:
    class: config
    parameters:
      gain: { min: 0, max: 1, default: 0.5 }
    set_parameters: { node: /rover/driver, values: { gain: $gain } }
telemetry:
  battery:
    topic: /rover/battery
    type: sensor_msgs/msg/BatteryState
    field: percentage
    unit: "%"
    alert_below: 20
camera: { topic: /rover/camera, type: sensor_msgs/msg/CompressedImage }
"""

DIALOGUE = """\
id: talker
link: { kind: ros2, namespace: /talker, dialogue: true }
skills:
  say: { class: task, parameters: { text: { text: true } } }
"""


def spoil(old: str, new: str, text: str = GOOD) -> str:
    """Replace one piece of a text that stands in it once."""
    assert text.count(old) == 1, f"{old!r} stands there {text.count(old)} times"
    return text.replace(old, new)


def marked_line(text: str) -> int:
    """Return the number of the line that carries the mark."""
    [line] = [number for number, line in enumerate(text.splitlines(), 1) if MARK in line]
    return line


def write(folder: Path, text: str, name: str = "rover.yaml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path
