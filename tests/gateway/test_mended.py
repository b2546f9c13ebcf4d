"""What the first hunt's mends opened, or left open."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.control_client import ask_gateway
from rosic.app.admin.control_socket import ControlServer
from rosic.app.admin.dispatch import AdminDispatcher
from rosic.core.message import Chat
from rosic.core.records import Resumed
from rosic.errors import MessengerFault, RosicError
from rosic.stores.stop_latch import MemoryLatch
from tests.gateway.place import BO, VI, Place, SlowStore, WritingStore
from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.core.message import Outbound
    from rosic.core.records import Record

FLOOD = 1_000


class TakesATurn(WritingStore):
    """Like a disk: whoever writes gives way to others for a moment."""

    async def write(self, *records: Record) -> None:
        for _ in range(3):
            await asyncio.sleep(0)
        await super().write(*records)


class SlowLatch(MemoryLatch):
    """Its disk takes its time, until ``ready``."""

    def __init__(self) -> None:
        super().__init__()
        self.ready = asyncio.Event()

    async def write(self, robot: str, generation: int, *, latched: bool) -> None:
        await self.ready.wait()
        await super().write(robot, generation, latched=latched)


async def test_lines_of_one_message_to_a_group_wait_for_each_other() -> None:
    async with Place(TakesATurn()).open() as place:
        for name in ("cf1", "cf2"):
            place.robot(name).work_s = 0.05
        place.chat.say("swarm wave\nswarm move 1 m\nswarm wave")
        async with asyncio.timeout(60 * pace()):
            while place.acted("cf1") + place.acted("cf2") < 6:  # noqa: ASYNC110 - a robot that works tells nobody
                await asyncio.sleep(0.005)
        assert (place.acted("cf1"), place.acted("cf2")) == (3, 3)


async def test_who_has_a_busy_group_is_said_to_somebody_else() -> None:
    async with Place().open() as place:
        place.robot("cf1").work_s = 1_000.0
        await place.say("cf1 wave")
        told = await place.say("swarm wave", account=BO, chat="2")
        assert "cf1 is taken by Ada" in told, told
        told = await place.say("swarm wave", account=VI, chat="3")
        assert "needs the right" in told, told


async def test_one_persons_flood_of_stops_takes_nobody_elses_answer() -> None:
    async with Place().open() as place:
        send = place.chat.send

        async def stuck(outbound: Outbound) -> str:
            if outbound.chat.id == "3":
                await asyncio.Event().wait()
            return await send(outbound)

        place.chat.send = stuck  # type: ignore[method-assign]
        seed = place.chat._inbound(VI, Chat("memory", "3"), None, None)
        for number in range(FLOOD):
            message = replace(seed, text="stop omni", message=f"flood {number}")
            await place.gateway.pipeline.receive(place.chat, message)
        told = await place.say("stop")
        waiting = tuple(place.gateway.stop_lane._tasks)
        for task in waiting:
            task.cancel()
        await asyncio.gather(*waiting, return_exceptions=True)
        assert "omni at rest" in told


async def test_a_robot_that_was_stopped_again_is_not_said_to_be_ready() -> None:
    store = SlowStore(Resumed)
    async with Place(store).open() as place:
        await place.say("stop omni")
        await place.clock.advance(1.0)
        place.chat.say("resume omni")
        await place.clock.advance(1.0)
        await place.say("stop omni", account=BO, chat="2")
        store.ready.set()
        await place.quiet()
        assert place.robot("omni").gate.latched
        assert not any("ready again" in told.outbound.text for told in place.chat.told)


async def test_looking_at_a_stopped_robot_ends_as_looking_does() -> None:
    async with Place().open() as place:
        await place.say("stop omni")
        await place.clock.advance(1.0)
        told = await place.say("omni look")
        assert "done" in told, told


async def test_what_one_message_cannot_say_does_not_silence_a_chat() -> None:
    async with Place().open() as place:
        send = place.chat.send

        async def picky(outbound: Outbound) -> str:
            if "wave" in outbound.text:
                raise MessengerFault("this text is not taken")
            return await send(outbound)

        place.chat.send = picky  # type: ignore[method-assign]
        await place.say("omni wave")
        await place.say("omni move 1 m")
        await place.clock.advance(600.0)
        assert any("omni: move" in told.outbound.text for told in place.chat.told)


async def test_a_stop_of_the_operator_reaches_the_disk_when_the_control_socket_closes(
    tmp_path: Path,
) -> None:
    latch = SlowLatch()
    async with Place(latch=latch).open() as place:
        server = ControlServer(tmp_path, AdminDispatcher(place.gateway))
        await server.open()
        heard: list[str] = []
        both = asyncio.Event()

        async def ask() -> None:
            with suppress(RosicError):
                async for answer in ask_gateway(
                    tmp_path, AdminRequest(AdminVerb.STOP, ("omni",)), print
                ):
                    heard.append(answer.text)
                    if len(heard) > 1:
                        both.set()

        asking = asyncio.create_task(ask())
        await asyncio.wait_for(both.wait(), 60 * pace())
        await place.quiet()
        await server.close()
        await asyncio.wait_for(asking, 60 * pace())
        latch.ready.set()
        await place.quiet()
        assert latch.read().get("omni") == (1, True)


async def test_of_ones_own_container_no_id_is_said() -> None:
    async with Place().open() as place:
        assert await place.say("/data a =") == 'Your container keeps nothing called "a".'
        place.gateway.rooms.organiser.charge = lambda _caller: None  # type: ignore[method-assign, assignment]
        for number in range(64):
            assert await place.say(f"/data n{number} = {number}") == "Data stored."
        assert (await place.say("/data more = 1")).startswith("Your container keeps at most 64")
