"""I17: a stop without an author is kept back by no other chat, and by no answer that failed."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.core.identity import Address
from rosic.errors import MessengerFault
from rosic.gateway.group_people import AT_ONCE
from tests.gateway.place import ADA, Place
from tests.gateway.test_stopping import unnamed_stop

if TYPE_CHECKING:
    from rosic.core.message import Chat


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
