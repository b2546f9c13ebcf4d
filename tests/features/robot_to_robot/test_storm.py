"""A robot shares 10,000 things a second: it is bounded, told once, and nobody else is slower."""

from __future__ import annotations

import asyncio
import time
from contextlib import suppress
from statistics import median
from typing import TYPE_CHECKING

import msgspec

from rosic.features.robot_to_robot.inbox import PACE, WAITING_AT_MOST
from rosic.testing.clock import ManualClock
from tests.features.robot_to_robot.peers import PeerRobots
from tests.gateway.place import ADA, BO, VI
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Callable

STORM_S = 2.0
A_SECOND = 10_000
PATIENCE_S = 30.0 * pace()


class RealClock(ManualClock):
    """The machine's own clock, where a test would own one."""

    def wall_ns(self) -> int:
        return time.time_ns()

    def monotonic_ns(self) -> int:
        return time.monotonic_ns()

    async def sleep(self, seconds: float) -> None:
        await asyncio.sleep(seconds)

    async def advance(self, seconds: float) -> None:
        await asyncio.sleep(seconds)


async def test_ten_thousand_a_second_are_bounded_and_the_newest_gets_through() -> None:
    async with PeerRobots().open() as here:
        robot, inbox = (
            here.robot("omni"),
            here.messaging.inboxes["omni"],
        )
        total = 0
        for _ in range(200):
            for _ in range(A_SECOND // 100):
                total += 1
                robot.speak(words(total), 0)
            await here.clock.advance(0.01)
        assert inbox.taken <= PACE.burst + PACE.per_s * 2.1
        assert inbox.taken + inbox.dropped + WAITING_AT_MOST >= total
        await here.clock.advance(1)
        assert inbox.taken + inbox.dropped == total, "each is either taken or counted"
        [shared] = here.messaging.circle.shared_state.of("omni")
        assert shared.data == str(total).encode(), "the newest gets through"
        told = [t.outbound for t in here.chat.told if "says more to the other" in t.outbound.text]
        assert sorted(outbound.chat.id for outbound in told) == [ADA, BO], "once each"
        assert all(outbound.buttons[0][0].label == "Silence omni" for outbound in told)


async def test_it_is_told_again_only_after_a_minute_in_which_it_was_calm() -> None:
    async with PeerRobots().open() as here:

        async def flood() -> int:
            for number in range(500):
                here.robot("omni").speak(words(number), 0)
            await here.clock.advance(1)
            return sum("says more to the other" in t.outbound.text for t in here.chat.told)

        assert await flood() == 2
        await here.clock.advance(30)
        assert await flood() == 2
        await here.clock.advance(61)
        assert await flood() == 4


async def test_what_an_adapter_has_dropped_already_counts_too() -> None:
    async with PeerRobots().open() as here:
        here.robot("omni").speak(words(1), 9_999)
        await here.clock.advance(1)
        assert here.messaging.inboxes["omni"].dropped == 9_999
        assert any("says more to the other" in t.outbound.text for t in here.chat.told)


def words(number: int) -> bytes:
    return b'{"kind":"share","topic":"road","data":%d}' % number


async def test_others_are_not_slower_in_a_storm(
    record_property: Callable[[str, object], None],
) -> None:
    """Orders and stops of other robots, while one shares 10,000 a second and two never end."""
    async with PeerRobots(clock=RealClock()).open() as here:
        calm = await measured(here)
        storm = asyncio.create_task(pour(here))
        echo(here)
        try:
            stormy = await measured(here)
        finally:
            storm.cancel()
            with suppress(asyncio.CancelledError):
                await storm
        figures = {
            f"{when} {what}": f"p50 {median(row) * 1e3:.2f} ms, worst {max(row) * 1e3:.2f} ms"
            for when, rows in (("calm", calm), ("storm", stormy))
            for what, row in rows.items()
        }
        record_property("latency", figures)
        assert here.messaging.inboxes["omni"].dropped > 1_000, "there was a storm"
        for what, row in stormy.items():
            assert median(row) < 0.1, figures
            assert median(row) < 10 * median(calm[what]) + 0.02, figures


async def pour(here: PeerRobots) -> None:
    """Let omni share 10,000 things a second, as far as this machine comes to it."""
    number, begun = 0, time.monotonic()
    while True:
        due = int((time.monotonic() - begun) * A_SECOND)
        for _ in range(min(due - number, 500)):
            number += 1
            here.robot("omni").speak(words(number), 0)
        await asyncio.sleep(0.005)


def echo(here: PeerRobots) -> None:
    """Let cf1 and cf2 answer each other without end."""
    for name in ("cf1", "cf2"):

        def hear(said: bytes, name: str = name) -> bool:
            heard = msgspec.json.decode(said)
            if heard["kind"] == "told":
                cause = {"re": heard["id"]} if name == "cf2" else {}  # it may only answer
                here.speaks(name, "tell", to=heard["from"], data="and you?", **cause)
            return True

        here.robot(name).hear = hear  # type: ignore[method-assign,assignment]
    here.speaks("cf1", "tell", to="cf2", data="hello")


async def measured(here: PeerRobots) -> dict[str, list[float]]:
    """Measure how long an order of another robot takes until it acts, and a stop until it holds."""
    orders: list[float] = []
    stops: list[float] = []
    gate = here.robot("kuka1").gate
    for _ in range(30):
        before, begun = here.acted("kuka1"), time.perf_counter()
        here.chat.say("kuka1 wave", account=BO, chat=BO)
        await until(lambda before=before: here.acted("kuka1") > before)  # type: ignore[misc]
        orders.append(time.perf_counter() - begun)
        await asyncio.sleep(0.01)
    for _ in range(10):
        begun = time.perf_counter()
        here.chat.say("stop kuka1", account=VI, chat=VI)
        await until(lambda: gate.latched)
        stops.append(time.perf_counter() - begun)
        here.chat.say("resume kuka1", account=BO, chat=BO)
        await until(lambda: not gate.latched)
        await asyncio.sleep(0.01)
    return {"order": orders, "stop": stops}


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(PATIENCE_S):
        while not condition():  # noqa: ASYNC110 - what is measured tells nobody
            await asyncio.sleep(0.0005)
