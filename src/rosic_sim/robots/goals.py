"""From what a profile's binding sends to what a machine takes, and back to what a profile names."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.robots.ros2.profile import Ros2Skill, TopicBinding
from rosic_sim.robots.machines.activity import ActivityRefused
from rosic_sim.robots.machines.mecanum import Velocity

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.robot.profile import Profile
    from rosic.core.robot.skill import Argument, Skill
    from rosic_sim.robots.machines.arguments import Value

# The actions of rosic_interfaces serve several machines; a field that a machine has no use for
# is left out, one that it knows by another name is renamed.
UNUSED = {
    ("omni", "goto"): {"z_m"},
    ("watcher", "goto"): {"z_m"},
    ("rover", "goto"): {"z_m"},
    ("crazyflie", "goto"): {"yaw_rad"},
}
RENAMED = {("omni", "arm"): {"name": "pose"}}
# Of a Twist, and below STAMPED of a TwistStamped; a machine that drives on a floor has no others.
PLANAR = ("linear.x", "linear.y", "angular.z")
STAMPED = "twist."


def machine_arguments(model: str, skill: str, goal: Mapping[str, Value]) -> dict[str, Value]:
    """Return the machine's arguments for a goal's fields."""
    unused = UNUSED.get((model, skill), set())
    renamed = RENAMED.get((model, skill), {})
    return {renamed.get(name, name): v for name, v in goal.items() if name not in unused}


def goal_of(skill: Skill, arguments: Mapping[str, Argument]) -> dict[str, Value]:
    """Return the goal that the skill's action would carry, placeholders filled (SI)."""
    if not isinstance(skill, Ros2Skill) or skill.action is None:
        return dict(arguments)
    filled = {field: skill.filled(value, arguments) for field, value in skill.action.goal.items()}
    # A machine takes no rows of numbers: as a text, one is refused by its name.
    return {field: str(v) if isinstance(v, tuple) else v for field, v in filled.items()}


def topic_of(skill: Skill) -> TopicBinding | None:
    """Return the topic that a skill would be sent over."""
    return skill.topic if isinstance(skill, Ros2Skill) else None


def velocity_of(robot: str, skill: Skill, arguments: Mapping[str, Argument]) -> Velocity:
    """Return the velocity that the skill's topic would carry: m/s forward and to the left, rad/s.

    Raises:
        ActivityRefused: It carries none of them.
    """
    topic = topic_of(skill)
    message = {} if topic is None else topic.message
    given = {field.removeprefix(STAMPED): value for field, value in message.items()}
    if given.keys().isdisjoint(PLANAR):
        fields = ", ".join(PLANAR)
        sentence = said("is driven by {fields}, and this skill sends none of them", fields=fields)
        raise ActivityRefused(robot, sentence)
    values = [skill.filled(given.get(field, 0.0), arguments) for field in PLANAR]
    numbers = [float(v) for v in values if isinstance(v, int | float)]
    if len(numbers) < len(values):
        raise ActivityRefused(robot, said("a velocity is not a finite number"))
    return Velocity(*numbers)


def described(measured: Mapping[str, float | str], profile: Profile) -> dict[str, float | str]:
    """Return what the profile names, in its units: ``x`` for what the machine calls ``x_m``."""
    values: dict[str, float | str] = {}
    for name, key in _keys(tuple(profile.telemetry), tuple(measured)):
        value = measured[key]
        percent = profile.telemetry[name].unit == "%" and not isinstance(value, str)
        values[name] = value * 100 if percent else value
    return values


@lru_cache(maxsize=64)
def _keys(names: tuple[str, ...], measured: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Return what the profile names, each with what the machine calls it."""
    return tuple(
        (name, key)
        for name in names
        for key in [each for each in measured if each == name or each.startswith(f"{name}_")][:1]
    )
