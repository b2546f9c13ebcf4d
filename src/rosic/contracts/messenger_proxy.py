"""What stands before a messenger: it hides none of its abilities, and claims no others."""

from __future__ import annotations

from functools import cache
from operator import attrgetter
from typing import TYPE_CHECKING, Final, Protocol

from rosic.contracts import chats, console, programs, traffic, verification
from rosic.contracts import messenger as contract

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator
    from typing import Self

    from rosic.contracts.messenger import Messenger, Receive
    from rosic.core.message import Chat, Inbound, IncomingFile, Outbound

ABILITIES: Final[tuple[type, ...]] = tuple(
    found
    for module in (contract, chats, console, programs, traffic, verification)
    for found in vars(module).values()
    if isinstance(found, type)
    and Protocol in found.__bases__
    and found.__module__ == module.__name__
    and found not in (contract.Messenger, programs.Programs, verification.VerificationPrompt)
)
"""The Protocols of what a messenger may be able to do besides."""


class MessengerProxy:
    """Passes everything on to a messenger. One that derives from it changes what it defines itself.

    Whoever asks by ``isinstance`` whether it has an optional ability hears of it what is true of
    the messenger behind it. So there is a class for each set of abilities, made once.

    Args:
        messenger: The one that speaks and listens.
    """

    def __new__(cls, messenger: Messenger, *_more: object, **_named: object) -> Self:
        """Make one with the abilities that the messenger has."""
        found = tuple(ability for ability in ABILITIES if isinstance(messenger, ability))
        of: type = cls
        made: type[Self] = _with_abilities(of, found)
        return super().__new__(made)

    def __init__(self, messenger: Messenger) -> None:
        self.platform = messenger.platform
        self.name = messenger.name
        self.assurance = messenger.assurance
        self.edits = messenger.edits
        self.file_bytes = messenger.file_bytes
        self.fetch_bytes = messenger.fetch_bytes
        self.pins = messenger.pins
        self._messenger = messenger

    async def run(self, receive: Receive) -> None:
        """Pass on; see ``contracts.messenger``."""
        await self._messenger.run(receive)

    async def send(self, outbound: Outbound) -> str:
        """Pass on; see ``contracts.messenger``."""
        return await self._messenger.send(outbound)

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Pass on; see ``contracts.messenger``."""
        await self._messenger.edit(message, outbound)

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:
        """Pass on; see ``contracts.messenger``."""
        await self._messenger.pin(chat, message, pinned=pinned)

    async def answer_tap(self, inbound: Inbound, text: str) -> None:
        """Pass on; see ``contracts.messenger``."""
        await self._messenger.answer_tap(inbound, text)

    def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Pass on; see ``contracts.messenger``."""
        return self._messenger.fetch(enclosure)


@cache
def _with_abilities(of: type, abilities: tuple[type, ...]) -> type:
    """Return a class like another that passes on what these Protocols hold, too."""
    names = {name for ability in abilities for name in members_of(ability)}
    passed_on = {
        name: _passed_on(name) for name in names if not any(name in vars(c) for c in of.__mro__)
    }
    about = {"__module__": of.__module__, "__qualname__": of.__qualname__, "__doc__": of.__doc__}
    return type(of.__name__, (of,), {**about, **passed_on})


def members_of(protocol: type) -> Iterator[str]:
    """Yield what a Protocol asks for, by name."""
    for name in (*vars(protocol), *protocol.__annotations__):
        if not name.startswith("_"):
            yield name


def _passed_on(name: str) -> property:
    behind = attrgetter(name)

    def read(self: MessengerProxy) -> object:
        return behind(self._messenger)

    return property(read)
