"""I5 and I10 where stops meet resumes, revocations, restarts and the end of the gateway."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.control_client import ask_gateway
from rosic.app.admin.control_socket import ControlServer
from rosic.app.admin.dispatch import AdminDispatcher
from rosic.core.message import Chat, ChatKind, MessageValidity
from rosic.core.order import RestReport, Stop
from rosic.core.order_gate import OrderGate
from rosic.core.records import Resumed
from rosic.errors import RosicError, StoreFault
from rosic.robots.memory import MemoryRobot
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import MemoryLatch
from tests.gateway.place import BO, VI, Place, SlowStore
from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.core.message import Outbound

STOPS = 3_000


class WritesNoStop(MemoryLatch):
    """Its disk is gone when a stop is to be written."""

    async def write(self, robot: str, generation: int, *, latched: bool) -> None:
        if latched:
            raise StoreFault("no disk")
        await super().write(robot, generation, latched=latched)


class WritesNoResume(MemoryLatch):
    """Its disk is gone when a stop is to be undone."""

    async def write(self, robot: str, generation: int, *, latched: bool) -> None:
        if not latched:
            raise StoreFault("no disk")
        await super().write(robot, generation, latched=latched)


class SlowLatch(MemoryLatch):
    """Its disk takes its time, until ``ready``."""

    def __init__(self) -> None:
        super().__init__()
        self.ready = asyncio.Event()

    async def write(self, robot: str, generation: int, *, latched: bool) -> None:
        await self.ready.wait()
        await super().write(robot, generation, latched=latched)


class HardToStop(MemoryRobot):
    """Comes to rest one second after it was told to."""

    rested = 0

    async def stop(self, stop: Stop) -> RestReport:
        self.gate.apply_stop(stop)
        await self._clock.sleep(1.0)
        self.rested += 1
        return await super().stop(stop)


def hard_to_stop(place: Place) -> Place:
    parts = place.gateway._parts
    place.gateway._parts = replace(parts, robot_factory=lambda _kind: HardToStop)
    return place


# ---- resume ----


async def test_a_resume_of_two_robots_does_not_undo_a_stop_that_came_while_it_was_written() -> None:
    store = SlowStore(Resumed)
    async with Place(store).open() as place:
        await place.say("stop omni")
        await place.say("stop kuka1")
        await place.clock.advance(1.0)
        place.chat.say("resume omni kuka1")
        await place.clock.advance(0.5)
        await place.say("stop kuka1", account=BO, chat="2")
        store.ready.set()
        await place.quiet()
        assert not place.robot("omni").gate.latched
        assert place.robot("kuka1").gate.latched, "Bo stopped it after Ada had asked to resume it"


async def test_a_resume_does_not_undo_a_stop_that_came_after_it_was_sent() -> None:
    async with Place().open() as place:
        await place.say("stop omni")
        await place.clock.advance(5.0)
        sent_ns = place.clock.wall_ns()
        await place.clock.advance(5.0)
        await place.say("stop omni")
        await place.clock.advance(5.0)
        await place.say("resume omni", account=BO, chat="2", sent_ns=sent_ns)
        assert place.robot("omni").gate.latched


async def test_a_resume_that_found_nothing_to_undo_undoes_nothing_when_it_comes_again() -> None:
    async with Place().open() as place:
        message = place.chat.say("resume omni")
        await place.quiet()
        await place.clock.advance(2.0)
        await place.say("stop omni")
        await place.clock.advance(2.0)
        place.chat.deliver(replace(message, received_ns=place.clock.wall_ns()))
        await place.quiet()
        assert place.robot("omni").gate.latched


async def test_a_right_that_ends_while_a_resume_is_written_ends_the_resume() -> None:
    store = SlowStore(Resumed)
    async with Place(store).open() as place:
        await place.say("stop omni")
        await place.clock.advance(1.0)
        place.chat.say("resume omni", account=BO, chat="2")
        await place.quiet()
        await place.revoke("Bo")
        store.ready.set()
        await place.quiet()
        assert place.robot("omni").gate.latched


async def test_a_robot_that_moves_again_is_not_said_to_stay_stopped() -> None:
    async with Place(latch=WritesNoResume()).open() as place:
        await place.say("stop omni")
        told = await place.say("resume omni")
        await place.say("omni move 1 m")
        assert place.robot("omni").gate.latched or "stays stopped:" not in told, told


def test_the_same_stop_again_changes_nothing_after_a_resume() -> None:
    gate = OrderGate.new("r")
    gate.apply_stop(Stop("r", 1))
    gate.resume(1)
    gate.apply_stop(Stop("r", 1))
    assert not gate.latched, "the registry says that it may move: nobody could resume it any more"


async def test_a_resume_that_is_cut_off_takes_no_stop_from_the_disk() -> None:
    latch = SlowLatch()
    async with Place(latch=latch).open() as place:
        await place.say("stop kuka1", account=BO, chat="2")
        await place.say("stop omni")
        await place.clock.advance(1.0)
        place.chat.say("resume omni")
        await place.clock.advance(1.0)
        await place.gateway._fall_deaf()
        latch.ready.set()
        await place.quiet()
        assert latch.read().get("kuka1") == (1, True)


# ---- restart ----


async def test_a_stop_that_only_the_record_knows_survives_a_restart() -> None:
    store = MemoryStore()
    async with Place(store, WritesNoStop()).open() as place:
        await place.say("stop omni")
    async with Place(store, MemoryLatch()).open() as place:
        assert place.robot("omni").gate.latched
        await place.say("resume omni")
        assert not place.robot("omni").gate.latched


async def test_an_anonymous_stop_is_obeyed_after_a_restart_too() -> None:
    store, latch = MemoryStore(), MemoryLatch()
    async with Place(store, latch).open() as place:
        await place.say("use omni", chat="g", kind=ChatKind.GROUP)
    async with Place(store, latch).open() as place:
        await place.say(
            "stop",
            chat="g",
            kind=ChatKind.GROUP,
            account="1087968824",
            standing=MessageValidity.ANONYMOUS,
        )
        assert place.robot("omni").gate.latched


# ---- hearing and answering ----


@pytest.mark.parametrize(
    "text",
    [
        "\n . stpo" + " " * 72 + "\u200d",
        "omni stop" + "\u200b" * 60,
        "hey omni \u2060" + "\u200b" * 60 + " stop",
        "\ufe0f🛑@omni\u200dst\u200bopﬆop@bot\t",
    ],
)
async def test_what_is_understood_as_a_stop_stops(text: str) -> None:
    async with Place().open() as place:
        told = await place.say(text)
        stopped = any(robot.gate.latched for robot in place.gateway.robots.values())
        assert stopped or told, "neither obeyed nor answered"


async def test_a_stop_is_answered_though_its_first_answer_was_deleted() -> None:
    async with hard_to_stop(Place()).open() as place:
        await place.say("stop omni")
        first = place.chat.told[-1].message
        del place.chat._shown[first]
        await place.clock.advance(30.0)
        assert "omni at rest" in place.chat.told[-1].outbound.text


async def test_answers_to_a_flood_of_stops_are_bounded() -> None:
    async def never(_outbound: Outbound) -> str:
        await asyncio.Event().wait()
        return ""

    async with Place().open() as place:
        place.chat.send = never  # type: ignore[assignment,method-assign]
        seed = place.chat._inbound(VI, Chat("memory", "3"), None, None)
        for number in range(STOPS):
            message = replace(seed, text="stop omni", message=f"flood {number}")
            await place.gateway.pipeline.receive(place.chat, message)
        waiting = tuple(place.gateway.stop_lane._tasks)
        for task in waiting:
            task.cancel()
        await asyncio.gather(*waiting, return_exceptions=True)
        assert place.robot("omni").gate.latched
        assert len(waiting) < STOPS / 2


async def test_a_stop_of_the_operator_goes_on_when_the_control_socket_closes(
    tmp_path: Path,
) -> None:
    async with hard_to_stop(Place()).open() as place:
        server = ControlServer(tmp_path, AdminDispatcher(place.gateway))
        await server.open()
        robot = place.robot("omni")
        assert isinstance(robot, HardToStop)

        async def ask() -> None:
            with suppress(RosicError):
                async for answer in ask_gateway(
                    tmp_path, AdminRequest(AdminVerb.STOP, ("omni",)), print
                ):
                    said.set()
                    assert answer.good

        said = asyncio.Event()
        asking = asyncio.create_task(ask())
        await asyncio.wait_for(said.wait(), 60 * pace())
        await server.close()
        await asyncio.wait_for(asking, 60 * pace())
        await place.clock.advance(2.0)
        assert robot.rested == 1
