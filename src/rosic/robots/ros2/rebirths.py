"""Whether those at the other end are still those with whom something began.

A process that was killed stays on the graph for 20 s (Fast DDS) beside the one that took its place:
both have the same node's name, and only their ends tell them apart.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosic.robots.ros2.ros import RosObject

    Ends: TypeAlias = Mapping[bytes, str]
    """Ids of ends on the graph to their nodes' full names; empty as long as that is not known."""

UNKNOWN: Final = "_NODE_NAME_UNKNOWN_"


def ends_of(found: Iterable[RosObject]) -> Ends:
    """Return what rclpy says of the ends of a topic."""
    return {
        bytes(end.endpoint_gid): ""
        if end.node_name == UNKNOWN
        else f"{end.node_namespace.rstrip('/')}/{end.node_name}"
        for end in found
    }


def unnamed(first: Ends, now: Ends) -> bool:
    """Tell whether somebody has joined of whom it is not known yet whether it is one of them."""
    return any(not name and gid not in first for gid, name in now.items())


def born_anew(first: Ends, now: Ends) -> bool:
    """Tell whether a node of the first is there a second time, or only others are there now.

    Who joins beside them, to look on, changes nothing.
    """
    if not first or not now:
        return False
    names = set(first.values()) - {""}
    again = any(name in names for gid, name in now.items() if gid not in first)
    return again or first.keys().isdisjoint(now)
