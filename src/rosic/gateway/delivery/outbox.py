"""What is owed to somebody who does not wait for it: alarms, notices, the answer to a stop.

Written down before it is said, or beside it where nothing may wait, and crossed out once it was
said: after a crash it is said again, marked. So it is said at least once, and twice at most if the
process died between a platform's taking it and our noting that.
"""

from __future__ import annotations

import logging
from functools import partial
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core import messages
from rosic.core.identity import OUTBOX_KEY_BYTES
from rosic.core.message import Chat, Outbound, SendPriority
from rosic.core.records import Fact, Letter
from rosic.core.time_units import DAY_NS
from rosic.gateway.delivery.sender import ChatSender, OutgoingMessage
from rosic.gateway.delivery.translation import translated

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.store import Store
    from rosic.core.identity import PrincipalId

KIND: Final = "unsaid"
OWED_AT_MOST: Final = 10_000
OWED_FOR_NS: Final = 7 * DAY_NS

log = logging.getLogger("rosic.outbox")


class _Owed(msgspec.Struct, frozen=True, array_like=True):
    """In the open: since when, and how much it matters."""

    since_ns: int
    weight: int


class _Words(msgspec.Struct, frozen=True, array_like=True):
    """Sealed: what to say, and where. Buttons die with the process that offered them.

    Attributes:
        matter: What it is about, for whoever offers anew what can be done about it; often empty.
    """

    messenger: str
    chat: Chat
    text: str
    reply_to: str = ""
    matter: bytes = b""


_encode = msgspec.msgpack.Encoder().encode
_read_owed = msgspec.msgpack.Decoder(_Owed).decode
_read_words = msgspec.msgpack.Decoder(_Words).decode


class Outbox:
    """Remembers what is still to be said, over a crash."""

    def __init__(
        self, store: Store, clock: Clock, entropy: Entropy, chat_sender: ChatSender
    ) -> None:
        self._store = store
        self._clock = clock
        self._entropy = entropy
        self._chat_sender = chat_sender
        self._owed: dict[str, PrincipalId] = {}

    def say(self, to: PrincipalId, note: OutgoingMessage, matter: bytes = b"") -> None:
        """Write down, in somebody's container, what they are to be told; then tell it.

        A disk that does not work holds up nothing.
        """
        if len(self._owed) < OWED_AT_MOST:
            key, fact = self._fact(to, note.messenger, note.outbound, matter)
            note.owe(to, partial(self.said, key))
            self._store.keep(fact, partial(self._chat_sender.say, note))
        else:
            self._chat_sender.say(note)

    def owe(self, to: PrincipalId, messenger: Messenger, outbound: Outbound) -> str:
        """Write down, without waiting, what a later run is to say unless ``said`` comes first."""
        if len(self._owed) >= OWED_AT_MOST:
            return ""
        key, fact = self._fact(to, messenger, outbound)
        self._store.note(fact)
        return key

    def said(self, key: str) -> None:
        """Cross out."""
        if key in self._owed:
            del self._owed[key]
            self._store.note(Fact(kind=KIND, key=key, body=b""))

    def insist(self, key: str, messenger: Messenger, outbound: Outbound) -> None:
        """Say what could not be said at once, for as long as it takes."""
        self._chat_sender.say(self._note(key, messenger, outbound))

    def _note(self, key: str, messenger: Messenger, outbound: Outbound) -> OutgoingMessage:
        to = self._owed.get(key, "")
        return OutgoingMessage(messenger, outbound, then=partial(self.said, key), to=to)

    def restore(
        self,
        facts: Mapping[str, Iterable[Fact]],
        messengers: Mapping[str, Messenger],
        dress: Callable[[OutgoingMessage, bytes], None],
    ) -> int:
        """Say what the last run still owed. Return how much that was.

        Args:
            facts: What was written down.
            messengers: By name.
            dress: Puts under what is said again what can still be done about its matter.
        """
        count = 0
        for fact in facts.get(KIND, ()):
            self._owed[fact.key] = fact.letter.container if fact.letter is not None else ""
            count += self._say_again(fact, messengers, dress)
        return count

    def _say_again(
        self,
        fact: Fact,
        messengers: Mapping[str, Messenger],
        dress: Callable[[OutgoingMessage, bytes], None],
    ) -> bool:
        owed = _Owed(0, SendPriority.ALARM)
        try:
            owed = _read_owed(fact.body)
            found = _read_words(fact.letter.content) if fact.letter is not None else None
        except msgspec.MsgspecError:
            log.warning("what was to be said cannot be read; it is left out")
            found = None
        messenger = messengers.get(found.messenger) if found is not None else None
        late = found is None or self._clock.wall_ns() - owed.since_ns > OWED_FOR_NS
        if found is None or messenger is None or late:
            self.said(fact.key)  # nobody can be told, or it is no news any more
            return False
        outbound = Outbound(
            chat=found.chat,
            text=messages.said_again(found.text),
            reply_to=found.reply_to,
            weight=SendPriority(owed.weight),
        )
        catalogue = self._chat_sender.languages.of(self._owed[fact.key])
        note = self._note(fact.key, messenger, translated(outbound, catalogue))
        if found.matter:
            dress(note, found.matter)
        self._chat_sender.say(note)
        return True

    def _fact(
        self, to: PrincipalId, messenger: Messenger, outbound: Outbound, matter: bytes = b""
    ) -> tuple[str, Fact]:
        key = self._entropy.token(OUTBOX_KEY_BYTES).hex()
        self._owed[key] = to
        held = _Words(messenger.name, outbound.chat, str(outbound.text), outbound.reply_to, matter)
        body = _encode(_Owed(self._clock.wall_ns(), int(outbound.weight)))
        return key, Fact(kind=KIND, key=key, body=body, letter=Letter(to, _encode(held)))
