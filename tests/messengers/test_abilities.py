"""What a messenger may be able to do besides: asked by its type, and hidden by no wrapper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.container.archive import NOBODY, Archive
from rosic.contracts import chats, console, programs, traffic, verification
from rosic.contracts import messenger as contract
from rosic.contracts.messenger import Messenger
from rosic.contracts.messenger_proxy import ABILITIES, MessengerProxy, members_of
from rosic.core.identity import Address
from rosic.core.language.command import NO_COMMANDS
from rosic.core.message import Chat
from rosic.core.secret import Secret
from rosic.errors import MessengerFault
from rosic.features.personal_data.archive_recorder import ArchivingMessenger
from rosic.messengers.memory import MemoryMessenger
from rosic.messengers.telegram import telegram_messenger
from rosic.messengers.telegram.messenger import TelegramMessenger
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from rosic.contracts.messenger import Receive
    from rosic.core.message import Inbound, IncomingFile, Outbound

ASKED: tuple[Callable[[Messenger], object], ...] = (
    contract.turn_of,
    contract.admins_of,
    contract.account_of,
    contract.handle_of,
    lambda messenger: contract.invite_link_of(messenger, Secret("7K3M-Q0ZD")),
    lambda messenger: contract.hearing_of(messenger, everywhere=True),
    contract.reactions_of,
    contract.pictures_of,
    contract.retract_of,
    contract.menus_of,
    contract.catching_up,
    traffic.is_connected,
    lambda messenger: chats.private_chat_of(messenger, Address("bare", "1")),
    lambda messenger: chats.chat_assurance_of(messenger, Chat("bare", "1")),
    lambda messenger: contract.is_account(messenger, "no number"),
    traffic.traffic_of,
)


def telegram() -> Messenger:
    return telegram_messenger("bot", {"token": "1234:" + "a" * 35}, ManualClock())


def memory() -> Messenger:
    return MemoryMessenger(clock=ManualClock())


def kept(messenger: Messenger) -> ArchivingMessenger:
    clock = ManualClock()
    return ArchivingMessenger(
        messenger, Archive(clock), MemoryStore(), lambda _: NOBODY, lambda _: (), NO_COMMANDS
    )


def abilities() -> list[type]:
    return [
        found
        for module in (contract, chats, console, programs, traffic, verification)
        for found in vars(module).values()
        if getattr(found, "_is_runtime_protocol", False) and found is not Messenger
    ]


def able(*names: str) -> Messenger:
    """Return a messenger that has exactly what these Protocols ask for, besides what all have."""
    wanted = [ability for ability in abilities() if ability.__name__ in names]
    members = {member: lambda *_, **__: None for one in wanted for member in members_of(one)}
    made: Messenger = type("Able", (MessengerProxy,), members)(bare())
    return made


def bare() -> Messenger:
    return MessengerProxy(Bare())


class Bare:
    """No more than every messenger has."""

    platform = name = assurance = "bare"
    edits = pins = False
    file_bytes = fetch_bytes = 0

    async def run(self, receive: Receive) -> None: ...
    async def send(self, outbound: Outbound) -> str:
        return outbound.text

    async def edit(self, message: str, outbound: Outbound) -> None: ...
    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None: ...
    async def answer_tap(self, inbound: Inbound, text: str) -> None: ...
    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        yield enclosure.name.encode()


def test_every_optional_protocol_is_known_to_the_proxy() -> None:
    assert set(ABILITIES) == set(abilities())
    assert len(ABILITIES) > 20


@pytest.mark.parametrize("ability", ABILITIES, ids=lambda one: one.__name__)
def test_a_proxy_has_an_ability_exactly_if_what_is_behind_it_has(ability: type) -> None:
    assert not isinstance(bare(), ability)
    seen = MessengerProxy(MessengerProxy(able(ability.__name__)))
    held = {one for one in ABILITIES if isinstance(able(ability.__name__), one)}
    assert {one for one in ABILITIES if isinstance(seen, one)} == held
    assert ability in held


def test_what_a_wrapper_defines_itself_is_its_own() -> None:
    class Quiet(MessengerProxy):
        def catching_up(self) -> bool:
            return True

    raw = memory()
    assert not contract.catching_up(MessengerProxy(raw))
    assert contract.catching_up(Quiet(raw))
    assert type(Quiet(raw)).__name__ == "Quiet"
    assert isinstance(Quiet(raw), Quiet)


def test_telegram_can_do_all_that_is_asked_of_messengers() -> None:
    lacking = [a.__name__ for a in abilities() if not isinstance(telegram(), a)]
    chats_of_matrix = ["HasChatAssurance", "FindsPrivateChat"]
    theirs = ["ServesPrograms", "AttachesPrograms", "VerifiesDevices"]
    others = ["SupportsCompletion", "Console", *theirs]
    assert lacking == ["WaitsForDisk", *chats_of_matrix, *others], (
        "who keeps chats says the first; the others are Matrix's, a terminal's, and of programs"
    )


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


def test_telegrams_links_and_advice_are_telegrams() -> None:
    shown = telegram()
    assert contract.handle_of(shown) == contract.invite_link_of(shown, Secret("X")) == ""
    assert "/setprivacy to BotFather, then take me out" in contract.hearing_of(
        shown, everywhere=False
    )
    assert "In groups the messenger bot passes me only" in contract.hearing_of(
        shown, everywhere=True
    )


def test_an_alarm_passes_through_the_keeping_of_chats() -> None:
    raw, told = telegram(), list[MessengerFault]()
    contract.alarm_to(kept(raw), told.append)
    assert isinstance(raw, TelegramMessenger)
    raw._raise_alarm(fault := MessengerFault("Another program receives."))
    assert told == [fault]
