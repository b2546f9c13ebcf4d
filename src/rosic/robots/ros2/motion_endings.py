"""What is said of a motion at its end, or when it is broken off: what was measured (I7)."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.i18n import joined, said
from rosic.core.time_units import SECOND_NS
from rosic.core.units import measured
from rosic.errors import RobotUnreachable, StillMoves

if TYPE_CHECKING:
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.stopping import RestResult

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
