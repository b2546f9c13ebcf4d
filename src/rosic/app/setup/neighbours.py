"""Telling robots apart that live in one namespace, as far as their names show it."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, Final

from rosic.app.setup.profile_draft import ODOMETRY, STAMPED, TWIST

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosic.robots.ros2.client.graph import GraphTopic

MIXED: Final = "# More than one robot seems to live in"
RESTING: Final = ("odom", "joint_states")
DRIVING: Final = frozenset({TWIST, STAMPED})
VELOCITIES: Final = "cmd_vel"
_BELOW: Final = 3
"""``/lab/omni/odom`` has as many slashes."""


def homes(topics: Iterable[GraphTopic]) -> frozenset[str]:
    """Return namespaces like ``/lab/omni`` whose robots have neighbours of their kind beside them.

    An arm and the base that carries it are of two kinds, and one robot.
    """
    found: defaultdict[tuple[str, str], set[str]] = defaultdict(set)
    topics = tuple(topics)
    driven = {below(t.name) for t in topics if t.subscribers and not DRIVING.isdisjoint(t.types)}
    for topic in topics:
        _, *spaces, name = topic.name.split("/")
        if topic.publishers and name in RESTING and topic.name.count("/") >= _BELOW:
            found[spaces[0], name].add(f"/{spaces[0]}/{spaces[1]}")
        elif topic.publishers and ODOMETRY in topic.types and below(topic.name) in driven - {""}:
            found[spaces[0], ODOMETRY].add(below(topic.name))
    return frozenset().union(*(several for several in found.values() if len(several) > 1))


def below(name: str) -> str:
    """Return ``/lab/omni`` of what is below it; empty for what is not so deep."""
    return "/".join(name.split("/")[:_BELOW]) if name.count("/") >= _BELOW else ""


def drives(heard: Mapping[str, str]) -> bool:
    """Tell whether velocities are taken there, under whatever name."""
    return not DRIVING.isdisjoint(heard.values())


def mixed(namespace: str, topics: Iterable[GraphTopic]) -> str:
    """Return the line that says that one namespace holds more than one robot; empty if it does not.

    Args:
        namespace: As people write it.
        topics: Those of that namespace.
    """
    topics = tuple(topics)
    twice = [t.name for t in topics if ODOMETRY in t.types and t.publishers > 1]
    odometries = {
        t.name.removesuffix("odom") for t in topics if t.publishers and ODOMETRY in t.types
    }
    driven = {t.name.removesuffix(VELOCITIES) for t in topics if t.subscribers}
    bases = sorted(odometries & driven)
    if twice:
        why = f"{twice[0]} is published by more than one node"
    elif len(bases) > 1:
        why = " and ".join(f"{base}{VELOCITIES}" for base in bases) + " move one each"
    else:
        return ""
    return (
        f"{MIXED} {namespace}, as {why}: this draft mixes them. "
        "Give each a namespace of its own and draft again.\n"
    )
