"""Which messages tell of which alarms: whoever reacts to one means those occurrences."""

from __future__ import annotations

import logging
from collections import OrderedDict
from hashlib import blake2b
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import msgspec

from rosic.core.identity import DIGEST_BYTES, PrincipalId
from rosic.core.records import Fact

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosic.contracts.messenger import Messenger
    from rosic.core.message import Chat


# ---- which messages tell of which alarms ----

TOLD: Final = "alarm-told"
REMEMBERED: Final = 4_096

log = logging.getLogger("rosic.alerts")


class ActiveAlert(NamedTuple):
    """One alarm: its rule, and when it was raised. A later one of the same rule is another."""

    rule: str
    at_ns: int


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(tuple[tuple[str, int], ...]).decode


def packed(told: Iterable[ActiveAlert]) -> bytes:
    """Return occurrences as the record keeps them: ids and numbers."""
    return _encode(tuple(map(tuple, told)))


def unpacked(content: bytes) -> tuple[ActiveAlert, ...]:
    """Return what was packed.

    Raises:
        msgspec.MsgspecError: It was not.
    """
    return tuple(ActiveAlert(*of) for of in _decode(content))


class AlertMessageIndex:
    """Bounded. What changes is so at once, and returned to be written behind it.

    A message stands there as a digest of where it is: a chat's id is an account's.
    """

    def __init__(self, remembered: int = REMEMBERED) -> None:
        self._remembered = remembered
        self._known: OrderedDict[str, tuple[ActiveAlert, ...]] = OrderedDict()
        self._count = 0
        self._of_rule: dict[str, dict[str, None]] = {}

    def restore(
        self, facts: Iterable[Fact], alarms: Mapping[str, AlertOccurrence]
    ) -> tuple[Fact, ...]:
        """Take over what earlier runs said of alarms that are open still; return what ends."""
        ended: list[Fact] = []
        for fact in facts:
            if not fact.body:
                continue
            try:
                told = unpacked(fact.body)
            except msgspec.MsgspecError:
                log.warning("of which alarms a message tells cannot be read; it is forgotten")
                ended.append(_no_fact(fact.key))
                continue
            if still := tuple(of for of in told if _is_open(of, alarms)):
                ended += self._put(fact.key, still)
            else:
                ended.append(_no_fact(fact.key))
        return tuple(ended)

    def note(
        self, told: tuple[ActiveAlert, ...], messenger: Messenger, chat: Chat, message: str
    ) -> tuple[Fact, ...]:
        """A message tells of one alarm, or of many."""
        key = _key(messenger, chat, message)
        fact = Fact(kind=TOLD, key=key, body=packed(told))
        return (fact, *self._put(key, told))

    def _put(self, key: str, told: tuple[ActiveAlert, ...]) -> list[Fact]:
        """Keep one more; return what ends because there are too many: the oldest."""
        self._forget(key)
        self._known[key] = told
        self._count += len(told)
        for occurrence in told:
            self._of_rule.setdefault(occurrence.rule, {})[key] = None
        ended: list[Fact] = []
        while self._count > self._remembered and len(self._known) > 1:
            oldest = next(iter(self._known))
            self._forget(oldest)
            ended.append(_no_fact(oldest))
        return ended

    def _forget(self, key: str) -> bool:
        told = self._known.pop(key, None)
        if told is None:
            return False
        self._count -= len(told)
        for occurrence in told:
            keys = self._of_rule.get(occurrence.rule, {})
            keys.pop(key, None)
            if not keys:
                self._of_rule.pop(occurrence.rule, None)
        return True

    def of(self, messenger: Messenger, chat: Chat, message: str) -> tuple[ActiveAlert, ...]:
        """Return of which alarms a message tells."""
        return self._known.get(_key(messenger, chat, message), ())

    def answered(self, messenger: Messenger, chat: Chat, message: str) -> tuple[Fact, ...]:
        """What is put beside this message from now on says nothing new."""
        key = _key(messenger, chat, message)
        return (_no_fact(key),) if self._forget(key) else ()

    def over(self, rule: str) -> tuple[Fact, ...]:
        """The alarm of a rule is over: nobody can mean it any more."""
        ended: list[Fact] = []
        for key in tuple(self._of_rule.get(rule, ())):
            told = self._known[key]
            left = tuple(of for of in told if of.rule != rule)
            if not left:
                self._forget(key)
                ended.append(_no_fact(key))
                continue
            # What the record keeps of it is sifted when it is read again.
            self._known[key] = left
            self._count -= len(told) - len(left)
        self._of_rule.pop(rule, None)
        return tuple(ended)


