"""What a messenger may be able to do besides: asked by its type, and hidden by no wrapper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.container.archive import NOBODY, Archive
from rosic.contracts import messenger as contract
from rosic.contracts.messenger import Messenger, RaisesAlarms
from rosic.errors import MessengerFault
from rosic.features.personal_data.archive_recorder import ArchivingMessenger
from rosic.messengers.memory import MemoryMessenger
from rosic.messengers.telegram import telegram_messenger
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock

if TYPE_CHECKING:
    from collections.abc import Callable

ASKED: tuple[Callable[[Messenger], object], ...] = (
    contract.turn_of,
    contract.admins_of,
    contract.account_of,
    contract.bot_name_of,
    contract.reactions_of,
    contract.pictures_of,
    contract.retract_of,
    contract.menus_of,
    contract.catching_up,
    lambda messenger: contract.is_account(messenger, "no number"),
)


def telegram() -> Messenger:
    return telegram_messenger("bot", {"token": "1234:" + "a" * 35}, ManualClock())


def memory() -> Messenger:
    return MemoryMessenger(clock=ManualClock())


def kept(messenger: Messenger) -> ArchivingMessenger:
    clock = ManualClock()
    return ArchivingMessenger(
        messenger, Archive(clock), MemoryStore(), lambda _: NOBODY, lambda _: ()
    )


def abilities() -> list[type]:
    return [
        found
        for name, found in vars(contract).items()
        if getattr(found, "_is_runtime_protocol", False) and found is not Messenger
    ]


def test_telegram_can_do_all_that_is_asked_of_messengers() -> None:
    lacking = [a.__name__ for a in abilities() if not isinstance(telegram(), a)]
    assert lacking == ["WaitsForDisk"], "only who keeps chats says so"


@pytest.mark.parametrize("made", [telegram, memory])
def test_keeping_chats_hides_no_ability(made: Callable[[], Messenger]) -> None:
    raw = made()
    seen = kept(raw)
    assert [a for a in abilities() if isinstance(raw, a) and not isinstance(seen, a)] == []
    assert [ask(seen) for ask in ASKED] == [ask(raw) for ask in ASKED]


def test_what_a_messenger_cannot_do_it_cannot_do_when_its_chats_are_kept() -> None:
    seen = kept(memory())
    for lacking in (contract.NamesAdmins, contract.Reacts, contract.Retracts, contract.OffersMenus):
        assert not isinstance(seen, lacking)


def test_an_alarm_passes_through_the_keeping_of_chats() -> None:
    raw, told = telegram(), list[MessengerFault]()
    contract.alarm_to(kept(raw), told.append)
    assert isinstance(raw, RaisesAlarms)
    raw.on_alarm(fault := MessengerFault("Another program receives."))
    assert told == [fault]
