"""A messenger whose chats can be kept: everything that passes is taken into the archive."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, TypeAlias, TypeVar

import msgspec

from rosic.authoriser.invite_codes import without_these
from rosic.authoriser.program_keys import without_keys
from rosic.container.archive import NOBODY, MessageAuthor
from rosic.contracts.messenger import AsksToConfirm, account_of
from rosic.contracts.messenger_proxy import MessengerProxy
from rosic.core.identity import Address
from rosic.core.language import without_codes
from rosic.core.message import ChatKind
from rosic.errors import StoreFault

if TYPE_CHECKING:
    from rosic.container.archive import Archive
    from rosic.contracts.messenger import Messenger, Receive
    from rosic.contracts.store import Store
    from rosic.core.language.command import CommandTable
    from rosic.core.message import Chat, Inbound, Outbound
    from rosic.core.records import Fact

AuthorOf: TypeAlias = Callable[[Address], MessageAuthor]
P = TypeVar("P", "Inbound", "Outbound")

NOT_KEPT: Final = "(not kept)"
_AUTHENTICATOR: Final = "otpauth://"


class ArchivingMessenger(MessengerProxy):
    """Stands before a messenger and passes everything on, whatever becomes of the archive.

    What is received is on disk before its receiving ends, so that the platform sends it again if
    this process dies before; that it was received before is known by its identity. It is written
    beside being followed: a stop waits for no disk. What is sent is written down without waiting.

    Args:
        messenger: The one that speaks.
        archive: Which chats are kept.
        store: Where entries go.
        author_of: Who is known at an address.
        codes_in: The codes in a text by which somebody may come in, or could.
        commands: Knows behind which words a secret stands.
    """

    def __init__(
        self,
        messenger: Messenger,
        archive: Archive,
        store: Store,
        author_of: AuthorOf,
        codes_in: Callable[[str], tuple[str, ...]],
        commands: CommandTable,
    ) -> None:
        super().__init__(messenger)
        self._commands = commands
        self._archive = archive
        self._store = store
        self._author_of = author_of
        self._codes_in = codes_in

    @property
    def settles(self) -> bool:
        """Whether the messenger confirms only what is on disk: it asks before it does."""
        return isinstance(self._messenger, AsksToConfirm)

    async def run(self, receive: Receive) -> None:
        """Listen; see ``contracts.messenger``."""

        async def take(inbound: Inbound) -> None:
            if not self._archive.keeps(inbound.chat):
                await receive(inbound)
                return
            kept = _without_secret(self._without_codes(inbound), self._commands)
            facts = self._archive.hear(kept, self._author_of(inbound.sender))
            writing = asyncio.ensure_future(self._write(facts))
            try:
                await receive(inbound)
            finally:
                await writing

        await self._messenger.run(take)

    async def _write(self, facts: tuple[Fact, ...]) -> None:
        if not facts:
            return
        try:
            await self._store.write(*facts)
        except StoreFault:
            self._archive.unwritten(facts)

    async def send(self, outbound: Outbound) -> str:
        """Send; see ``contracts.messenger``."""
        message = await self._messenger.send(outbound)
        self._say(message, outbound)
        return message

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Change what was sent; the archive shows what it was changed to."""
        await self._messenger.edit(message, outbound)
        self._say(message, outbound)

    def _say(self, message: str, outbound: Outbound) -> None:
        if not self._archive.keeps(outbound.chat):
            return
        if _AUTHENTICATOR in outbound.text:
            outbound = msgspec.structs.replace(outbound, text=NOT_KEPT)
        kept = self._without_codes(outbound)
        by = account_of(self._messenger)
        facts = self._archive.say(message, kept, self._reader(kept.chat), by)
        if facts:
            self._store.note(*facts)

    def _without_codes(self, passed: P) -> P:
        """Return a message without codes of invitations, and without keys of programs.

        Whoever reads an export could use them.
        """
        text = without_these(passed.text, self._codes_in(passed.text), NOT_KEPT)
        text = without_keys(text, NOT_KEPT)
        return passed if text is passed.text else msgspec.structs.replace(passed, text=text)

    def _reader(self, chat: Chat) -> MessageAuthor:
        """Return who reads a private chat, which has the account's own id."""
        if chat.kind is not ChatKind.PRIVATE:
            return NOBODY
        return self._author_of(Address(chat.platform, chat.id))


def _without_secret(inbound: Inbound, commands: CommandTable) -> Inbound:
    """Return a message without a code that it brings."""
    kept = without_codes(inbound.text, commands, NOT_KEPT)
    return inbound if kept == inbound.text else msgspec.structs.replace(inbound, text=kept)
