"""Whether those at the other end are still those with whom something began.

A process that was killed stays on the graph for 20 s (Fast DDS) beside the one that took its place:
both have the same node's name, and only their ends tell them apart.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosic.robots.ros2.client.rclpy_import import RosObject

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


def born_anew(first: Ends, now: Ends) -> bool:
    """Tell whether a node of the first is there a second time, or only others are there now.

    Who joins beside them, to look on, changes nothing.
    """
    if not first or not now:
        return False
    names = set(first.values()) - {""}
    again = any(name in names for gid, name in now.items() if gid not in first)
    return again or first.keys().isdisjoint(now)


def named_since(first: Ends, now: Ends) -> Ends:
    """Return the first, with the names that have come since: they come later than the ends."""
    return {gid: name or now.get(gid, "") for gid, name in first.items()}


class UnidentifiedEndpoints:
    """Ends that join those with whom something began, before it is known of whom they are.

    The end of a node is shown on the graph before the node's name is, by up to some seconds on a
    busy machine. Until then nobody knows whether it is one of the first, born anew. As long as one
    of the first has no name itself, whoever joins may be that one.

    Args:
        first: Those with whom it began.
        patience_s: How long a name is waited for.

    Attributes:
        first: They, with the names that have come since.
        waits: Of one who joined, it is not known who it is.
    """

    def __init__(self, first: Ends, patience_s: float) -> None:
        self.first = first
        self.waits = False
        self._patience_ns = patience_s * SECOND_NS
        self._since_ns = 0

    def nameless(self, now: Ends, now_ns: int) -> bool:
        """Take in who is there now; tell whether the name of one was waited for long enough."""
        self.first = named_since(self.first, now)
        unknown = "" in self.first.values()
        joined = [name for gid, name in now.items() if gid not in self.first]
        waited, self.waits = self.waits, any(unknown or not name for name in joined)
        if not waited:
            self._since_ns = now_ns
        return self.waits and now_ns - self._since_ns >= self._patience_ns
