"""Misuse by rule: too many refused attempts, or too many requests at once, end a key.

A window is two counters: this span's and the last one's, of which the part counts that still lies
within one span. So a principal costs the same whatever they send.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.authoriser import keys_messages as words
from rosic.core.identity import PrincipalId
from rosic.core.robot.skill import SkillClass

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.clock import Clock

RULE: Final[PrincipalId] = "rule"
"""Who decides when a rule does: stands in the record where a person would."""
PEOPLE_AT_MOST: Final = 20_000
# Being told that a robot is busy, taken or away, or not being understood, is no misuse.
SUSPICIOUS: Final = frozenset({"not-permitted", "too-many-requests", "unrecognised"})
# How the security report counts them.
COUNTED_AS: Final = {"not-permitted": "no-right", "too-many-requests": "too-many"}
# Whoever asks for a stop or for the state of things is never punished for it.
HARMLESS: Final = frozenset({SkillClass.STOP, SkillClass.OBSERVE})


class Threshold(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """More than ``count`` within ``within_s`` is misuse."""

    count: int
    within_s: float

    def __post_init__(self) -> None:
        if self.count < 1 or not 0 < self.within_s < float("inf"):
            raise ValueError("a threshold needs a count of at least 1 and a time above 0")


class AbuseLimits(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When a key ends by rule.

    Attributes:
        refused: Attempts that were refused for want of a right or too fast.
        burst: Requests of any outcome.
    """

    refused: Threshold = Threshold(30, 600.0)
    burst: Threshold = Threshold(300, 60.0)


class InvalidateKey(msgspec.Struct, frozen=True):
    """The rule speaks: this principal's key is to be taken back, by ``RULE``.

    Attributes:
        spare: They are the only admin: the key stays good, and only the admins are told.
        to_person: Empty when spared.
        to_admins: Names the person.
    """

    principal: PrincipalId
    rule: str
    spare: bool
    to_person: str
    to_admins: str


class _Window:
    """A sliding count that forgets."""

    __slots__ = ("_before", "_now", "_span", "_span_ns")

    def __init__(self, within_s: float, now_ns: int) -> None:
        self._span_ns = int(within_s * 1e9)
        self._span = now_ns // self._span_ns
        self._now = 0
        self._before = 0

    def add(self, now_ns: int) -> float:
        """Count one. Return how many lie within the window, about."""
        span, within_ns = divmod(now_ns, self._span_ns)
        if span != self._span:
            self._before = self._now if span == self._span + 1 else 0
            self._now = 0
            self._span = span
        self._now += 1
        return self._now + self._before * (1 - within_ns / self._span_ns)


class AbuseDetector:
    """Counts what each principal does, on the monotonic clock.

    Args:
        clock: Owns the time.
        limits: When it is too much.
        only_admin: Whether somebody is the only admin; asked when a rule speaks.
        name: How somebody is shown to the admins.
    """

    def __init__(
        self,
        clock: Clock,
        limits: AbuseLimits,
        *,
        only_admin: Callable[[PrincipalId], bool],
        name: Callable[[PrincipalId], str],
    ) -> None:
        self._clock = clock
        self._limits = limits
        self._only_admin = only_admin
        self._name = name
        self._windows: OrderedDict[PrincipalId, tuple[_Window, _Window]] = OrderedDict()

    def attempted(
        self, principal: PrincipalId, kind: SkillClass, refused: str = ""
    ) -> InvalidateKey | None:
        """Count one request and its end. Return what a rule says about it, if it says anything.

        Args:
            principal: Who asked.
            kind: Of what they asked for.
            refused: The code of the refusal; empty if it was admitted.
        """
        if kind in HARMLESS:
            return None
        now_ns = self._clock.monotonic_ns()
        burst, bad = self._of(principal, now_ns)
        limits = self._limits
        if burst.add(now_ns) > limits.burst.count:
            what = words.many_attempts(limits.burst.count + 1, limits.burst.within_s)
            return self._speak(principal, "burst", what)
        if refused in SUSPICIOUS and bad.add(now_ns) > limits.refused.count:
            what = words.many_refused(limits.refused.count + 1, limits.refused.within_s)
            return self._speak(principal, "refused", what)
        return None

    def _of(self, principal: PrincipalId, now_ns: int) -> tuple[_Window, _Window]:
        found = self._windows.get(principal)
        if found is None:
            limits = self._limits
            found = (
                _Window(limits.burst.within_s, now_ns),
                _Window(limits.refused.within_s, now_ns),
            )
            self._windows[principal] = found
            if len(self._windows) > PEOPLE_AT_MOST:
                self._windows.popitem(last=False)
        return found

    def _speak(self, principal: PrincipalId, rule: str, what: str) -> InvalidateKey:
        """Say it once: the count begins anew."""
        self.forget(principal)
        name = self._name(principal)
        if self._only_admin(principal):
            return InvalidateKey(principal, rule, True, "", words.spared_admins(name, what))
        told = words.misuse_admins(name, what)
        return InvalidateKey(principal, rule, False, words.misuse_person(what), told)

    def forget(self, principal: PrincipalId) -> None:
        """Begin to count anew: the key was ended, or an admin has looked."""
        self._windows.pop(principal, None)
