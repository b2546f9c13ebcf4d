"""An ending is not lost while ROSIC lives, and what waits to be said is bounded."""

from __future__ import annotations

import gc
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.order import OrderStage, StageReport
from rosic.gateway.order_execution import RunningOrder
from rosic.gateway.order_status import OrderMessage
from rosic.robots.memory import DONE, MemoryRobot
from tests.gateway.place import Place, edited, line_by_line

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.adapter import RobotFactory
    from rosic.contracts.robot import Tell
    from rosic.core.message import Outbound
    from rosic.core.order import Order, Outcome
    from rosic.messengers.memory import MemoryMessenger
    from rosic.testing.clock import ManualClock

STEPS = 5_000
BOUND = 600


class Talkative(MemoryRobot):
    """Works for ten seconds and has news all the time."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        self.gate.pass_order(order, self._clock.monotonic_ns(), self._clock.wall_ns())
        self.acted.append(order.n)
        for step in range(STEPS):
            tell(StageReport(OrderStage.RUNNING, None, f"step {step}"))
        await self._clock.sleep(10.0)
        return DONE


class LateWords(MemoryRobot):
    """Its side's last words come after the end, as feedback and a result overtake each other."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        outcome = await super().execute(order, tell)
        tell(StageReport(OrderStage.RUNNING, 0.4))
        self.tell = tell
        return outcome


def talkative(
    chat: Callable[[ManualClock], MemoryMessenger] = edited, kind: RobotFactory = Talkative
) -> Place:
    place = Place(chat=chat)
    parts = place.gateway._parts
    place.gateway._parts = replace(parts, robot_factory=lambda _kind: kind)
    return place


@pytest.mark.parametrize("chat", [edited, line_by_line])
async def test_nothing_is_told_of_an_order_after_its_end(
    chat: Callable[[ManualClock], MemoryMessenger],
) -> None:
    async with talkative(chat, LateWords).open() as place:
        assert "done" in await place.say("omni move 1 m")
        robot, before = place.robot("omni"), len(place.chat.told)
        assert isinstance(robot, LateWords)
        for report in (StageReport(OrderStage.RECEIVED), StageReport(OrderStage.RUNNING, 0.6)):
            robot.tell(report)
        await place.clock.advance(60.0)
        assert [told.outbound.text for told in list(place.chat.told)[before:]] == []


async def test_an_ending_outlives_a_messenger_that_is_away_for_long() -> None:
    async with talkative().open() as place:
        await place.say("omni move 1 m")
        place.chat.down = True
        await place.clock.advance(600.0)
        place.chat.down = False
        await place.clock.advance(600.0)
        assert any("done" in told.outbound.text for told in place.chat.told)


async def test_a_fault_of_the_messenger_that_nobody_foresaw_does_not_silence_a_chat() -> None:
    async with Place().open() as place:
        edit = place.chat.edit

        async def fail(_message: str, _outbound: Outbound) -> None:
            place.chat.edit = edit  # type: ignore[method-assign]
            raise ZeroDivisionError

        place.chat.edit = fail  # type: ignore[assignment,method-assign]
        await place.say("omni move 1 m")
        await place.clock.advance(60.0)
        assert any("done" in told.outbound.text for told in place.chat.told), "never told"
        told = await place.say("omni wave")
        assert "done" in told, "this chat is never answered again"


async def test_what_a_robot_reports_is_bounded_when_it_cannot_be_said() -> None:
    async with talkative(line_by_line).open() as place:
        place.chat.down = True
        await place.say("omni move 1 m")
        await place.clock.advance(9.0)
        place.chat.down = False
        before = len(place.chat.told)
        await place.clock.advance(600.0)
        assert len(place.chat.told) - before < BOUND


async def test_a_life_that_is_over_lies_nowhere_until_the_next_tick() -> None:
    """Orders that waited their turn had progress to show; once told they were kept for 2 s."""
    async with Place().open() as place:
        gc.collect()
        before = alive(OrderMessage)
        for _ in range(20):
            told = await place.say("omni move 1 m\nomni move 1 m\nomni move 1 m")
            assert "done" in told
        gc.collect()
        assert alive(OrderMessage) - before < 5, "told, and still kept"


async def test_whoever_falls_silent_keeps_nothing_of_the_last_order() -> None:
    """The tasks that wait for more named it still: a few kilobytes for each chat and robot."""
    async with Place().open() as place:
        gc.collect()
        before = alive(OrderMessage), alive(RunningOrder)
        for _ in range(2):
            assert "done" in await place.say("omni move 1 m")
        assert (alive(OrderMessage), alive(RunningOrder)) == before


def alive(kind: type) -> int:
    return sum(isinstance(found, kind) for found in gc.get_objects())
