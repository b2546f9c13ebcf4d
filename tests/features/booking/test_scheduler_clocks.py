"""Whatever the clocks do: each thing is told once, and what is told is true when it is told."""

from __future__ import annotations

import asyncio
from collections import Counter
from typing import TYPE_CHECKING

from hypothesis import example, given, settings
from hypothesis import strategies as st

from rosic.messengers.memory import MemoryMessenger
from rosic.organiser.calendar_messages import length
from tests.features.booking.booking_handlers import ANN, Lab

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.message import Outbound

STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("wait"), st.integers(1, 2400)),
        st.tuples(st.just("jump"), st.integers(-5400, 5400)),
        st.tuples(st.just("drive"), st.just(0)),
        st.tuples(st.just("rest"), st.just(0)),
    ),
    max_size=12,
)


class Stamped(MemoryMessenger):
    """Notes what the wall clock showed when something was told."""

    def __init__(self, clock: Clock) -> None:
        super().__init__(clock=clock)
        self.at: list[tuple[int, str]] = []

    async def send(self, outbound: Outbound) -> str:
        self.at.append((self._clock.wall_ns(), outbound.text))
        return await super().send(outbound)


class StampedLab(Lab):
    def messenger(self) -> MemoryMessenger:
        self.stamped = Stamped(self.clock)
        return self.stamped

    async def told_all(self) -> None:
        """What happens in the very last moment is told in the next."""
        handed = -1
        while handed != len(self.handed):
            handed = len(self.handed)
            await self.told(1)


@settings(max_examples=150, deadline=None)
@given(steps=STEPS)
@example(steps=[("wait", 5377 - 1), ("drive", 0), ("wait", 2)])  # its end is the very last moment
@example(steps=[("wait", 2400), ("jump", 3000), ("jump", -3000), ("wait", 2400)])
@example(steps=[("jump", 3300), ("wait", 100), ("jump", -3600), ("wait", 2400), ("wait", 2400)])
def test_each_is_told_once_and_is_true(steps: list[tuple[str, int]]) -> None:
    asyncio.run(_live(steps))


async def _live(steps: list[tuple[str, int]]) -> None:
    lab = StampedLab()
    async with lab.open():
        slot = await lab.book(ANN, "kuka1 10:30 1h")
        driving = False
        for what, seconds in steps:
            if what == "jump":
                lab.clock.jump_wall(seconds)
            elif what == "drive" and lab.leases["kuka1"].active == 0:
                lab.begin(ANN)
                driving = True
            elif what == "rest":
                lab.end()
            await lab.told(seconds if what == "wait" else 0)
        await lab.told(21)
        await lab.told_all()
        told = lab.stamped.at
        kinds = Counter(text.split()[0] + ("ends in" in text) * " ends" for _, text in told)
        assert kinds["It"] <= 1
        assert kinds["Your ends"] <= 2
        assert kinds["Your"] == len(lab.handed) <= 1
        for at_ns, text in told:
            left_s = -(-(slot.end_ns - at_ns) // 10**9)
            if text.startswith("It is your time"):
                assert slot.covers(at_ns)
            elif "ends in" in text:
                said = f"Your time with KUKA iiwa ends in {length(left_s)}, at 11:30."
                assert (text, slot.covers(at_ns)) == (said, True)
            else:
                assert driving
                assert text == "Your time with KUKA iiwa is over. It is at rest."
