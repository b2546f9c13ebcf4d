"""Algorithm 6 of the paper: the messages of a chat, kept from when an admin says so.

Every entry is a fact with a number; its words are sealed in the container of whoever wrote it, or
whom it answered, so that erasing a person erases what they wrote in every archive. In memory there
is an index alone. Entries are taken in as they come, in one step: they are many, and none of them
changes what anybody may do; the switch is decided and applied like everything else.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.container import archive_records
from rosic.container import messages as words
from rosic.container.archive_records import (
    ArchivedChat,
    ArchiveEntry,
    ArchiveKeeping,
    ArchiveSwitch,
    ChatKey,
    EntryContent,
)
from rosic.core.identity import PrincipalId
from rosic.core.message import ChatKind
from rosic.core.records import Decided, Fact, Letter
from rosic.core.time_units import DAY_NS, MINUTE_NS
from rosic.errors import NotUnderstood, OutOfBounds, TooManyRequests

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.contracts.clock import Clock
    from rosic.core.message import Chat, Inbound, Outbound
    from rosic.core.records import Record

DAYS: Final = 90
DAYS_MOST: Final = 3_650
LONGEST_TEXT: Final = 8_192
_DRAINED_NS: Final = MINUTE_NS

log = logging.getLogger("rosic.container")


class ArchiveQuota(msgspec.Struct, frozen=True):
    """How much may be kept.

    Attributes:
        chats: At once.
        entries, most_bytes: Of one chat; the oldest go when further ones come.
    """

    chats: int = 32
    entries: int = 10_000
    most_bytes: int = 16 << 20


class MessageAuthor(msgspec.Struct, frozen=True):
    """Who wrote a message. An empty id: nobody known."""

    principal: PrincipalId = ""
    name: str = ""


NOBODY: Final = MessageAuthor()


class Archive:
    """Every chat that is kept."""

    def __init__(self, clock: Clock, quota: ArchiveQuota | None = None) -> None:
        self._clock = clock
        self._quota = quota or ArchiveQuota()
        self._chats: dict[ChatKey, ArchiveKeeping] = {}
        self._left: list[tuple[ChatKey, int]] = []  # came while their archive was being dropped

    # ---- the switch: decided, written, applied ----

    def begin(
        self, messenger: str, chat: Chat, by: PrincipalId, *, days: int = DAYS
    ) -> tuple[Record, ...]:
        """Decide that a chat is kept from now on, or for another number of days.

        Raises:
            OutOfBounds: Not so many days.
            NotUnderstood: It is kept already, for as many days.
            TooManyRequests: Many are kept already.
        """
        if not 1 <= days <= DAYS_MOST:
            raise OutOfBounds(words.days_wrong(DAYS_MOST))
        key = archive_records.chat_key(chat)
        known = self._chats.get(key)
        if known is not None and known.switch.on and known.switch.days == days:
            raise NotUnderstood(words.ALREADY_ON)
        on = sum(keeping.switch.on for keeping in self._chats.values())
        if (known is None or not known.switch.on) and on >= self._quota.chats:
            raise TooManyRequests(words.TOO_MANY_ARCHIVES, retry_after_s=0.0)
        return self._switched(key, ArchivedChat(messenger, chat), by, days, on=True)

    def end(self, chat: Chat, by: PrincipalId) -> tuple[Record, ...]:
        """Decide that a chat is kept no longer. What is kept stays as long as it would.

        Raises:
            NotUnderstood: It is not kept.
        """
        key = archive_records.chat_key(chat)
        known = self._chats.get(key)
        if known is None or not known.switch.on or known.venue is None:
            raise NotUnderstood(words.NOT_ON)
        return self._switched(key, known.venue, by, known.switch.days, on=False)

    def _switched(
        self, key: ChatKey, venue: ArchivedChat, by: PrincipalId, days: int, *, on: bool
    ) -> tuple[Record, ...]:
        known, now_ns = self._chats.get(key), self._clock.wall_ns()
        next_n = 1 if known is None else known.next_n
        goes_on = on and known is not None and known.switch.on
        since_ns = known.switch.at_ns if goes_on and known is not None else now_ns
        body = archive_records.encode(
            ArchiveSwitch(on=on, by=by, at_ns=since_ns, days=days, next_n=next_n)
        )
        letter = Letter(archive_records.container_of(key), archive_records.encode(venue))
        act = "archive" if on else "unarchive"
        return (
            Decided(act=act, by=by, about=key, at_ns=now_ns, digest=str(days).encode()),
            Fact(kind=archive_records.SWITCH, key=key, body=body, letter=letter),
        )

    # ---- asking ----

    def state(self, chat: Chat) -> ArchiveKeeping | None:
        """Return what is known of a chat's archive, on or off; None if there is none."""
        return self._chats.get(archive_records.chat_key(chat))

    def keeps(self, chat: Chat) -> bool:
        """Whether a chat's messages are kept now; one look-up."""
        if not self._chats:
            return False
        known = self._chats.get(archive_records.chat_key(chat))
        return known is not None and known.switch.on

    def all(self) -> dict[ChatKey, ArchiveKeeping]:
        """Return every archive."""
        return dict(self._chats)

    # ---- entries: taken in as they come ----

    def hear(self, inbound: Inbound, author: MessageAuthor) -> tuple[Fact, ...]:
        """Take in a message as it was received; return what is to be written: nothing if known.

        A gap comes before the message that shows it: the adapter had been interrupted since the
        one before.
        """
        key = archive_records.chat_key(inbound.chat)
        known = self._chats.get(key)
        identity = archive_records.identity_of(inbound)
        if known is None or not known.switch.on or identity in known.found:
            return ()
        backlog = inbound.listening_since_ns > inbound.received_ns
        gaps = self._gap(key, known, inbound, backlog=backlog)
        tapped = inbound.nonce is not None
        note = "button" if tapped else inbound.standing.value.replace("fresh", "")
        message = inbound.under if tapped else inbound.message
        said = EntryContent(
            inbound.sender.account, str(author.name), _cut(inbound.text), note, message
        )
        entry = ArchiveEntry(
            at_ns=inbound.received_ns,
            way="in",
            who=author.principal,
            identity=identity,
            since_ns=_since(known, inbound, backlog=backlog),
            backlog=backlog,
        )
        return (*gaps, *self._add(key, known, entry, said))

    def say(
        self, message: str, outbound: Outbound, reader: MessageAuthor, account: str = ""
    ) -> tuple[Fact, ...]:
        """Take in a message as it was sent, or as it looks after an edit.

        Args:
            message: The platform's id.
            outbound: How it looks.
            reader: Whom it speaks to, where that is known otherwise; else it is whoever is
                answered.
            account: Which of our own accounts said it, where there can be several.
        """
        key = archive_records.chat_key(outbound.chat)
        known = self._chats.get(key)
        if known is None or not known.switch.on:
            return ()
        identity = archive_records.sent_digest(outbound.chat, message, account)
        n = known.found.get(identity)
        who = reader.principal or self._answered(known, outbound, account)
        at_ns = self._clock.wall_ns()
        if n is not None:
            at_ns, who = known.entries[n].at_ns, known.entries[n].who
        entry = ArchiveEntry(at_ns=at_ns, way="out", who=who, identity=identity)
        file = outbound.attachment
        note = "" if file is None else f"file {file.name}"
        content = EntryContent("", "", _cut(outbound.text), note, message)
        return self._add(key, known, entry, content, n)

    @staticmethod
    def _answered(known: ArchiveKeeping, outbound: Outbound, account: str) -> PrincipalId:
        for own in (account, ""):
            identity = archive_records.received_digest(outbound.chat, outbound.reply_to, own)
            if (n := known.found.get(identity)) is not None:
                return known.entries[n].who
        return ""

    def unwritten(self, facts: Iterable[Fact]) -> None:
        """Note that entries did not reach the disk: the next one says that some are missing."""
        for fact in facts:
            key, n = archive_records.place_of(fact.key)
            known = self._chats.get(key)
            if known is not None and fact.body:
                known.lose(n, self._clock.wall_ns())

    def _gap(
        self, key: ChatKey, known: ArchiveKeeping, inbound: Inbound, *, backlog: bool
    ) -> tuple[Fact, ...]:
        """Return the gap since the newest message before, if the adapter was interrupted."""
        last = known.heard
        if last is None or last.at_ns < known.switch.at_ns:
            return ()
        since_ns = inbound.received_ns if backlog else inbound.listening_since_ns
        if last.backlog:  # that gap was marked; a backlog is over soon, or there is another gap
            interrupted = since_ns > last.at_ns + _DRAINED_NS
        else:
            interrupted = backlog or since_ns != last.since_ns
        if not interrupted:
            return ()
        entry = ArchiveEntry(at_ns=last.at_ns, way="gap", until_ns=max(since_ns, last.at_ns))
        return self._add(key, known, entry, None)

    def _add(
        self,
        key: ChatKey,
        known: ArchiveKeeping,
        entry: ArchiveEntry,
        said: EntryContent | None,
        n: int | None = None,
    ) -> tuple[Fact, ...]:
        """Give an entry its number and its room; the oldest make way."""
        facts: list[Fact] = []
        if known.unwritten_ns:
            lost = known.lost(self._clock.wall_ns())
            facts.append(archive_records.entry_fact(key, known.next_n, lost, None))
            known.put(known.next_n, lost)
        letter = None
        if said is not None:
            content = archive_records.encode(said)
            letter = Letter(entry.who or archive_records.container_of(key), content)
            entry = msgspec.structs.replace(entry, size=len(content))
        n = known.next_n if n is None else n
        known.put(n, entry)
        facts.append(archive_records.entry_fact(key, n, entry, letter))
        while self._too_much(known):
            oldest = next(iter(known.entries))
            known.drop(oldest)
            facts.append(archive_records.no_more(key, oldest))
        return tuple(facts)

    def _too_much(self, known: ArchiveKeeping) -> bool:
        quota = self._quota
        over = len(known.entries) > quota.entries or known.size > quota.most_bytes
        return over and len(known.entries) > 1

    # ---- forgetting ----

    def outdated(self, most: int = 1_000) -> tuple[Fact, ...]:
        """Return what ends entries older than their chat keeps them, and archives that are over."""
        now_ns = self._clock.wall_ns()
        found = [archive_records.no_more(*place) for place in self._left[:most]]
        for key, known in self._chats.items():
            before_ns = now_ns - known.switch.days * DAY_NS
            for n, entry in known.entries.items():
                if entry.at_ns >= before_ns or len(found) >= most:
                    break
                found.append(archive_records.no_more(key, n))
            if not known.switch.on and not known.entries and len(found) < most:
                found.append(Fact(kind=archive_records.SWITCH, key=key, body=b""))
        return tuple(found)

    def drop(self, key: ChatKey) -> tuple[Fact, ...]:
        """Return what ends a whole archive at once."""
        known = self._chats.get(key)
        if known is None:
            return ()
        entries = (archive_records.no_more(key, n) for n in known.entries)
        return (*entries, Fact(kind=archive_records.SWITCH, key=key, body=b""))

    def end_private(self, is_theirs: Callable[[Chat], bool]) -> tuple[Fact, ...]:
        """Return what ends the archives of somebody's private chats.

        In groups their words become unreadable with their container; that they wrote, stays.
        """
        return tuple(
            fact
            for key, known in self._chats.items()
            if known.venue is not None
            and known.venue.chat.kind is ChatKind.PRIVATE
            and is_theirs(known.venue.chat)
            for fact in self.drop(key)
        )

    # ---- what is so ----

    def restore(self, switches: Iterable[Fact], entries: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote, in the order of the numbers."""
        for fact in switches:
            self.apply(fact)
        for fact in sorted(entries, key=lambda fact: fact.key):
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. One that cannot be read is left out."""
        try:
            if fact.kind == archive_records.SWITCH:
                self._apply_switch(fact)
            else:
                self._apply_entry(fact)
        except (msgspec.MsgspecError, ValueError):
            log.warning("a part of an archive cannot be read; it is left out")

    def _apply_switch(self, fact: Fact) -> None:
        if not fact.body:
            gone = self._chats.pop(fact.key, None)
            self._left += [(fact.key, n) for n in (gone.entries if gone is not None else ())]
            return
        switch = archive_records.read_switch(fact.body)
        known = self._chats.get(fact.key)
        if known is None:
            known = self._chats[fact.key] = ArchiveKeeping(switch)
        known.switch = switch
        known.venue = (
            None if fact.letter is None else archive_records.read_venue(fact.letter.content)
        )

    def _apply_entry(self, fact: Fact) -> None:
        key, n = archive_records.place_of(fact.key)
        known = self._chats.get(key)
        if known is None:
            if (key, n) in self._left and not fact.body:
                self._left.remove((key, n))
            return
        if fact.body:
            known.put(n, archive_records.read_entry(fact.body))
        else:
            known.drop(n)


def _since(known: ArchiveKeeping, inbound: Inbound, *, backlog: bool) -> int:
    """Return since when the adapter has listened; in a backlog, what was known before it."""
    if not backlog:
        return inbound.listening_since_ns
    return 0 if known.heard is None else known.heard.since_ns


def _cut(text: str) -> str:
    """Return a text as it can be kept and shown: without lone surrogates, not endless."""
    text = text.encode("utf-8", "replace").decode()
    return text if len(text) <= LONGEST_TEXT else text[:LONGEST_TEXT] + words.CUT
