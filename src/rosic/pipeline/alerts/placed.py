"""Which messages tell of which alarm: whoever reacts to one means that occurrence."""

from __future__ import annotations

import logging
from collections import OrderedDict
from hashlib import blake2b
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.core.record import Fact

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosic.contracts.messenger import Messenger
    from rosic.core.message import Chat
    from rosic.pipeline.alerts.book import Alarm

TOLD: Final = "alarm-told"
REMEMBERED: Final = 4_096

log = logging.getLogger("rosic.alerts")


class Occurrence(NamedTuple):
    """One alarm: its rule, and when it was raised. A later one of the same rule is another."""

    rule: str
    at_ns: int


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(tuple[str, int]).decode


class Placed:
    """Bounded. What changes is so at once, and returned to be written behind it.

    A message stands there as a digest of where it is: a chat's id is an account's.
    """

    def __init__(self, remembered: int = REMEMBERED) -> None:
        self._remembered = remembered
        self._known: OrderedDict[str, Occurrence] = OrderedDict()
        self._of_rule: dict[str, dict[str, None]] = {}

    def restore(self, facts: Iterable[Fact], alarms: Mapping[str, Alarm]) -> tuple[Fact, ...]:
        """Take over what earlier runs said of alarms that are open still; return what ends."""
        ended: list[Fact] = []
        for fact in facts:
            if not fact.body:
                continue
            try:
                occurrence = Occurrence(*_decode(fact.body))
            except msgspec.MsgspecError:
                log.warning("of which alarm a message tells cannot be read; it is forgotten")
                ended.append(_no_fact(fact.key))
                continue
            alarm = alarms.get(occurrence.rule)
            if alarm is None or alarm.at_ns != occurrence.at_ns:
                ended.append(_no_fact(fact.key))
            else:
                ended += self._put(fact.key, occurrence)
        return tuple(ended)

    def note(
        self, occurrence: Occurrence, messenger: Messenger, chat: Chat, message: str
    ) -> tuple[Fact, ...]:
        """A message tells of an alarm."""
        key = _key(messenger, chat, message)
        fact = Fact(kind=TOLD, key=key, body=_encode(tuple(occurrence)))
        return (fact, *self._put(key, occurrence))

    def _put(self, key: str, occurrence: Occurrence) -> list[Fact]:
        """Keep one more; return what ends because there are too many: the oldest."""
        self._forget(key)
        self._known[key] = occurrence
        self._of_rule.setdefault(occurrence.rule, {})[key] = None
        ended: list[Fact] = []
        while len(self._known) > self._remembered:
            oldest = next(iter(self._known))
            self._forget(oldest)
            ended.append(_no_fact(oldest))
        return ended

    def _forget(self, key: str) -> bool:
        occurrence = self._known.pop(key, None)
        if occurrence is None:
            return False
        keys = self._of_rule[occurrence.rule]
        del keys[key]
        if not keys:
            del self._of_rule[occurrence.rule]
        return True

    def of(self, messenger: Messenger, chat: Chat, message: str) -> Occurrence | None:
        """Return of which alarm a message tells."""
        return self._known.get(_key(messenger, chat, message))

    def answered(self, messenger: Messenger, chat: Chat, message: str) -> tuple[Fact, ...]:
        """What is put beside this message from now on says nothing new."""
        key = _key(messenger, chat, message)
        return (_no_fact(key),) if self._forget(key) else ()

    def over(self, rule: str) -> tuple[Fact, ...]:
        """The alarm of a rule is over: nobody can mean it any more."""
        keys = tuple(self._of_rule.get(rule, ()))
        return tuple(_no_fact(key) for key in keys if self._forget(key))


def _key(messenger: Messenger, chat: Chat, message: str) -> str:
    said = "\0".join((messenger.name, chat.platform, chat.id, message))
    return blake2b(said.encode(), digest_size=16).hexdigest()


def _no_fact(key: str) -> Fact:
    return Fact(kind=TOLD, key=key, body=b"")
