"""The arguments of one skill, read with their bounds."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, TypeAlias

from rosic.core.i18n import said
from rosic_sim.robots.machines.activity import ActivityRefused

if TYPE_CHECKING:
    from collections.abc import Mapping

Value: TypeAlias = float | str | int | bool


class MachineArguments:
    """Typed access to a mapping from outside; every fault becomes `ActivityRefused`.

    The container has checked all this before. A machine checks again, because inside a ROS 2 node
    anybody on the graph can call it.
    """

    def __init__(self, robot: str, skill: str, values: Mapping[str, Value]) -> None:
        self._robot = robot
        self._skill = skill
        self._values = values
        self._read: set[str] = set()

    def number(self, name: str, low: float, high: float, default: float | None = None) -> float:
        """Return a finite number in [low, high], in SI units.

        Raises:
            ActivityRefused: Missing without a default, not a number, or out of bounds.
        """
        value = self._values.get(name, default)
        self._read.add(name)
        if value is None:
            raise ActivityRefused(
                self._robot, said("{skill} needs {name}", skill=self._skill, name=name)
            )
        if isinstance(value, (bool, str)) or not isfinite(value):
            raise ActivityRefused(self._robot, said("{name} is not a number", name=name))
        if not low <= value <= high:
            raise ActivityRefused(
                self._robot,
                said(
                    "{name} must be between {low:g} and {high:g}, not {value:g}",
                    name=name,
                    low=low,
                    high=high,
                    value=value,
                ),
            )
        return float(value)

    def choice(self, name: str, choices: tuple[str, ...], default: str | None = None) -> str:
        """Return one of ``choices``.

        Raises:
            ActivityRefused: Missing without a default, or something else.
        """
        value = self._values.get(name, default)
        self._read.add(name)
        if value not in choices:
            raise ActivityRefused(
                self._robot,
                said("{name} must be one of {choices}", name=name, choices=", ".join(choices)),
            )
        return str(value)

    def has(self, name: str) -> bool:
        """Tell whether an optional argument was given."""
        return name in self._values

    def finish(self) -> None:
        """Refuse what nobody asked for: a misspelt argument must not be ignored.

        Raises:
            ActivityRefused: An argument was given that the skill did not read.
        """
        for name in self._values:
            if name not in self._read:
                raise ActivityRefused(
                    self._robot,
                    said("{skill} knows no {name!r}", skill=self._skill, name=str(name)[:40]),
                )
