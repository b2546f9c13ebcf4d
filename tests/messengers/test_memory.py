"""What the memory messenger has beyond the contract, for the tests that use it."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest

from rosic.core.message import Button, Chat, Inbound, Outbound
from rosic.errors import MessengerFault
from rosic.messengers.memory import MemoryMessenger
from rosic.testing.clock import ManualClock, settle

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

CHAT = Chat("memory", "1")
STOP = Button("STOP", "stop", "n-7")
HOME = Button("Home", "kuka1 home", "n-home")


@pytest.fixture
def messenger() -> MemoryMessenger:
    return MemoryMessenger(clock=ManualClock())


@asynccontextmanager
async def running(
    messenger: MemoryMessenger, receive: Callable[[Inbound], Awaitable[None]]
) -> AsyncIterator[None]:
    run = asyncio.create_task(messenger.run(receive))
    try:
        yield
    finally:
        run.cancel()
        await asyncio.gather(run, return_exceptions=True)


async def test_what_is_told_is_waited_for(messenger: MemoryMessenger) -> None:
    async def receive(inbound: Inbound) -> None:
        message = await messenger.send(Outbound(chat=inbound.chat, text="omni: sent"))
        await messenger.edit(message, Outbound(chat=inbound.chat, text="omni: done"))

    async with running(messenger, receive):
        messenger.say("omni move 1 m")
        told = await messenger.wait_for(lambda told: told.outbound.text == "omni: done")
        assert told.edited
        assert messenger.shown(told.message).text == "omni: done"
        messenger.say("again")
        later = await messenger.wait_for(lambda told: not told.edited, after=2)
        assert later.message != told.message


async def test_waiting_is_bounded(messenger: MemoryMessenger) -> None:
    await messenger.send(Outbound(chat=CHAT, text="omni: sent"))
    with pytest.raises(TimeoutError, match="omni: sent"):
        await messenger.wait_for(lambda told: told.edited, timeout_s=0.02)


async def test_a_tap_on_a_button_that_stops_overtakes(messenger: MemoryMessenger) -> None:
    heard: list[str | None] = []
    gate = asyncio.Event()

    async def receive(inbound: Inbound) -> None:
        heard.append(inbound.nonce or inbound.text)
        await gate.wait()

    message = await messenger.send(Outbound(chat=CHAT, text="omni", buttons=((HOME, STOP),)))
    async with running(messenger, receive):
        messenger.say("omni move 1 m")
        messenger.tap(HOME, under=message)
        messenger.tap(STOP, under=message)
        await settle()
        assert heard == ["n-7", "omni move 1 m"]
        gate.set()
        await messenger.wait_until_received()
        assert heard[-1] == "n-home"


async def test_a_failure_of_the_receiver_is_seen(messenger: MemoryMessenger) -> None:
    async def receive(inbound: Inbound) -> None:
        raise LookupError(inbound.text)

    messenger.say("omni move 1 m")
    with pytest.raises(LookupError, match="omni move 1 m"):
        await messenger.run(receive)
    assert [one.text for one in messenger.unconfirmed()] == ["omni move 1 m"]


async def test_what_waits_is_bounded() -> None:
    messenger = MemoryMessenger(clock=ManualClock(), keep=3)
    for _ in range(3):
        messenger.say("hello")
    with pytest.raises(OverflowError):
        messenger.say("hello")


async def test_a_gap_makes_what_was_sent_before_backlog() -> None:
    clock = ManualClock()
    messenger = MemoryMessenger(clock=clock)
    sent_ns = clock.wall_ns()
    await clock.advance(10)
    messenger.gap()
    late = messenger.say("omni move 1 m", sent_ns=sent_ns)
    fresh = messenger.say("omni move 1 m")
    assert late.sent_ns < late.listening_since_ns
    assert fresh.sent_ns >= fresh.listening_since_ns


async def test_down_and_without_edits() -> None:
    messenger = MemoryMessenger(clock=ManualClock(), edits=False)
    outbound = Outbound(chat=CHAT, text="omni")
    message = await messenger.send(outbound)
    with pytest.raises(MessengerFault):
        await messenger.edit(message, outbound)
    messenger.down = True
    with pytest.raises(MessengerFault):
        await messenger.send(outbound)
    assert len(messenger.told) == 1
