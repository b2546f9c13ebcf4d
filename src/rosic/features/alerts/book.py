"""Open alarms and muted rules, as the record keeps them: ids and numbers only."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.records import Fact

if TYPE_CHECKING:
    from collections.abc import Iterable

ALARM: Final = "alarm"
MUTE: Final = "alarm-mute"
RUN: Final = "alarm-run"

log = logging.getLogger("rosic.alerts")


class Alarm(msgspec.Struct, frozen=True, array_like=True):
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


_encode = msgspec.msgpack.Encoder().encode
_TYPES: Final[dict[str, type[Alarm | Silence | AlertRun]]] = {
    ALARM: Alarm,
    MUTE: Silence,
    RUN: AlertRun,
}


class AlertLog:
    """What is open, what is muted, what was run last: each by the key of its rule.

    Attributes:
        alarms: Open now, seen or not.
    """

    def __init__(self) -> None:
        self.alarms: dict[str, Alarm] = {}
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

    def raised(self, key: str, alarm: Alarm) -> Fact:
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
        kept: dict[str, dict[str, object]] = {
            ALARM: self.alarms, MUTE: self._mutes, RUN: self._runs,  # type: ignore[dict-item]
        }  # fmt: skip
        shelf = kept[fact.kind]
        if not fact.body:
            shelf.pop(fact.key, None)
            return
        try:
            shelf[fact.key] = msgspec.msgpack.decode(fact.body, type=_TYPES[fact.kind])
        except msgspec.MsgspecError:
            log.warning("what is known of the rule %s cannot be read", fact.key)
