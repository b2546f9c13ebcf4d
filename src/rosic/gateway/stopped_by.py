"""Who stopped a robot, and when, as the next run reads it: what people are told, not what holds.

The stop itself is in the latch, which has no room for people and needs no database. This is noted
after it, so that a run that dies at once may forget whose stop it was, and never the stop.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.records import Fact

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.robot.profile import RobotId
    from rosic.core.stop_registry import StopRegistry

KIND: Final = "stopped-by"
STOPPERS_AT_MOST: Final = 16
"""As many are kept of one stop: enough to name them, and to know that it was not one alone."""

log = logging.getLogger("rosic.pipeline")


class StoppedBy(msgspec.Struct, frozen=True):
    """The body of the fact; its key is the robot.

    Attributes:
        generation: Of that stop; a later one is somebody else's.
        at_ns: Wall clock.
        own: They stopped an order of their own by it.
        stoppers: Everybody who has stopped it since it was last free, with when they first did.
            Versions before this was kept leave it empty: then it is not known who else did.
    """

    generation: int
    by: PrincipalId
    at_ns: int
    own: bool = False
    stoppers: tuple[tuple[PrincipalId, int], ...] = ()


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(StoppedBy).decode


def stopped_by(robot: RobotId, stops: StopRegistry) -> Fact:
    """Return what is to be noted about the last stop of a robot."""
    entry = stops[robot]
    stoppers = tuple(entry.stoppers.items())[:STOPPERS_AT_MOST]
    body = _encode(StoppedBy(entry.generation, entry.by, entry.since_ns, bool(entry.own), stoppers))
    return Fact(kind=KIND, key=robot, body=body)


def restore(stops: StopRegistry, facts: Iterable[Fact]) -> None:
    """Say whose stop each robot is under, where that is known."""
    for fact in facts:
        entry = stops.get(fact.key)
        if entry is None or not fact.body:
            continue
        try:
            last = _decode(fact.body)
        except msgspec.MsgspecError:
            log.warning("it cannot be read who stopped a robot")
            continue
        if entry.latched and last.generation == entry.generation:
            entry.by, entry.since_ns = last.by, last.at_ns
            entry.own = last.by if last.own else ""
            entry.stoppers = dict(last.stoppers) or {"": 0, last.by: last.at_ns}
