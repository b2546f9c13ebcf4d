"""What a Ctrl-C and a Ctrl-D mean at the terminal of a gateway."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rosic.app.closing import AGAIN, mind_console
from rosic.config.plugins import catalogue
from rosic.core.i18n import in_language
from rosic.core.identity import Address
from rosic.core.order import RestReport
from rosic.robots.memory import MemoryRobot
from tests.gateway.place import ADA, Place

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.contracts.console import Console
    from rosic.core.order import Stop


class LongToRest(MemoryRobot):
    """Nobody measures it at rest before half a minute is over."""

    async def stop(self, stop: Stop) -> RestReport:
        self.gate.apply_stop(stop)
        await self._clock.sleep(30.0)
        return RestReport(stop.robot, confirmed=False, seconds=30.0)


class LongPlace(Place):
    kind = LongToRest


class Typed:
    """A console whose keys a test presses."""

    def __init__(self, account: str = ADA) -> None:
        self.interrupted, self.ended = asyncio.Event(), asyncio.Event()
        self.shown: list[str] = []
        self.pressed = 0
        self.locale = ""
        self.address = Address("memory", account)

    @property
    def at_hand(self) -> bool:
        return True

    def interrupt(self) -> None:
        self.pressed += 1
        self.interrupted.set()

    def take_interrupts(self) -> int:
        self.interrupted.clear()
        return self.pressed

    def show(self, text: str) -> None:
        self.shown.append(text)


@asynccontextmanager
async def _minded(
    console: Console, place: Place, others: tuple[str, ...]
) -> AsyncIterator[asyncio.Event]:
    left = asyncio.Event()
    watching = asyncio.create_task(mind_console(console, place.gateway, left.set, others))
    await place.quiet()
    try:
        yield left
    finally:
        watching.cancel()
        await asyncio.gather(watching, return_exceptions=True)


async def test_the_first_one_stops_everything_and_the_second_one_ends() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = 10_000.0
        await place.say("omni move 1 m")
        console = Typed()
        async with _minded(console, place, ("telegram",)) as left:
            console.interrupt()
            await place.quiet()
            assert all(robot.gate.latched for robot in place.gateway.robots.values())
            assert console.shown[0].startswith("STOP sent to omni")
            assert console.shown[1].startswith("STOP: omni at rest")
            assert console.shown[-1] == AGAIN
            assert not left.is_set()
            console.interrupt()
            await place.quiet()
            assert left.is_set()


async def test_the_second_one_is_heard_while_robots_come_to_rest() -> None:
    async with LongPlace().open() as place:
        console = Typed()
        async with _minded(console, place, ("telegram",)) as left:
            console.interrupt()
            await place.quiet()
            assert len(console.shown) == 1, "the stop is given, and nothing is measured yet"
            console.interrupt()
            await place.quiet()
            assert left.is_set()
        assert all(robot.gate.latched for robot in place.gateway.robots.values())
        await place.clock.advance(31)


async def test_the_end_of_the_input_is_heard_while_robots_come_to_rest() -> None:
    async with LongPlace().open() as place:
        console = Typed()
        async with _minded(console, place, ()) as left:
            console.interrupt()
            await place.quiet()
            console.ended.set()
            await place.quiet()
            assert left.is_set()
        await place.clock.advance(31)


async def test_what_is_measured_is_shown_when_it_is() -> None:
    async with LongPlace().open() as place:
        console = Typed()
        async with _minded(console, place, ()) as left:
            console.interrupt()
            await place.clock.advance(31)
            assert "omni has not confirmed the stop" in console.shown[1]
            assert console.shown[-1] == AGAIN
            assert not left.is_set()


async def test_whoever_presses_it_has_stopped_them() -> None:
    async with Place().open() as place:
        console = Typed(ADA)
        async with _minded(console, place, ()):
            console.interrupt()
            await place.quiet()
        assert "stopped by you" in await place.say("status omni")


async def test_of_somebody_unknown_at_the_terminal_it_is_the_operator_who_stopped_them() -> None:
    async with Place().open() as place:
        console = Typed("nobody")
        async with _minded(console, place, ()):
            console.interrupt()
            await place.quiet()
        assert "stopped by the operator" in await place.say("status omni")


async def test_whoever_reads_german_there_reads_all_of_it_in_german() -> None:
    async with Place().open() as place:
        console = Typed(ADA)
        console.locale = "de_AT"
        async with _minded(console, place, ("lab bot", "farm bot")):
            console.interrupt()
            await place.quiet()
            console.ended.set()
            await place.quiet()
        given, measured, again, unheard = console.shown
        assert given == "STOP geschickt an omni, kuka1, cf1, cf2."
        assert "omni steht still (" in measured
        assert again == in_language(AGAIN, catalogue("de"))
        assert again.startswith("Noch einmal Strg-C beendet ROSIC.")
        assert "ROSIC läuft weiter für lab bot und farm bot." in unheard


async def test_what_somebody_chose_counts_more_than_what_the_terminal_is_set_to() -> None:
    async with Place().open() as place:
        await place.say("/language en")
        console = Typed(ADA)
        console.locale = "de_AT"
        async with _minded(console, place, ()):
            console.interrupt()
            await place.quiet()
        assert console.shown[-1] == AGAIN


async def test_something_typed_in_between_makes_it_the_first_again() -> None:
    async with Place().open() as place:
        console = Typed()
        async with _minded(console, place, ()) as left:
            console.interrupt()
            await place.quiet()
            console.pressed = 0  # a line was typed
            console.interrupt()
            await place.quiet()
            assert not left.is_set()
            assert console.shown.count(AGAIN) == 2


async def test_the_end_of_the_only_messenger_leaves() -> None:
    async with Place().open() as place:
        console = Typed()
        async with _minded(console, place, ()) as left:
            console.ended.set()
            await place.quiet()
            assert left.is_set()


async def test_where_others_go_on_it_says_that_nothing_typed_is_heard() -> None:
    async with Place().open() as place:
        console = Typed()
        async with _minded(console, place, ("lab bot",)) as left:
            console.ended.set()
            await place.quiet()
            assert not left.is_set()
            assert console.shown[0].startswith("Nothing that is typed here is heard any more, stop")
            assert "goes on for lab bot" in console.shown[0]
            console.interrupt()
            await place.quiet()
            assert all(robot.gate.latched for robot in place.gateway.robots.values())
            console.interrupt()
            await place.quiet()
            assert left.is_set()