def _is_open(of: ActiveAlert, alarms: Mapping[str, AlertOccurrence]) -> bool:
    alarm = alarms.get(of.rule)
    return alarm is not None and alarm.at_ns == of.at_ns


def _key(messenger: Messenger, chat: Chat, message: str) -> str:
    said = "\0".join((messenger.name, chat.platform, chat.id, message))
    return blake2b(said.encode(), digest_size=DIGEST_BYTES).hexdigest()


def _no_fact(key: str) -> Fact:
    return Fact(kind=TOLD, key=key, body=b"")


# ---- alarms on record ----
# Ids and numbers only.

ALARM: Final = "alarm"
MUTE: Final = "alarm-mute"
RUN: Final = "alarm-run"


class AlertOccurrence(msgspec.Struct, frozen=True, array_like=True):
    """One occurrence; the key of its fact is the rule's.

    Attributes:
        at_ns: When it was raised, wall clock; with the rule it is the identity of the occurrence.
        told: Everybody who was told of it.
        by: Who has seen it; empty: nobody yet.
        level: How often it was escalated.
    """

    at_ns: int
    told: tuple[PrincipalId, ...] = ()
    by: PrincipalId = ""
    level: int = 0


class Silence(msgspec.Struct, frozen=True, array_like=True):
    """A rule that tells nobody for a while; wall clock."""

    by: PrincipalId
    until_ns: int


class AlertRun(msgspec.Struct, frozen=True, array_like=True):
    """When a rule last let its robot do something, wall clock, and for which occurrence."""

    at_ns: int
    alarm_ns: int


_TYPES: Final[dict[str, type[AlertOccurrence | Silence | AlertRun]]] = {
    ALARM: AlertOccurrence,
    MUTE: Silence,
    RUN: AlertRun,
}


class AlertLog:
    """What is open, what is muted, what was run last: each by the key of its rule.

    Attributes:
        alarms: Open now, seen or not.
    """

    def __init__(self) -> None:
        self.alarms: dict[str, AlertOccurrence] = {}
        self._mutes: dict[str, Silence] = {}
        self._runs: dict[str, AlertRun] = {}

    # ---- what is so ----

    def muted(self, key: str, now_ns: int) -> Silence | None:
        """Return the mute of a rule, while it lasts."""
        mute = self._mutes.get(key)
        return mute if mute is not None and now_ns < mute.until_ns else None

    def last_run(self, key: str) -> AlertRun | None:
        """Return when a rule was run last."""
        return self._runs.get(key)

    # ---- what is to be written ----

    def raised(self, key: str, alarm: AlertOccurrence) -> Fact:
        """Return what makes an alarm open, or changes it."""
        return Fact(kind=ALARM, key=key, body=_encode(alarm))

    def cleared(self, key: str) -> Fact:
        """Return what ends an alarm."""
        return Fact(kind=ALARM, key=key, body=b"")

    def mute(self, key: str, mute: Silence) -> Fact:
        """Return what mutes a rule."""
        return Fact(kind=MUTE, key=key, body=_encode(mute))

    def unmute(self, key: str) -> Fact:
        """Return what ends a mute."""
        return Fact(kind=MUTE, key=key, body=b"")

    def run(self, key: str, run: AlertRun) -> Fact:
        """Return what remembers a run."""
        return Fact(kind=RUN, key=key, body=_encode(run))

    # ---- what was written ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. One that cannot be read is left out, so that others count."""
        kept: dict[str, dict[str, Any]] = {
            ALARM: self.alarms,
            MUTE: self._mutes,
            RUN: self._runs,
        }
        shelf = kept[fact.kind]
        if not fact.body:
            shelf.pop(fact.key, None)
            return
        try:
            shelf[fact.key] = msgspec.msgpack.decode(fact.body, type=_TYPES[fact.kind])
        except msgspec.MsgspecError:
            log.warning("what is known of the rule %s cannot be read", fact.key)
