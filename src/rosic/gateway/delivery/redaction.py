"""What holds a secret goes out of a chat once it was used, or its time is over.

An invitation, the key of an authenticator, a code that somebody typed: whoever looks over a
shoulder a week later, or has the phone then, reads it no more. That is a courtesy and no lock:
each of them is worth nothing by then in any case, and nothing hangs on its being gone.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.contracts.messenger import retract_of
from rosic.core.identity import OUTBOX_KEY_BYTES
from rosic.core.message import Chat
from rosic.core.records import Fact, Letter
from rosic.core.time_units import HOUR_NS, SECOND_NS
from rosic.errors import MessageGone, MessengerFault

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId

KIND: Final = "retract"
KEPT_AT_MOST: Final = 2_000
LONGEST_NS: Final = 47 * HOUR_NS
"""Platforms take nothing away that is two days old."""
LOOK_EVERY_S: Final = 5.0
AGAIN_NS: Final = 30 * SECOND_NS

log = logging.getLogger("rosic.redaction")


class KeptSecret(msgspec.Struct, frozen=True, array_like=True):
    """Sealed, in somebody's container: a message that is to go, and because of what."""

    messenger: str
    chat: Chat
    message: str
    secret: str


class _Open(msgspec.Struct, frozen=True, array_like=True):
    """In the open: when it goes at the latest, wall clock."""

    at_ns: int


_encode = msgspec.msgpack.Encoder().encode
_read_kept = msgspec.msgpack.Decoder(KeptSecret).decode
_read_open = msgspec.msgpack.Decoder(_Open).decode


class SecretRedaction:
    """Remembers messages that are to go. Bounded; of a flood, the newest stay.

    Args:
        note: Writes down what is kept.
        is_good: By the first word of a secret's name: whether the secret with that name is still
            worth something.
    """

    def __init__(
        self,
        clock: Clock,
        entropy: Entropy,
        note: Callable[[Fact], None],
        is_good: Mapping[str, Callable[[str], bool]],
    ) -> None:
        self._is_good = is_good
        self._clock = clock
        self._entropy = entropy
        self._messengers: dict[str, Messenger] = {}
        self._note = note
        self._kept: dict[str, tuple[int, KeptSecret]] = {}
        self._again_ns: dict[str, int] = {}
        self._watching: asyncio.Task[None] | None = None
        self._tasks: BackgroundTasks[None] = BackgroundTasks()

    def begin(self, messengers: Iterable[Messenger], facts: Mapping[str, Iterable[Fact]]) -> None:
        """Go on with what an earlier run has kept."""
        self._messengers = {messenger.name: messenger for messenger in messengers}
        for fact in facts.get(KIND, ()):
            try:
                if fact.letter is not None:
                    kept = _read_kept(fact.letter.content)
                    self._kept[fact.key] = (_read_open(fact.body).at_ns, kept)
            except msgspec.MsgspecError:
                log.warning("a message that is to go cannot be read")
        self._watch()

    # ---- what is to go ----

    def keep(
        self,
        secret: str,
        whose: PrincipalId,
        at_ns: int,
        messenger: Messenger,
        chat: Chat,
        message: str,
    ) -> None:
        """Let a message go once a secret is worth nothing, at the latest at ``at_ns`` (wall clock).

        Args:
            secret: Its kind and its name, ``invitation 4711``.
            whose: In whose container that is written; empty: it is not, and a restart forgets it.
            at_ns: When.
            messenger: Through which it was said.
            chat: Where.
            message: Which.
        """
        if retract_of(messenger) is None or not message or len(self._kept) >= KEPT_AT_MOST:
            return
        key = self._entropy.token(OUTBOX_KEY_BYTES).hex()
        at_ns = min(at_ns, self._clock.wall_ns() + LONGEST_NS)
        kept = KeptSecret(messenger.name, chat, message, secret)
        self._messengers.setdefault(messenger.name, messenger)
        self._kept[key] = (at_ns, kept)
        if whose:
            letter = Letter(whose, _encode(kept))
            self._note(Fact(kind=KIND, key=key, body=_encode(_Open(at_ns)), letter=letter))
        self._watch()

    def now(self, messenger: Messenger, chat: Chat, message: str) -> None:
        """Take a message away at once, or soon, if that can be done at all."""
        self.keep("", "", self._clock.wall_ns(), messenger, chat, message)
        self.look()

    def look(self) -> None:
        """Let go whatever is due, or has become worthless. Returns at once."""
        now_ns = self._clock.wall_ns()
        for key, (at_ns, kept) in list(self._kept.items()):
            if now_ns < self._again_ns.get(key, 0):
                continue
            if now_ns >= at_ns or not self._worth(kept.secret):
                self._again_ns[key] = now_ns + AGAIN_NS
                self._tasks.begin(self._retract(key, kept, at_ns))

    def _worth(self, secret: str) -> bool:
        kind, _, name = secret.partition(" ")
        judge = self._is_good.get(kind)
        return judge is None or judge(name)

    async def _retract(self, key: str, kept: KeptSecret, at_ns: int) -> None:
        messenger = self._messengers.get(kept.messenger)
        retract = None if messenger is None else retract_of(messenger)
        late = self._clock.wall_ns() > at_ns + LONGEST_NS
        try:
            if retract is not None and not late:
                await retract(kept.chat, kept.message)
        except MessageGone as gone:
            log.info("a message that held a secret stays where it is: %s", gone)
        except MessengerFault as fault:
            log.info("a message that held a secret is still there: %s", fault)
            return
        self._kept.pop(key, None)
        self._again_ns.pop(key, None)
        self._note(Fact(kind=KIND, key=key, body=b""))

    # ---- time ----

    def _watch(self) -> None:
        if self._kept and self._watching is None:
            self._watching = asyncio.create_task(self._run())

    async def _run(self) -> None:
        while self._kept:
            await self._clock.sleep(LOOK_EVERY_S)
            self.look()
        self._watching = None

    async def close(self) -> None:
        """Look no more. What was written down goes after the next start."""
        for task in (*self._tasks, *filter(None, (self._watching,))):
            task.cancel()
