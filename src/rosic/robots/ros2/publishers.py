"""Who sent what is heard, and when: on our own clock, whatever theirs shows.

When a message comes here says little about when it was sent: a process that was frozen, or a
network that held words back, hands over what is from before a break.
"""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.robots.ros2.client.rclpy_import import RosObject

    About: TypeAlias = Mapping[str, RosObject]
    """What rclpy says of a message: who sent it, and when by the sender's wall clock."""
    Ends: TypeAlias = Mapping[bytes, str]
    """Ids of ends on the graph to their nodes' full names; empty as long as that is not known."""


# ---- endpoint identity ----

# Whether those at the other end are still those with whom something began.
#
# A process that was killed stays on the graph for 20 s (Fast DDS) beside the one that took its
# place: both have the same node's name, and only their ends tell them apart.

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


# ---- publishers ----

REMEMBERED: Final = 8
WINDOW_NS: Final = 30 * SECOND_NS
"""Clocks drift apart, and are set: how far they are apart counts for so long, and as long again."""

SENDS_WITHIN_NS: Final = 10 * SECOND_NS
"""Who was not heard for so long counts as one of several no more."""


class MessageInfoCallback:
    """A callback that hears of each message what rclpy knows of it.

    rclpy asks for the signature. The executor driven by events (9.1) then hands both over as one
    tuple, the other one as two arguments.
    """

    __signature__ = inspect.signature(lambda content, about: (content, about))

    def __init__(self, arrived: Callable[[bytes, About], None]) -> None:
        self._arrived = arrived

    def __call__(self, *given: RosObject) -> None:
        """Take a message; on the ROS thread."""
        content, about = given[0] if len(given) == 1 else given
        self._arrived(content, about)


class TopicPublishers:
    """Those who send on one topic. One that is new in the place of another was born anew.

    Attributes:
        told_apart: rclpy says who sent a message (9 and later).
        restarts: How often that has happened.
        born_ns: When the last of them had not sent anything yet.
    """

    def __init__(self) -> None:
        self.told_apart = True
        self.restarts = 0
        self.born_ns = 0
        self._known: dict[bytes, _Apart] = {}
        self._stamps_ns: dict[bytes, int] = {}

    def take(self, about: About, now_ns: int) -> int:
        """Take in that a message has come; return when it was sent, on our clock.

        Never later than now. Where rclpy does not say when it was sent, that is now.
        """
        gid = _gid(about)
        self.told_apart = gid != b""
        apart = self._known.get(gid)
        if apart is None:
            if self._known:
                self.restarts += 1
                self.born_ns = now_ns - 1
            while len(self._known) >= REMEMBERED:
                del self._known[next(iter(self._known))]
            apart = self._known[gid] = _Apart(now_ns)
        apart.last_ns = now_ns
        sent_ns = about.get("source_timestamp")
        self._newer(gid, int(sent_ns or 0))
        return now_ns if not sent_ns else now_ns - apart.late_ns(now_ns - int(sent_ns), now_ns)

    def take_kept(self, about: About, wall_ns: int) -> int | None:
        """Take in that a message has come that was kept; return for how long, by its stamp.

        It says nothing of who sends now. None: that message, or a newer one, is known already.
        """
        sent_ns = int(about.get("source_timestamp") or 0)
        return max(0, wall_ns - sent_ns) if self._newer(_gid(about), sent_ns) else None

    def _newer(self, gid: bytes, sent_ns: int) -> bool:
        if sent_ns <= self._stamps_ns.get(gid, -1):
            return False
        self._stamps_ns.pop(gid, None)
        while len(self._stamps_ns) >= REMEMBERED:
            del self._stamps_ns[next(iter(self._stamps_ns))]
        self._stamps_ns[gid] = sent_ns
        return True

    def several(self, now_ns: int) -> bool:
        """Tell whether more than one of them sends: one is heard on after another has begun."""
        known = tuple(self._known.values())
        sending = [apart for apart in known if now_ns - apart.last_ns <= SENDS_WITHIN_NS]
        newest = max(sending, key=lambda apart: apart.first_ns, default=None)
        return any(
            apart is not newest and newest is not None and apart.last_ns > newest.first_ns
            for apart in sending
        )


class _Apart:
    """How far a sender's clock and ours are apart: as the quickest of its messages shows.

    Attributes:
        first_ns, last_ns: When it was heard, by our clock.
    """

    __slots__ = ("_before_ns", "_least_ns", "_since_ns", "first_ns", "last_ns")

    def __init__(self, now_ns: int) -> None:
        self.first_ns = self.last_ns = now_ns
        self._since_ns = now_ns
        self._least_ns: int | None = None
        self._before_ns: int | None = None

    def late_ns(self, past_ns: int, now_ns: int) -> int:
        """Return for how long a message was under way beyond the quickest.

        Args:
            past_ns: From its sending, by the sender's clock, to its coming, by ours.
            now_ns: By ours.
        """
        if now_ns - self._since_ns > WINDOW_NS:
            self._since_ns, self._before_ns, self._least_ns = now_ns, self._least_ns, None
        self._least_ns = past_ns if self._least_ns is None else min(self._least_ns, past_ns)
        least_ns = (
            self._least_ns if self._before_ns is None else min(self._least_ns, self._before_ns)
        )
        return past_ns - least_ns


def _gid(about: About) -> bytes:
    """Return who sent a message; the same for everybody where rclpy does not say (before 9)."""
    gid = about.get("publisher_gid")
    return bytes(gid["data"]) if gid else b""
