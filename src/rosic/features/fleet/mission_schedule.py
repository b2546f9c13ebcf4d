"""Missions that begin by themselves, at a time or again and again; at most once each time."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final, TypeAlias

import msgspec
from msgspec.structs import replace

from rosic.core.identity import PrincipalId, command_id
from rosic.core.local_time import LocalTime
from rosic.core.message import Chat
from rosic.core.records import Fact, Letter
from rosic.core.time_units import DAY_NS, MINUTE_NS
from rosic.errors import RecordUnavailable, Refusal
from rosic.features.fleet import mission_messages as words
from rosic.organiser.recurrence import occurrences, read_rule

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterable

    from rosic.contracts.clock import Clock
    from rosic.core.identity import CommandId
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.transactions import Transactions
    from rosic.organiser.timezones import Zone

KIND: Final = "mission-time"
PLANS_AT_MOST: Final = 200
MOST_TIMES: Final = 5_000
LATE_NS: Final = 10 * MINUTE_NS
"""A time that was slept through for longer is left out, and that is said."""
LOOK_S: Final = 1.0
AHEAD_NS: Final = 400 * DAY_NS
"""Every rule that is read comes again within so long, unless it is over."""

log = logging.getLogger("rosic.fleet")


class MissionPlan(msgspec.Struct, frozen=True):
    """When a mission begins, in the zone of the place.

    Attributes:
        mission: By name.
        author: In whose name it begins; their rights of that moment count.
        first: The first time, or the only one.
        rrule: RFC 5545; empty for once.
        after_ns: Wall clock; times up to then are over.
        values: What was said for what it leaves open.
    """

    mission: str
    author: PrincipalId
    first: LocalTime
    rrule: str
    after_ns: int
    values: dict[str, float] = {}


class MissionChat(msgspec.Struct, frozen=True):
    """Where its orders are shown: in the author's container."""

    messenger: str
    chat: Chat


Starter: TypeAlias = "Callable[[MissionPlan, MissionChat, CommandId], Awaitable[str]]"
"""Begins a mission; returns what is said of it."""

_encode = msgspec.msgpack.Encoder().encode
_plan = msgspec.msgpack.Decoder(MissionPlan).decode
_where = msgspec.msgpack.Decoder(MissionChat).decode


class MissionSchedule:
    """Every plan, and the task that waits for the next time.

    Attributes:
        plans: By their numbers.
    """

    def __init__(self, changes: Transactions, reach: Notifier, clock: Clock, zone: Zone) -> None:
        self.plans: dict[str, MissionPlan] = {}
        self._starter: Starter | None = None  # while it does not run
        self._places: dict[str, MissionChat] = {}
        self._next_ns: dict[str, int | None] = {}
        self._changes = changes
        self._reach = reach
        self._clock = clock
        self._zone = zone
        self._waiting: asyncio.Task[None] | None = None
        changes.keep(KIND, self.apply)

    # ---- what is written ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so; a plan whose author's container is erased is none."""
        self.plans.pop(fact.key, None)
        self._places.pop(fact.key, None)
        self._next_ns.pop(fact.key, None)
        if not fact.body or fact.letter is None:
            return
        try:
            plan, where = _plan(fact.body), _where(fact.letter.content)
            if plan.rrule:
                read_rule(plan.rrule, self._zone)
        except (msgspec.MsgspecError, ValueError, Refusal):
            log.warning("a time of a mission cannot be read; it is left out")
            return
        self.plans[fact.key], self._places[fact.key] = plan, where
        self._next_ns[fact.key] = self.next_ns(plan)

    def fact(self, key: str, plan: MissionPlan, where: MissionChat) -> Fact:
        """Return what keeps a plan."""
        return Fact(
            kind=KIND, key=key, body=_encode(plan), letter=Letter(plan.author, _encode(where))
        )

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what ends every plan of somebody."""
        theirs = (key for key, plan in self.plans.items() if plan.author == principal)
        return tuple(Fact(kind=KIND, key=key, body=b"") for key in theirs)

    def next_key(self) -> str:
        """Return a number that no plan has."""
        return str(max(map(int, self.plans), default=0) + 1)

    # ---- when ----

    def next_ns(self, plan: MissionPlan) -> int | None:
        """Return when a plan comes next, wall clock; None: never again."""
        if plan.rrule:
            rule = read_rule(plan.rrule, self._zone)
            last = max(plan.first, self._zone.local(plan.after_ns + AHEAD_NS))
            times: Iterable[LocalTime] = occurrences(rule, plan.first, last, MOST_TIMES)
        else:
            times = (plan.first,)
        starts = (self._zone.instant(local).start_ns for local in times)
        return next((at_ns for at_ns in starts if at_ns > plan.after_ns), None)

    # ---- while it runs ----

    def run(self, starter: Starter) -> None:
        """Begin what is due from now on.

        Args:
            starter: Begins a mission.
        """
        self._starter = starter
        self.look()

    def look(self) -> None:
        """Wait, if there is something to wait for."""
        if self._starter is not None and self.plans and self._waiting is None:
            self._waiting = asyncio.create_task(self._wait())

    async def _wait(self) -> None:
        try:
            while self.plans:
                for key in tuple(self.plans):
                    try:
                        await self._due(key)
                    except RecordUnavailable:
                        log.warning("a mission does not begin while nothing can be written down")
                await self._clock.sleep(LOOK_S)
        finally:
            self._waiting = None

    async def _due(self, key: str) -> None:
        if not self._is_due(key):
            return
        async with self._changes.turn() as turn:
            if not self._is_due(key):
                return  # somebody has taken it back meanwhile
            plan, where, now_ns = self.plans[key], self._places[key], self._clock.wall_ns()
            at_ns = self._next_ns[key]
            fact = Fact(kind=KIND, key=key, body=b"")
            if at_ns is not None:
                fact = self.fact(key, replace(plan, after_ns=at_ns), where)
            await turn.write((fact,))  # that this time is over, before anything begins
        if at_ns is None:
            return
        if now_ns - at_ns > LATE_NS:
            self._reach.tell((plan.author,), words.slept_through(plan.mission))
            return
        await self._begin(key, plan, where, at_ns)

    def _is_due(self, key: str) -> bool:
        """Whether a plan is still there, and its time has come or it never comes again."""
        at_ns = self._next_ns.get(key)
        return key in self.plans and (at_ns is None or at_ns <= self._clock.wall_ns())

    async def _begin(self, key: str, plan: MissionPlan, where: MissionChat, at_ns: int) -> None:
        if self._starter is None:
            return
        cid = command_id("mission", key, plan.mission, plan.author, str(at_ns))
        try:
            text = await self._starter(plan, where, cid)
        except Refusal as refusal:
            text = words.not_begun(plan.mission, refusal.sentence)
        except Exception:
            log.exception("the mission %s could not be begun", plan.mission)
            text = words.not_begun(plan.mission, words.FAULT)
        self._reach.tell((plan.author,), text)

    async def close(self) -> None:
        """Begin nothing any more."""
        self._starter = None
        if self._waiting is not None:
            self._waiting.cancel()
            await asyncio.gather(self._waiting, return_exceptions=True)
