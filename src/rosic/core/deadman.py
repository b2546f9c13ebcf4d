"""When continuous motion has to end for good (I6): a break on our side, or on the robot's.

Asked with every message that keeps a robot moving, and before it: what has been broken once stays
broken, so nothing that came to rest by itself goes on by itself.
"""

from __future__ import annotations

import enum
from typing import Final, NamedTuple

from rosic.core.time_units import SECOND_NS

INTERRUPTED: Final = "interrupted"
"""The code of an outcome whose motion the robot's side ended, or was too silent to go on with."""
STOOD_STILL: Final = "stood-still"
"""The code of one that ended because ROSIC itself stood still: nothing begins it again."""
BROKEN_OFF: Final = frozenset({INTERRUPTED, STOOD_STILL})


class BreakCause(enum.Enum):
    """What broke a motion off."""

    LATE = "late"
    """Our own sending was late: ROSIC, or the whole machine, stood still."""
    SILENT = "silent"
    """The robot's side was not heard within its deadline."""
    UNMEASURED = "unmeasured"
    """It was heard, but not what shows whether it rests."""
    GONE = "gone"
    """Nobody takes our messages any more."""
    REBORN = "reborn"
    """Who took our messages, or showed whether it rests, has begun anew and knows of nothing."""
    NAMELESS = "nameless"
    """Somebody new takes our messages, and who was not known in time: maybe the same, anew."""
    UNSERVED = "unserved"
    """Nobody offers any more what was to carry it out."""
    UNREPORTED = "unreported"
    """Who carries it out had told of it again and again, and tells no more."""
    RESTED = "rested"
    """The robot came to rest by itself, though it was to move."""


class MotionBreak(NamedTuple):
    """A motion is over before its time.

    Attributes:
        cause: Why.
        seconds: How long we, or the robot's side, were silent, or it has rested.
    """

    cause: BreakCause
    seconds: float

    @property
    def code(self) -> str:
        """Return what the outcome is marked with."""
        return STOOD_STILL if self.cause is BreakCause.LATE else INTERRUPTED


class DeadMan:
    """Follows one motion that is kept up by sending, from its first message.

    Attributes:
        last_ns: When it was last asked and nothing was wrong.
    """

    __slots__ = ("_broken", "_heard_within_s", "_rested_ns", "_watchdog_s", "last_ns")

    def __init__(self, now_ns: int, *, watchdog_s: float, heard_within_s: float) -> None:
        """Begin.

        Args:
            now_ns: The monotonic clock, one that runs on in suspend.
            watchdog_s: After so long without a message the robot comes to rest by itself.
            heard_within_s: The deadline of the robot's side.
        """
        self.last_ns = now_ns
        self._watchdog_s = watchdog_s
        self._heard_within_s = heard_within_s
        self._broken: MotionBreak | None = None
        self._rested_ns: int | None = None

    def look(
        self,
        now_ns: int,
        age_s: float | None,
        *,
        heard: bool = False,
        there: bool = True,
        another: BreakCause | None = None,
        rests: bool = False,
    ) -> MotionBreak | None:
        """Return why the next message must not be sent; None: it may, now.

        Args:
            now_ns: The monotonic clock.
            age_s: Since the robot's side was heard, or what shows its rest; None where it cannot be
                heard at all.
            heard: It was heard of otherwise meanwhile.
            there: Whether anybody takes our messages.
            another: `BreakCause.REBORN` when the robot's side has begun anew since the motion
            began,
                `BreakCause.NAMELESS` when it may have.
            rests: It has moved, and is measured at rest.
        """
        if self._broken is None:
            self._broken = self._look(now_ns, age_s, there=there, rests=rests)
            if self._broken is None and another is not None:
                self._broken = MotionBreak(another, (now_ns - self.last_ns) / SECOND_NS)
            if self._broken is not None and heard and self._broken.cause is BreakCause.SILENT:
                self._broken = self._broken._replace(cause=BreakCause.UNMEASURED)
        if self._broken is None:
            self.last_ns = now_ns
        return self._broken

    def late(self, now_ns: int) -> bool:
        """Tell whether the last look is too long ago for a message to follow from it."""
        return now_ns - self.last_ns > self._watchdog_s * SECOND_NS

    def _look(
        self, now_ns: int, age_s: float | None, *, there: bool, rests: bool
    ) -> MotionBreak | None:
        gap_s = (now_ns - self.last_ns) / SECOND_NS
        if gap_s > self._watchdog_s:
            return MotionBreak(BreakCause.LATE, gap_s)
        if age_s is not None and age_s > self._heard_within_s:
            return MotionBreak(BreakCause.SILENT, age_s)
        if not there:
            return MotionBreak(BreakCause.GONE, gap_s)
        if not rests:
            self._rested_ns = None
            return None
        if self._rested_ns is None:
            self._rested_ns = now_ns
        rested_s = (now_ns - self._rested_ns) / SECOND_NS
        return MotionBreak(BreakCause.RESTED, rested_s) if rested_s > self._heard_within_s else None
