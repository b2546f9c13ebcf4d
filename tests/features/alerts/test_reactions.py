"""A thumb beside an alarm acknowledges it: by whom, which one, and what it never does."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.identity import Address
from rosic.core.message import Chat, Reaction
from rosic.errors import MessengerFault
from rosic.features.alerts import AlertFeature
from rosic.features.alerts.active_alerts import (
    TOLD,
    ActiveAlert,
    AlertMessageIndex,
    AlertOccurrence,
)
from rosic.messengers.memory import MemoryMessenger
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock
from tests.features.alerts.test_alerts import LOW, battery, heard, place, say
from tests.gateway.place import ADA, BO, STRANGER, VI, Place

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from rosic.core.records import Fact

THUMB = ("👍",)


class Reactive(MemoryMessenger):
    """A messenger on which people put emoji beside messages."""

    def watch_reactions(self, reacted: Callable[[Reaction], None]) -> None:
        self.reacted = reacted
        self.nods: list[tuple[str, str, str]] = []
        self.may_react = True

    async def react(self, chat: Chat, message: str, emoji: str) -> None:
        if not self.may_react:
            raise MessengerFault("not here")
        self.nods.append((chat.id, message, emoji))


@asynccontextmanager
async def reactive(store: MemoryStore | None = None) -> AsyncIterator[Place]:
    """Open a place on whose messenger people react; given a store, it goes on where that ended."""
    here = place(LOW, store=store)
    here.chat.__class__ = Reactive
    async with here.open():
        yield here


@asynccontextmanager
async def alarmed(store: MemoryStore | None = None) -> AsyncIterator[Place]:
    """Open a place whose omni has raised an alarm, and on whose messenger people react."""
    async with reactive(store) as here:
        battery(here, 15)
        await heard(here, 11)
        yield here


def alarm_of(here: Place, account: str) -> str:
    """Return the newest message that told somebody of an alarm."""
    told = [t for t in here.chat.told if t.outbound.chat.id == account and "low" in t.outbound.text]
    return told[-1].message


async def react(here: Place, account: str | None, message: str, *emoji: str) -> dict[str, str]:
    """Put emoji beside a message; return what each account was told because of it."""
    before = len(here.chat.told)
    assert isinstance(here.chat, Reactive)
    who = None if account is None else Address("memory", account)
    chat = Chat("memory", account or ADA)
    here.chat.reacted(Reaction(chat=chat, message=message, who=who, emoji=emoji))
    await here.quiet()
    return {t.outbound.chat.id: t.outbound.text for t in list(here.chat.told)[before:]}


async def test_a_thumb_has_seen_it_and_is_answered_by_a_sign() -> None:
    async with alarmed() as here:
        message, adas = alarm_of(here, BO), alarm_of(here, ADA)
        assert await react(here, BO, message, *THUMB) == {
            ADA: "omni: Battery is low: Bo has seen it."
        }
        assert here.chat.nods == [(BO, message, "👌")]  # type: ignore[attr-defined]
        assert await heard(here, 600) == {}, "it goes no further"
        assert "seen by Bo" in await say(here, ADA, "/alerts")
        assert await react(here, BO, message, *THUMB) == {}
        told = await react(here, ADA, adas, "👀")
        assert "Bo has seen it already" in told[ADA]


async def test_where_no_sign_can_be_made_it_is_said() -> None:
    async with alarmed() as here:
        here.chat.may_react = False  # type: ignore[attr-defined]
        told = await react(here, BO, alarm_of(here, BO), *THUMB)
        assert told[BO].startswith("Noted.")


@pytest.mark.parametrize("emoji", [("👎",), ("🔥", "💩"), ()])
async def test_another_emoji_says_nothing(emoji: tuple[str, ...]) -> None:
    async with alarmed() as here:
        assert await react(here, BO, alarm_of(here, BO), *emoji) == {}
        assert "Bo has seen" not in await say(here, ADA, "/alerts")


async def test_it_counts_within_the_rights_of_who_reacted_at_that_moment() -> None:
    async with alarmed() as here:
        message = alarm_of(here, BO)
        here.chat.told.clear()
        for nobody in (None, STRANGER):
            assert await react(here, nobody, message, *THUMB) == {}
        await say(here, ADA, "/lock Bo")
        assert await react(here, BO, message, *THUMB) == {}, "whoever is locked is told nothing"
        await say(here, ADA, "/unlock Bo")
        assert "seen by" not in await say(here, ADA, "/alerts")


async def test_who_may_only_look_is_told_once_why_it_does_not_count() -> None:
    async with alarmed() as here:
        chat, message = Chat("memory", VI), "m-vi"
        alerting = here.gateway.features.get(AlertFeature).alerting
        told = alerting.telling.placed.of(here.chat, Chat("memory", BO), alarm_of(here, BO))
        assert told
        alerting.telling.placed.note(told, here.chat, chat, message)
        assert "Only who may operate omni" in (await react(here, VI, message, *THUMB))[VI]
        assert await react(here, VI, message, "👌") == {}
        assert "seen by" not in await say(here, ADA, "/alerts")


async def test_a_thumb_under_an_old_alarm_is_none_for_a_new_one() -> None:
    async with alarmed() as here:
        old = alarm_of(here, BO)
        battery(here, 50)
        await heard(here, 2)
        battery(here, 15)
        await heard(here, 11)
        assert await react(here, BO, old, *THUMB) == {}
        assert await react(here, BO, alarm_of(here, BO), *THUMB) != {}


async def test_beside_any_other_message_it_does_nothing() -> None:
    async with alarmed() as here:
        await say(here, BO, "omni wave")
        acted = here.acted()
        assert await react(here, BO, here.last()[0], *THUMB) == {}
        assert here.acted() == acted


# ---- over a restart ----


async def kept(store: MemoryStore) -> list[Fact]:
    """Return what is on disk of messages that tell of alarms."""
    return [fact for fact in await store.facts(TOLD, "", 100) if fact.body]


async def test_a_thumb_beside_what_an_earlier_run_said_has_seen_it() -> None:
    store = MemoryStore()
    async with alarmed(store) as here:
        message = alarm_of(here, BO)
    async with reactive(store) as here:
        battery(here, 15)
        assert await react(here, BO, message, *THUMB) == {
            ADA: "omni: Battery is low: Bo has seen it."
        }
        assert here.chat.nods == [(BO, message, "👌")]  # type: ignore[attr-defined]
        assert await heard(here, 600) == {}, "nobody is told again"
        assert "seen by Bo" in await say(here, ADA, "/alerts")
    async with reactive(store) as here:
        battery(here, 15)
        assert await react(here, BO, message, *THUMB) == {}, "it was answered before"
        assert "seen by Bo" in await say(here, ADA, "/alerts")


async def test_what_is_kept_of_it_ends_with_the_alarm_and_names_nobody() -> None:
    store = MemoryStore()
    async with alarmed(store) as here:
        facts = await kept(store)
        assert len(facts) == 2, "one for each who was told"
        for fact in facts:
            assert fact.letter is None
            assert len(bytes.fromhex(fact.key)) == 16
            assert b"memory" not in fact.body
        battery(here, 50)
        await heard(here, 2)
        assert await kept(store) == []
    async with reactive(store) as here:
        battery(here, 15)
        await heard(here, 11)
        assert len(await kept(store)) == 2, "of the new one"


def test_of_what_was_said_the_newest_are_kept_and_none_whose_alarm_is_over() -> None:
    messenger = MemoryMessenger("memory", clock=ManualClock())

    def told(number: int, placed: AlertMessageIndex) -> tuple[Fact, ...]:
        return placed.note(
            (ActiveAlert("omni/low", 7),), messenger, Chat("memory", str(number)), "m"
        )

    placed, disk = AlertMessageIndex(remembered=3), dict[str, "Fact"]()
    for number in range(10):
        disk.update({fact.key: fact for fact in told(number, placed)})
    assert len([fact for fact in disk.values() if fact.body]) == 3
    assert placed.of(messenger, Chat("memory", "9"), "m") == (("omni/low", 7),)
    assert placed.of(messenger, Chat("memory", "0"), "m") == ()
    [bad] = told(11, AlertMessageIndex())
    facts = [*disk.values(), replace(bad, key="0" * 32, body=b"\xc1")]
    for at_ns, ended in ((7, 1), (8, 4)):
        later = AlertMessageIndex()
        gone = later.restore(facts, {"omni/low": AlertOccurrence(at_ns)})
        assert len(gone) == ended
        assert not any(fact.body for fact in gone)
    assert (
        len(AlertMessageIndex(remembered=2).restore(facts, {"omni/low": AlertOccurrence(7)})) == 2
    )


def test_a_message_of_many_alarms_is_known_until_the_last_of_them_is_over() -> None:
    messenger, chat = MemoryMessenger("memory", clock=ManualClock()), Chat("memory", "1")
    low, hot = ActiveAlert("omni/low", 7), ActiveAlert("omni/hot", 8)
    placed = AlertMessageIndex()
    [kept] = placed.note((low, hot), messenger, chat, "m")
    assert placed.over("omni/low") == ()
    assert placed.of(messenger, chat, "m") == (hot,)
    later = AlertMessageIndex()
    assert later.restore([kept], {"omni/hot": AlertOccurrence(8)}) == ()
    assert later.of(messenger, chat, "m") == (hot,)
    [gone] = placed.over("omni/hot")
    assert (gone.key, gone.body) == (kept.key, b"")
    assert placed.of(messenger, chat, "m") == ()
