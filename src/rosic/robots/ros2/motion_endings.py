"""What is said of a motion at its end, or when it is broken off: what was measured (I7)."""

from __future__ import annotations

import logging
from math import hypot
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.i18n import joined, said
from rosic.core.time_units import SECOND_NS
from rosic.core.units import measured
from rosic.errors import RobotUnreachable, StillMoves

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.stopping import RestResult
    from rosic.robots.ros2.telemetry import MeasuredPose, Measurements


# ---- odometry distance ----

# How far a robot has gone by its own odometry, as far as that can be told.

AT_MOST: Final = 2.0
"""So many times faster than it is told to be, and than it says that it is, nothing drives."""
SLACK_S: Final = 0.1
SLACK_M: Final = 0.05


class OdometryDistance:
    """Added up from look to look.

    Attributes:
        jumped: Its odometry began anew, or went from one place to another faster than it drives: no
            way that was driven.
    """

    def __init__(self, measured: Measurements, told_m_s: float) -> None:
        """Begin where it is now.

        Args:
            measured: Of the robot.
            told_m_s: How fast it is told to be.
        """
        self.jumped = False
        self._measured = measured
        self._told_m_s = told_m_s
        self._at = measured.place()
        self._metres = None if self._at is None else 0.0
        self._meant_m = 0.0

    @property
    def metres(self) -> float | None:
        """How far, if that can be told.

        None while the robot has not said where it is, once its odometry has jumped, and as long as
        it says that it moves and its place never changes: nobody fills that in.
        """
        fixed = self._metres == 0.0 and self._meant_m > SLACK_M
        return None if fixed else self._metres

    def look(self) -> None:
        """Take in where it is now."""
        now, before = self._measured.place(), self._at
        if now is None or self.jumped:
            return
        past_m = 0.0 if before is None else hypot(now.x_m - before.x_m, now.y_m - before.y_m)
        self.jumped = before is not None and self._jumps(past_m, before, now)
        self._metres = None if self.jumped else (self._metres or 0.0) + past_m
        if before is not None:
            self._meant_m += now.speed_m_s * (now.at_ns - before.at_ns) / SECOND_NS
        self._at = now

    def _jumps(self, past_m: float, before: MeasuredPose, now: MeasuredPose) -> bool:
        speed_m_s = max(self._told_m_s, before.speed_m_s, now.speed_m_s)
        past_s = (now.at_ns - before.at_ns) / SECOND_NS + SLACK_S
        return now.restarts != before.restarts or past_m > AT_MOST * speed_m_s * past_s + SLACK_M


def told_m_s(values: Mapping[str, object]) -> float:
    """Return how fast a message tells a robot to be, at most; of what kind it may ever be."""
    numbers = {
        field: abs(value) for field, value in values.items() if isinstance(value, (int, float))
    }
    linear = [number for field, number in numbers.items() if "linear" in field.split(".")]
    return float(sum(linear or numbers.values()))


# ---- motion endings ----

_log = logging.getLogger(__name__)

LOOK_EVERY_S: Final = 0.2


def moved(metres: float | None) -> str:
    """Return how far it went, as far as anybody knows; may be empty."""
    if metres is None:
        return ""
    return said("moved {way} by its odometry", way=measured(f"{metres:.2f} m", metres, "m"))


class NotAtRest(NamedTuple):
    """What was measured instead of rest.

    Attributes:
        words: In a sentence's place; empty: nothing was.
        code: The outcome's, so that whoever was told is told of its rest later.
    """

    words: str = ""
    code: str = ""


async def after_the_end(call: BindingCall) -> NotAtRest:
    """Wait until it rests that says that it has ended, at most `rest_timeout_s`; then say so.

    Returns:
        No doubt where it rests, or keeps its place, and where nothing shows that, or a stop has
        come.
    """
    side, sees = call.side, call.side.measured
    since_ns = side.clock.monotonic_ns()
    until_ns = since_ns + int(side.rest_timeout_s * SECOND_NS)
    if not sees.measures_rest or not call.order.skill.actuates:
        return NotAtRest()
    while call.allowed():
        if sees.at_rest(since_ns) or sees.holds(since_ns):
            return NotAtRest()
        if side.clock.monotonic_ns() > until_ns:
            moves = sees.at_rest(max(since_ns, sees.stale_ns())) is False
            _log.warning(
                "%s: it says that order %d has ended, and was not measured at rest",
                call.order.robot,
                call.order.n,
            )
            if moves:
                return NotAtRest(said("it still moves"), StillMoves.code)
            return NotAtRest(said("its rest could not be measured"))
        await sees.next_word(LOOK_EVERY_S)
    return NotAtRest()


def in_doubt(shown: str, what: str, resting: RestResult) -> RobotUnreachable:
    """Return what is known of a robot that was to come to rest and was not seen to.

    Args:
        shown: How people call it.
        what: What became of its motion before; may be empty.
        resting: What came of bringing it to rest.
    """
    if resting.moves:
        doubt = said("{shown} was sent zero and told to stop, and still moves.", shown=shown)
    else:
        doubt = said(
            "{shown} was sent zero and told to stop; whether it rests could not be measured.",
            shown=shown,
        )
    said_of_it = joined(". ", (joined(": ", (shown, what)), doubt)) if what else doubt
    return StillMoves(said_of_it) if resting.moves else RobotUnreachable(said_of_it)
