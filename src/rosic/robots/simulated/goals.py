"""From what a profile's binding sends to what a machine takes. One translation for both links."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.skill import Argument, Skill
    from rosic.robots.simulated.machines.arguments import Value

# The actions of rosic_interfaces serve several machines; a field that a machine has no use for
# is left out, one that it knows by another name is renamed.
UNUSED = {
    ("omni", "goto"): {"z_m"},
    ("watcher", "goto"): {"z_m"},
    ("rover", "goto"): {"z_m"},
    ("crazyflie", "goto"): {"yaw_rad"},
}
RENAMED = {("omni", "arm"): {"name": "pose"}}


def machine_arguments(model: str, skill: str, goal: Mapping[str, Value]) -> dict[str, Value]:
    """Return the machine's arguments for a goal's fields."""
    unused = UNUSED.get((model, skill), set())
    renamed = RENAMED.get((model, skill), {})
    return {renamed.get(name, name): v for name, v in goal.items() if name not in unused}


def goal_of(skill: Skill, arguments: Mapping[str, Argument]) -> dict[str, Value]:
    """Return the goal that the skill's action would carry, placeholders filled (SI)."""
    if skill.action is None:
        return dict(arguments)
    return {
        field: arguments[value[1:]] if isinstance(value, str) and value[:1] == "$" else value
        for field, value in skill.action.goal.items()
    }
