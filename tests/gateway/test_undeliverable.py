"""What a chat can be told no more is told where it can still be read, and then no further."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from rosic.core.message import Button, ChatKind
from rosic.gateway.delivery.outbox import KIND
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock
from tests.gateway.place import ADA, BO, Place

if TYPE_CHECKING:
    import pytest

LAB = "-5"
OUTCOME = "omni: move, 1.00 m"


async def ordered(place: Place, account: str = BO) -> None:
    """Have somebody move omni from the group, which we are then put out of."""
    place.robot("omni").work_s = 10_000.0
    await place.say("omni move 1 m", account=account, chat=LAB, kind=ChatKind.GROUP)
    place.chat.gone.add(LAB)


async def ended(place: Place) -> list[tuple[str, str]]:
    """Let the order end, and a long time pass; return what was told since, and where."""
    before = len(place.chat.told)
    place.robot("omni").finish()
    await place.quiet()
    for _ in range(60):
        await place.clock.advance(1.0)
    await place.quiet()
    return [(told.outbound.chat.id, told.outbound.text) for told in list(place.chat.told)[before:]]


async def unsaid(store: MemoryStore) -> int:
    return len([fact for fact in (await store.open()).facts.get(KIND, ()) if fact.body])


async def test_how_an_order_ended_is_told_to_its_author_in_private() -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        await ordered(place)
        ((chat, text),) = await ended(place)
        assert chat == BO
        assert text.startswith("I cannot speak any more where you asked this, so here:\nomni: move")
        assert "done 12:00:00" in text
        assert place.gateway.quiet
    assert (await store.open()).unfinished == ()
    assert await unsaid(store) == 0


async def test_if_they_cannot_be_reached_either_an_admin_is_told() -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        await ordered(place)
        place.chat.gone.add(BO)
        ((chat, text),) = await ended(place)
        assert chat == ADA
        assert text.startswith("I cannot reach Bo any more. They were to be told:\n")
        assert "done 12:00:00" in text
    assert await unsaid(store) == 0


async def test_if_nobody_can_be_reached_nothing_is_tried_for_ever(
    caplog: pytest.LogCaptureFixture,
) -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        await ordered(place)
        place.chat.gone |= {BO, ADA}
        refused = place.chat.refused
        with caplog.at_level(logging.ERROR, "rosic.delivery"):
            assert await ended(place) == []
        assert 3 <= place.chat.refused - refused <= 6
        assert "nobody can be told any more" in caplog.text
        assert place.gateway.quiet
    assert (await store.open()).unfinished == ()
    assert await unsaid(store) == 0


async def test_whoever_has_never_written_is_named_in_one_sentence(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with Place().open() as place:
        place.chat.not_begun.add(ADA)
        with caplog.at_level(logging.INFO, "rosic.delivery"):
            for _ in range(2):
                place.gateway.kernel.reach.tell(
                    (who(place, ADA),), "Which?", ((Button("help", "help"),),)
                )
                await place.quiet()
        [only] = caplog.records
        assert only.getMessage() == (
            "memory:1 has not written to memory yet: nothing is told there until then"
        )
        assert only.levelno == logging.WARNING


async def test_what_somebody_has_never_written_for_goes_to_an_admin() -> None:
    async with Place().open() as place:
        place.chat.not_begun.add(BO)
        before = len(place.chat.told)
        place.gateway.kernel.reach.tell((who(place, BO),), "omni: battery 9 %", urgent=True)
        await place.quiet()
        [told] = list(place.chat.told)[before:]
        assert (told.outbound.chat.id, told.outbound.text) == (
            ADA,
            (
                "Bo has not written to me yet, so I cannot reach them. They were to be told:\n"
                "omni: battery 9 %"
            ),
        )


class TwoPhones(Place):
    """Cy has two accounts."""

    people = (
        *Place.people,
        ConfiguredPerson("Cy", (Address("memory", "31"), Address("memory", "32")), ("operator",)),
    )


async def test_nothing_goes_to_and_fro_between_two_chats_that_are_gone() -> None:
    async with TwoPhones().open() as place:
        await ordered(place, "31")
        place.chat.gone |= {"31", "32"}
        refused = place.chat.refused
        told = await ended(place)
        assert {chat for chat, _ in told} == {ADA}
        assert all(text.startswith("I cannot reach Cy any more.") for _, text in told)
        assert place.chat.refused - refused <= 4
        assert place.gateway.quiet


async def test_an_alarm_that_somebody_cannot_be_told_goes_to_the_other_admins() -> None:
    async with Place().open() as place:
        place.chat.gone.add(BO)
        before = len(place.chat.told)
        place.gateway.kernel.reach.tell((who(place, BO),), "omni: battery 9 %", urgent=True)
        await place.quiet()
        ((chat, text),) = [
            (t.outbound.chat.id, t.outbound.text) for t in list(place.chat.told)[before:]
        ]
        assert (chat, text) == (
            ADA,
            "I cannot reach Bo any more. They were to be told:\nomni: battery 9 %",
        )


async def test_what_was_passed_on_outlives_a_crash() -> None:
    store, clock = MemoryStore(), ManualClock()
    async with Place(store, clock=clock).open() as place:
        await ordered(place)
        place.robot("omni").finish()
        place.chat.down = True
        for _ in range(3):
            await place.clock.advance(0.2)
            await asyncio.sleep(0)
        place.chat.down = False
        honest = place.chat.send

        async def lost(outbound: object) -> str:
            if getattr(outbound, "chat", None) is not None and outbound.chat.id == BO:  # type: ignore[attr-defined]
                place.chat.down = True  # the process dies before it could be said
            return await honest(outbound)  # type: ignore[arg-type]

        place.chat.send = lost  # type: ignore[method-assign]
        for _ in range(20):
            await place.clock.advance(1.0)
        assert await unsaid(store) == 1
    async with Place(store, clock=clock).open() as place:
        place.chat.gone.add(LAB)
        for _ in range(20):
            await place.clock.advance(1.0)
        ((chat, text),) = [(t.outbound.chat.id, t.outbound.text) for t in place.chat.told]
        assert chat == BO
        assert "so here:\nomni: move" in text
        assert text.endswith("(Said again: ROSIC was restarted.)")


def who(place: Place, account: str) -> str:
    found = place.gateway.rooms.authoriser.directory.at(Address("memory", account))
    assert found is not None
    return found[0].id
