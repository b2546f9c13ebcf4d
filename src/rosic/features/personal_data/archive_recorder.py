"""A messenger whose chats can be kept: everything that passes is taken into the archive."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, TypeAlias, TypeVar

import msgspec

from rosic.authoriser.invite_codes import without_these
from rosic.container.archive import NOBODY, MessageAuthor
from rosic.contracts.messenger import (
    account_of,
    account_since,
    admins_of,
    alarm_to,
    bot_name_of,
    catching_up,
    is_account,
    keep_pace_with,
    know_with,
    menus_of,
    pictures_of,
    reactions_of,
    retract_of,
    serve_with,
    settle_with,
    turn_of,
    watch_chats,
    watch_reactions,
)
from rosic.core.identity import Address
from rosic.core.language import without_codes
from rosic.core.message import ChatKind
from rosic.errors import StoreFault

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping

    from rosic.container.archive import Archive
    from rosic.contracts.messenger import (
        Alarm,
        Keep,
        Knows,
        Messenger,
        Passed,
        Reacted,
        Receive,
        Serves,
        Settle,
    )
    from rosic.contracts.store import Store
    from rosic.core.message import Chat, Inbound, IncomingFile, Outbound
    from rosic.core.records import Fact

AuthorOf: TypeAlias = Callable[[Address], MessageAuthor]
P = TypeVar("P", "Inbound", "Outbound")

NOT_KEPT: Final = "(not kept)"
_AUTHENTICATOR: Final = "otpauth://"


class ArchivingMessenger:
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
    """

    def __init__(
        self,
        messenger: Messenger,
        archive: Archive,
        store: Store,
        author_of: AuthorOf,
        codes_in: Callable[[str], tuple[str, ...]],
    ) -> None:
        self.platform = messenger.platform
        self.name = messenger.name
        self.assurance = messenger.assurance
        self.edits = messenger.edits
        self.turn = turn_of(messenger)
        self.file_bytes = messenger.file_bytes
        self.fetch_bytes = messenger.fetch_bytes
        self.pins = messenger.pins
        self.react = reactions_of(messenger)
        self.retract = retract_of(messenger)
        self.put_picture = pictures_of(messenger)
        self.set_menus = menus_of(messenger)
        self.settles = False
        self.account = account_of(messenger)
        self.admins = admins_of(messenger)
        self._alarm: Alarm | None = None
        self._messenger = messenger
        self._archive = archive
        self._store = store
        self._author_of = author_of
        self._codes_in = codes_in

    @property
    def bot_name(self) -> str:
        """Return the bot's name on its platform; empty where there is none."""
        return bot_name_of(self._messenger)

    @property
    def on_alarm(self) -> Alarm | None:
        """Return who is told that somebody else acts in its name; see ``contracts.messenger``."""
        return self._alarm

    @on_alarm.setter
    def on_alarm(self, alarm: Alarm) -> None:
        self._alarm = alarm
        alarm_to(self._messenger, alarm)

    def is_account(self, account: str) -> bool:
        """Return whether an account can exist; see ``contracts.messenger``."""
        return is_account(self._messenger, account)

    def settle_with(self, settle: Settle) -> None:
        """Have it ask before it confirms; see ``contracts.messenger``."""
        self.settles = settle_with(self._messenger, settle)

    def account_since(self, since_ns: int, *, several: bool) -> None:
        """Name its account in what was sent since; see ``contracts.messenger``."""
        account_since(self._messenger, since_ns, several=several)

    def keep_pace(self, kept: Mapping[str, bytes], keep: Keep) -> None:
        """Go on with what an earlier run has said; see ``contracts.messenger``."""
        keep_pace_with(self._messenger, kept, keep)

    def know_with(self, known: Knows) -> None:
        """Read first what people known here sent; see ``contracts.messenger``."""
        know_with(self._messenger, known)

    def serve_with(self, serves: Serves) -> None:
        """Wait for what carries nobody's name in chats of ours; see ``contracts.messenger``."""
        serve_with(self._messenger, serves)

    def catching_up(self) -> bool:
        """Return whether backlog may still come; see ``contracts.messenger``."""
        return catching_up(self._messenger)

    def watch_chats(self, passed: Passed) -> None:
        """Have somebody told what happens to chats; see ``contracts.messenger``."""
        watch_chats(self._messenger, passed)

    def watch_reactions(self, reacted: Reacted) -> None:
        """Have somebody told of reactions; an archive keeps words alone."""
        watch_reactions(self._messenger, reacted)

    async def run(self, receive: Receive) -> None:
        """Listen; see ``contracts.messenger``."""

        async def take(inbound: Inbound) -> None:
            if not self._archive.keeps(inbound.chat):
                await receive(inbound)
                return
            kept = _without_secret(self._without_codes(inbound))
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

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:
        """Keep a message in sight, or no longer; see ``contracts.messenger``."""
        await self._messenger.pin(chat, message, pinned=pinned)

    async def answer_tap(self, inbound: Inbound, text: str) -> None:
        """Answer a tap; what is shown for a moment only is not kept."""
        await self._messenger.answer_tap(inbound, text)

    def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Fetch a file; an archive keeps what was written, not what was enclosed."""
        return self._messenger.fetch(enclosure)

    def _say(self, message: str, outbound: Outbound) -> None:
        if not self._archive.keeps(outbound.chat):
            return
        if _AUTHENTICATOR in outbound.text:
            outbound = msgspec.structs.replace(outbound, text=NOT_KEPT)
        kept = self._without_codes(outbound)
        facts = self._archive.say(message, kept, self._reader(kept.chat), self.account)
        if facts:
            self._store.note(*facts)

    def _without_codes(self, passed: P) -> P:
        """Return a message without codes of invitations: whoever reads an export could use them."""
        text = without_these(passed.text, self._codes_in(passed.text), NOT_KEPT)
        return passed if text is passed.text else msgspec.structs.replace(passed, text=text)

    def _reader(self, chat: Chat) -> MessageAuthor:
        """Return who reads a private chat, which has the account's own id."""
        if chat.kind is not ChatKind.PRIVATE:
            return NOBODY
        return self._author_of(Address(chat.platform, chat.id))


def _without_secret(inbound: Inbound) -> Inbound:
    """Return a message without a code that it brings."""
    kept = without_codes(inbound.text, NOT_KEPT)
    return inbound if kept == inbound.text else msgspec.structs.replace(inbound, text=kept)
