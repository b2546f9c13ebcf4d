"""I17: a stop without an author is kept back by no other chat, and by no answer that failed."""

from __future__ import annotations

import asyncio
import gc
import sys
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from rosic.container.container import CHATS_AT_MOST
from rosic.core.identity import Address
from rosic.core.message import Chat, ChatKind, Inbound, MessageValidity
from rosic.core.time_units import SECOND_NS
from rosic.errors import MessengerFault
from rosic.gateway.group_people import ASKED_AGAIN_NS, AT_ONCE
from rosic.testing.clock import ManualClock
from tests.gateway.place import ADA, Place
from tests.gateway.test_stopping import unnamed_stop

if TYPE_CHECKING:
    from types import FrameType


async def test_the_admins_are_asked_for_again_where_that_failed() -> None:
    answers = iter((MessengerFault("It did not answer."), (Address("memory", ADA),)))

    async def admins(_chat: Chat) -> tuple[Address, ...]:
        answer = next(answers)
        if isinstance(answer, MessengerFault):
            raise answer
        return answer

    async with Place().open() as place:
        place.gateway._messengers[0].admins = admins  # type: ignore[attr-defined]
        await unnamed_stop(place)
        assert not place.robot("omni").gate.latched
        await unnamed_stop(place)
        assert place.robot("omni").gate.latched


async def test_questions_about_other_chats_keep_no_stop_of_nobodys_back() -> None:
    asked: list[str] = []
    waiting, told = asyncio.Event(), asyncio.Event()

    async def admins(chat: Chat) -> tuple[Address, ...]:
        asked.append(chat.id)
        if len(asked) == AT_ONCE:
            waiting.set()
        await told.wait()
        return (Address("memory", ADA),) if chat.id == "g" else ()

    async with Place().open() as place:
        place.gateway._messengers[0].admins = admins  # type: ignore[attr-defined]
        others = [
            asyncio.create_task(unnamed_stop(place, chat=f"h{number}"))
            for number in range(AT_ONCE * 4)
        ]
        await waiting.wait()
        ours = [asyncio.create_task(unnamed_stop(place)) for _ in range(2)]
        await asyncio.sleep(0)
        told.set()
        await asyncio.gather(*others, *ours)
        assert place.robot("omni").gate.latched
        assert sorted(asked) == sorted({"g", *(f"h{number}" for number in range(AT_ONCE * 4))})


async def test_a_stop_in_a_strangers_channel_costs_the_same_among_many_people() -> None:
    """Whom the chat is known to hold is a look-up: nobody who is elsewhere is looked at."""
    few, many = [await instructions_of_a_stop(people) for people in (100, 5_000)]
    assert many <= 1.2 * few, (few, many)


async def instructions_of_a_stop(people: int) -> int:
    """Return how many instructions of Python a stop of nobody's takes where it stops nothing.

    Args:
        people: So many are known in groups of their own, and as often somebody was recognised.
    """
    async with Place().open() as place:
        rooms = place.gateway.rooms
        now_ns = place.clock.wall_ns()
        said = Inbound(
            sender=Address("memory", ADA),
            chat=Chat("memory", "x", ChatKind.CHANNEL),
            message="m1",
            text="stop",
            sent_ns=now_ns,
            received_ns=now_ns,
        )
        for number in range(people):
            elsewhere = Chat("memory", f"e{number}", ChatKind.GROUP)
            rooms.container.meet(f"somebody{number}", elsewhere)
            rooms.authoriser.identify(replace(said, chat=elsewhere))
        count = 0

        def follow(frame: FrameType, event: str, _argument: object) -> Any:  # noqa: ANN401
            nonlocal count
            if event == "call":
                frame.f_trace_opcodes = True
            count += event == "opcode"
            return follow

        assert rooms.authoriser.company(Chat("memory", "e0", ChatKind.GROUP))
        stop = replace(said, sender=Address("memory", "x"), standing=MessageValidity.CHANNEL)
        before = sys.gettrace()
        gc.disable()  # whoever hears of a collection is no part of the stop
        sys.settrace(follow)
        try:
            told = await place.gateway.stop_lane.stop(place.chat, stop, (), lambda _: ())
        finally:
            sys.settrace(before)
            gc.enable()
        assert told
        assert not place.robot("omni").gate.latched
        return count


async def test_a_stranger_who_makes_somebody_an_admin_makes_them_known_nowhere() -> None:
    """They have never been there: nothing is served there, and nothing of theirs is forgotten."""

    async def admins(_chat: Chat) -> tuple[Address, ...]:
        return (Address("memory", ADA),)

    async with Place().open() as place:
        place.gateway._messengers[0].admins = admins  # type: ignore[attr-defined]
        await place.say("status", chat="g", kind=ChatKind.GROUP)
        container = place.gateway.rooms.container
        for number in range(CHATS_AT_MOST + 1):
            await unnamed_stop(place, chat=f"h{number}")
        assert container.serves(Chat("memory", "g", ChatKind.GROUP))
        assert not container.serves(Chat("memory", "h0", ChatKind.GROUP))


async def test_what_admins_a_chat_has_is_good_for_as_long_as_it_is_not_asked_anew() -> None:
    """Every stop of nobody's counts meanwhile, and an admin who is none any more does not after."""
    answers = iter([(Address("memory", ADA),), ()])

    async def admins(_chat: Chat) -> tuple[Address, ...]:
        return next(answers)

    clock = ManualClock()
    async with Place(clock=clock).open() as place:
        place.gateway._messengers[0].admins = admins  # type: ignore[attr-defined]
        for _ in range(2):
            await unnamed_stop(place)
            assert place.robot("omni").gate.latched
            await place.say("resume omni")
            assert not place.robot("omni").gate.latched
        await clock.advance(ASKED_AGAIN_NS / SECOND_NS)
        await unnamed_stop(place)
        assert not place.robot("omni").gate.latched
