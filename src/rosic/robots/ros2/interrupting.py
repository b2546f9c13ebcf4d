"""What is said of a motion that was broken off: what was measured, and nothing else (I7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.deadman import Break, Cause
from rosic.core.saying import joined, said
from rosic.errors import RobotUnreachable, StillMoves

if TYPE_CHECKING:
    from rosic.robots.ros2.rest import Resting


def over(broken: Break) -> str:
    """Return why a motion did not go on."""
    seconds = broken.seconds
    if broken.cause is Cause.LATE:
        return said("then ROSIC itself stood still for {seconds:.1f} s: ended", seconds=seconds)
    if broken.cause is Cause.SILENT:
        return said("then it was not heard for {seconds:.1f} s: ended", seconds=seconds)
    if broken.cause is Cause.UNMEASURED:
        return said("then its motion was not measured for {seconds:.1f} s: ended", seconds=seconds)
    if broken.cause is Cause.GONE:
        return said("then it was not there any more: ended")
    if broken.cause is Cause.REBORN:
        return said("then its software began anew: ended")
    return said("then it came to rest by itself: ended")


def in_doubt(shown: str, what: str, resting: Resting) -> RobotUnreachable:
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
