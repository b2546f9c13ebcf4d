"""Alarms, notices and the answers to stops outlive the process that owed them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.errors import MessengerFault
from rosic.gateway.delivery.outbox import KIND
from rosic.messengers.memory import MemoryMessenger
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock
from tests.gateway.place import ADA, BO, BrokenStore, Place

if TYPE_CHECKING:
    from rosic.contracts.messenger import Alarm
    from rosic.core.message import Outbound

AGAIN = "(Said again: ROSIC was restarted.)"
DAY_S = 86_400.0


class Watched(MemoryMessenger):
    """Somebody else may receive in its name."""

    alarm: Alarm

    def alarm_with(self, alarm: Alarm) -> None:
        self.alarm = alarm


def watched(clock: ManualClock) -> Watched:
    return Watched("memory", clock=clock)


async def owed(store: MemoryStore) -> int:
    return len((await store.open()).facts.get(KIND, ()))


def heard(place: Place, account: str) -> list[str]:
    return [t.outbound.text for t in place.chat.told if t.outbound.chat.id == account]


async def dies(store: MemoryStore, clock: ManualClock, text: str, *, urgent: bool = True) -> None:
    """Run a gateway that owes Ada a sentence and cannot say it before it is gone."""
    async with Place(store, clock=clock).open() as place:
        place.chat.down = True
        ada = place.gateway.kernel.admins()
        place.gateway.kernel.reach.tell(ada, text, urgent=urgent)
        await place.quiet()


async def test_an_alarm_that_was_not_said_is_said_by_the_next_run_once() -> None:
    store, clock = MemoryStore(), ManualClock()
    await dies(store, clock, "Somebody guesses codes.")
    assert await owed(store) == 1

    async with Place(store, clock=clock).open() as place:
        await place.quiet()
        assert heard(place, ADA) == [f"Somebody guesses codes.\n{AGAIN}"]
        assert heard(place, BO) == []
    assert await owed(store) == 0
    async with Place(store, clock=clock).open() as place:
        await place.quiet()
        assert heard(place, ADA) == []


async def test_a_notice_without_an_offer_is_kept_as_well() -> None:
    store, clock = MemoryStore(), ManualClock()
    await dies(store, clock, "Your slot was cancelled.", urgent=False)

    async with Place(store, clock=clock).open() as place:
        await place.quiet()
        assert heard(place, ADA) == [f"Your slot was cancelled.\n{AGAIN}"]


async def test_what_was_said_is_owed_no_more() -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        place.gateway.kernel.reach.tell(("nobody",), "nothing", urgent=True)
        place.gateway.kernel.reach.tell(place.gateway.kernel.admins(), "now", urgent=True)
        await place.quiet()
        assert heard(place, ADA) == ["now"]
    assert await owed(store) == 0


async def test_what_is_a_week_old_is_no_news() -> None:
    store, clock = MemoryStore(), ManualClock()
    await dies(store, clock, "Somebody guesses codes.")
    await clock.advance(8 * DAY_S)
    async with Place(store, clock=clock).open() as place:
        await place.quiet()
        assert heard(place, ADA) == []
    assert await owed(store) == 0


async def test_a_broken_disk_holds_up_no_alarm() -> None:
    store = BrokenStore()
    async with Place(store).open() as place:
        store.broken = True
        place.gateway.kernel.reach.tell(place.gateway.kernel.admins(), "now", urgent=True)
        await place.quiet()
        assert heard(place, ADA) == ["now"]


async def test_a_stop_whose_answer_was_cut_off_is_answered_by_the_next_run() -> None:
    store, clock = MemoryStore(), ManualClock()
    async with Place(store, clock=clock).open() as place:
        place.chat.down = True
        await place.say("stop omni", account=BO, chat=BO)
        assert place.robot("omni").gate.latched

    async with Place(store, clock=clock).open() as place:
        await place.quiet()
        (said,) = heard(place, BO)
        assert said.startswith("STOP was sent to omni. ROSIC was interrupted before rest was seen")
    assert await owed(store) == 0


async def test_the_answer_to_a_stop_is_said_when_the_messenger_is_back() -> None:
    async with Place().open() as place:
        place.chat.down = True
        await place.say("stop omni", account=BO, chat=BO)
        await place.clock.advance(30.0)
        place.chat.down = False
        await place.clock.advance(120.0)
        assert any(text.startswith("STOP: omni at rest") for text in heard(place, BO))


async def test_admins_hear_it_when_somebody_else_receives_for_a_bot() -> None:
    async with Place(chat=watched).open() as place:
        assert isinstance(place.chat, Watched)
        place.chat.alarm(MessengerFault("Another program receives the messages of the bot."))
        await place.quiet()
        assert heard(place, ADA) == ["Another program receives the messages of the bot."]
        assert heard(place, BO) == []
        told: Outbound = place.chat.told[-1].outbound
        assert told.urgent
