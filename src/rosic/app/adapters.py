"""Adapters by name, from entry points: one of a stranger's is found like one of ours."""

from __future__ import annotations

from difflib import get_close_matches
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, cast

from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from rosic.contracts.adapter import MessengerFactory, RobotFactory

MESSENGERS = "rosic.messengers"
ROBOTS = "rosic.robots"


def messenger_factory(kind: str) -> MessengerFactory:
    """Return the factory of a kind of messenger.

    Raises:
        ConfigurationError: There is no such kind, or what it needs is not installed.
    """
    return cast("MessengerFactory", _load(MESSENGERS, kind, "messenger"))


def robot_factory(kind: str) -> RobotFactory:
    """Return the factory of a kind of robot link.

    Raises:
        ConfigurationError: There is no such kind, or what it needs is not installed.
    """
    return cast("RobotFactory", _load(ROBOTS, kind, "robot link"))


def check_robot_kind(kind: str) -> None:
    """Look whether a kind of robot link exists; what it needs may be missing on this machine.

    Raises:
        ConfigurationError: There is no such kind.
    """
    _find(ROBOTS, kind, "robot link")


def _find(group: str, kind: str, what: str) -> EntryPoint:
    found = _installed(group)
    if kind not in found:
        near = get_close_matches(kind, found, n=1)
        hint = f"Did you mean {near[0]}?" if near else f"There are: {', '.join(sorted(found))}."
        raise ConfigurationError(f"There is no {what} of the kind {kind!r}.", hint=hint)
    return found[kind]


def _load(group: str, kind: str, what: str) -> object:
    entry = _find(group, kind, what)
    try:
        return entry.load()
    except AttributeError as broken:
        raise ConfigurationError(
            f"The {what} {kind!r} is not what its package says it is.",
            hint="Install that package again.",
        ) from broken
    except ModuleNotFoundError as missing:
        raise ConfigurationError(
            f"The {what} {kind!r} needs {missing.name}, which is not installed.",
            hint=f"Install it with: pip install 'rosic[{kind}]'",
        ) from missing


@cache
def _installed(group: str) -> dict[str, EntryPoint]:
    """Look once: reading what every installed package offers takes some 20 ms each time."""
    return {entry.name: entry for entry in entry_points(group=group)}
