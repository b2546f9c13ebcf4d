"""Who does which errand about times."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.pipeline.cancel import BOOKING
from rosic.pipeline.times.booking import Booking
from rosic.pipeline.times.cancelling import Cancelling
from rosic.pipeline.times.planning import Planning
from rosic.pipeline.times.queueing import Queueing
from rosic.pipeline.times.showing import Showing
from rosic.pipeline.times.wishing import Wishing

if TYPE_CHECKING:
    from rosic.pipeline.office import Office
    from rosic.pipeline.times.keeper import Keeper
    from rosic.pipeline.times.parts import Times


def employ_clerks(office: Office, times: Times, keeper: Keeper) -> None:
    """Let ``book``, ``slots``, ``cancel booking``, ``wait``, ``wish`` and ``plan`` be done."""
    office.employ("book", Booking(times).book)
    office.employ("slots", Showing(times).show)
    office.employ(BOOKING, Cancelling(times).cancel)
    office.employ("wait", Queueing(times, keeper).wait)
    office.employ("wish", Wishing(times).wish)
    office.employ("plan", Planning(times).plan)
