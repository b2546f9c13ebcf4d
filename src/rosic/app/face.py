"""What a clock on the wall shows: the time of day in the place's zone."""

from __future__ import annotations

from datetime import datetime, tzinfo
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.core.order_status import Face

SECOND_NS = 1_000_000_000


def face_of(zone: tzinfo | None = None) -> Face:
    """Return a function from wall clock nanoseconds to ``14:02:07``.

    Args:
        zone: None takes the machine's own.
    """
    shown_second = -1
    shown = ""

    def face(at_ns: int) -> str:
        # Many lives step within one second: the text of that second is made once.
        nonlocal shown_second, shown
        second = at_ns // SECOND_NS
        if second != shown_second:
            shown = datetime.fromtimestamp(second, zone).astimezone(zone).strftime("%H:%M:%S")
            shown_second = second
        return shown

    return face
