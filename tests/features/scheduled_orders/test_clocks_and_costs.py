"""Wall clocks that change, and what waiting costs."""

from __future__ import annotations

import gc
import sys
from collections import Counter
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.features.scheduled_orders.schedule import OrderSchedule, fact_of
from tests.features.scheduled_orders.planning import BERLIN, lab, next_time, plan, quick, schedule

if TYPE_CHECKING:
    from types import FrameType

    from tests.gateway.place import Place

# ---- clocks that change ----

MARCH_NS = 1_806_145_200_000_000_000
"""27 March 2027, 11:00 UTC: the clocks in Berlin go forward in the night that follows."""
OCTOBER_NS = 1_824_894_000_000_000_000
"""30 October 2027, 11:00 UTC: they go back in the night that follows."""


async def test_a_time_that_the_clocks_skip_is_not_planned() -> None:
    async with lab(now_ns=MARCH_NS).open() as here:
        told = await here.say("/at tomorrow 2:30 omni wave")
        assert "the clocks in Europe/Berlin go forward, and there is no 02:30" in told
        assert "Nothing was planned." in told


async def test_a_time_that_comes_twice_is_the_first_and_that_is_said() -> None:
    async with lab(now_ns=OCTOBER_NS).open() as here:
        told = await here.say("/at tomorrow 2:30 omni wave")
        assert "02:30 comes twice. This is the first one." in told


async def test_eight_in_the_morning_is_eight_whatever_the_clocks_do() -> None:
    async with lab(now_ns=MARCH_NS).open() as here:
        quick(here)
        await plan(here, "/every day 8:00 omni wave")
        zone = here.gateway.rooms.organiser.calendar.zone("")
        assert zone.name == BERLIN
        seen = []
        for _ in range(3):
            [at_ns] = schedule(here).next_ns.values()
            assert at_ns is not None
            seen.append(zone.local(at_ns).time_text())
            await next_time(here)
        assert (seen, here.acted()) == (["08:00"] * 3, 3)


# ---- how much it costs (I15) ----


class Counting:
    """Counts the calls of Python while it is in force."""

    def __init__(self) -> None:
        self.calls: Counter[str] = Counter()

    def __call__(self, frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            self.calls[frame.f_code.co_qualname if sys.version_info >= (3, 11) else ""] += 1


async def _look(here: Place, waiting: int) -> int:
    kept = schedule(here)
    [(fact, text)] = [(kept.orders["1"], kept.texts["1"])]
    for number in range(2, waiting + 2):
        when = replace(fact.when, at_ns=fact.when.at_ns + number)
        kept.apply(fact_of(str(number), replace(fact, when=when), text))
    counting = Counting()
    gc.disable()  # whoever hears of a collection is no part of the look
    sys.setprofile(counting)
    try:
        assert kept._due() == []
    finally:
        sys.setprofile(None)
        gc.enable()
    return sum(counting.calls.values())


async def test_a_look_for_what_is_due_costs_the_same_however_many_wait() -> None:
    found = []
    for waiting in (5, 1_500):
        async with lab().open() as here:
            await plan(here, "/at 15:00 omni wave")
            found.append(await _look(here, waiting))
    assert found[0] == found[1]


async def test_what_was_planned_and_taken_back_leaves_nothing_that_grows() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni wave")
        kept: OrderSchedule = schedule(here)
        order, text = kept.orders["1"], kept.texts["1"]
        for number in range(2, 1_000):
            kept.apply(fact_of(str(number), order, text))
            kept.apply(kept.end(str(number)))
        assert len(kept._times) < 100
        assert len(kept.orders) == 1
