"""Orders that wait for their time: kept over a restart, begun once each time, and never late."""

from __future__ import annotations

import asyncio
import logging
from collections import defaultdict
from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol

import msgspec
from msgspec.structs import replace

from rosic.core.identity import PrincipalId
from rosic.core.local_time import LocalTime
from rosic.core.message import Chat
from rosic.core.records import Decided, Fact, Letter
from rosic.core.robot.profile import RobotId
from rosic.core.time_units import DAY_NS
from rosic.errors import RecordUnavailable, Refusal
from rosic.gateway.transactions import WriteBehind
from rosic.organiser.recurrence import occurrences, read_rule
from rosic.organiser.timezones import zone_named

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.contracts.clock import Clock
    from rosic.gateway.transactions import Transactions

KIND: Final = "scheduled-order"
OF_ONE_AT_MOST: Final = 20
IN_ALL_AT_MOST: Final = 2_000
MOST_TIMES: Final = 5_000
LOOK_S: Final = 1.0
AHEAD_NS: Final = 400 * DAY_NS
"""Every rule that is read comes again within so long, unless it is over."""
AT_ONCE: Final = 100
"""So many times are written down as over in one turn; the others follow in the next."""
STALE_AT_MOST: Final = 64
"""So many times that count no more wait among the others before they are swept out."""

log = logging.getLogger("rosic.scheduled")


class ScheduledTime(msgspec.Struct, frozen=True):
    """When orders are given.

    Attributes:
        zone: IANA; in which a time that comes again is meant.
        at_ns: Wall clock: the only time, or 0.
        first: Of what comes again, the first time.
        rrule: RFC 5545; empty for once.
    """

    zone: str
    at_ns: int = 0
    first: LocalTime | None = None
    rrule: str = ""

    def after(self, after_ns: int) -> int | None:
        """Return the next time after a moment, wall clock; None: it does not come again."""
        if self.first is None:
            return self.at_ns if self.at_ns > after_ns else None
        zone = zone_named(self.zone)
        last = max(self.first, zone.local(after_ns + AHEAD_NS))
        times = occurrences(read_rule(self.rrule, zone), self.first, last, MOST_TIMES)
        starts = (zone.instant(local).start_ns for local in times)
        return next((at_ns for at_ns in starts if at_ns > after_ns), None)


class ScheduledOrder(msgspec.Struct, frozen=True):
    """What somebody has agreed to, as it stands in the open: ids, numbers and digests.

    Attributes:
        author: In whose name it is given; their rights of that moment count.
        after_ns: Wall clock; times up to then are over.
        given_ns: Wall clock; with the number it is this one, for ever.
        lives_ns: So long after its time it may still begin: as long as its first order lives.
        digests: What each step lets robots do, as it was shown.
        generations: How often each of its robots had been stopped when it was agreed to.
        begun_ns: The time for which it is under way; 0: it waits.
    """

    author: PrincipalId
    when: ScheduledTime
    after_ns: int
    given_ns: int
    lives_ns: int
    digests: tuple[bytes, ...]
    generations: dict[RobotId, int]
    begun_ns: int = 0


class ScheduledText(msgspec.Struct, frozen=True):
    """What stands in the author's container: their words, and where the orders are shown.

    Attributes:
        steps: Each by itself, with the name of whom it is for.
        typed: All of it as it was said.
    """

    messenger: str
    chat: Chat
    steps: tuple[str, ...]
    typed: str


class OrderOccurrence(NamedTuple):
    """One whose time has come.

    Attributes:
        at_ns: The time, wall clock.
    """

    key: str
    order: ScheduledOrder
    text: ScheduledText
    at_ns: int


class OccurrenceHandler(Protocol):
    """Does what is due. Neither method waits for anything."""

    def begin(self, due: OrderOccurrence) -> None:
        """Begin it. That its time is over is on disk."""

    def missed(self, due: OrderOccurrence) -> None:
        """Say that it was too late to begin."""


_encode = msgspec.msgpack.Encoder().encode
_order = msgspec.msgpack.Decoder(ScheduledOrder).decode
_text = msgspec.msgpack.Decoder(ScheduledText).decode


class OrderSchedule:
    """Every order that waits for its time, and the task that waits for the next.

    Attributes:
        orders: By their numbers.
        texts: Likewise.
    """

    def __init__(self, changes: Transactions, clock: Clock) -> None:
        self.orders: dict[str, ScheduledOrder] = {}
        self.texts: dict[str, ScheduledText] = {}
        self.next_ns: dict[str, int | None] = {}
        self._of: defaultdict[PrincipalId, set[str]] = defaultdict(set)
        self._times: list[tuple[int, str]] = []
        self._last = 0
        self._handler: OccurrenceHandler | None = None  # while it does not run
        self._changes = changes
        self._behind = WriteBehind(changes)
        self._clock = clock
        self._waiting: asyncio.Task[None] | None = None

    # ---- what is written ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so; one whose author's container is erased is none."""
        before = self.orders.pop(fact.key, None)
        if before is not None:
            self._leave(before.author, fact.key)
        self.texts.pop(fact.key, None)
        self.next_ns.pop(fact.key, None)
        if fact.key.isdecimal():
            self._last = max(self._last, int(fact.key))
        if not fact.body or fact.letter is None:
            return
        try:
            order, text = _order(fact.body), _text(fact.letter.content)
            at_ns = order.when.after(order.after_ns)
        except (msgspec.MsgspecError, ValueError, Refusal):
            log.warning("an order that waits for its time cannot be read; it is left out")
            return
        self.orders[fact.key], self.texts[fact.key] = order, text
        self.next_ns[fact.key] = at_ns
        self._of[order.author].add(fact.key)
        if at_ns is not None:
            self._put(at_ns, fact.key)

    def _leave(self, author: PrincipalId, key: str) -> None:
        keys = self._of[author]
        keys.discard(key)
        if not keys:
            del self._of[author]

    def _put(self, at_ns: int, key: str) -> None:
        if len(self._times) > 2 * len(self.orders) + STALE_AT_MOST:
            self._times = [(ns, k) for k, ns in self.next_ns.items() if ns is not None]
            heapify(self._times)
        else:
            heappush(self._times, (at_ns, key))

    def next_key(self) -> str:
        """Return a number that nothing here has had."""
        return str(self._last + 1)

    def of(self, who: PrincipalId) -> tuple[str, ...]:
        """Return the numbers of what somebody has planned, in the order of their times."""
        keys = self._of.get(who, ())
        return tuple(sorted(keys, key=lambda key: (self.next_ns[key] or 0, int(key))))

    def authors(self) -> tuple[PrincipalId, ...]:
        """Return who has planned anything."""
        return tuple(self._of)

    def end(self, key: str) -> Fact:
        """Return what ends one."""
        return Fact(kind=KIND, key=key, body=b"")

    def end_all(self, who: PrincipalId) -> tuple[Fact, ...]:
        """Return what ends everything of somebody."""
        return tuple(map(self.end, self.of(who)))

    def drop(self, who: PrincipalId) -> int:
        """Let nothing of somebody begin any more, at once, and write that down soon.

        Returns:
            How many that were.
        """
        facts = self.end_all(who)
        for fact in facts:
            self.apply(fact)
        self._behind.write(facts)
        return len(facts)

    def over(self, due: OrderOccurrence) -> None:
        """Note that one that was due is over, as far as it will be. Its times go on."""
        order = self.orders.get(due.key)
        if (
            order is not None
            and order.begun_ns == due.at_ns
            and order.given_ns == due.order.given_ns
        ):
            self._changes.note((self._waits_again(due.key),))

    def settle(self) -> list[OrderOccurrence]:
        """Return what was under way when the last run ended; it is over."""
        found = [
            OrderOccurrence(key, order, self.texts[key], order.begun_ns)
            for key, order in self.orders.items()
            if order.begun_ns
        ]
        for due in found:
            self.over(due)
        return found

    def _waits_again(self, key: str) -> Fact:
        if self.next_ns[key] is None:
            return self.end(key)
        return fact_of(key, replace(self.orders[key], begun_ns=0), self.texts[key])

    # ---- while it runs ----

    def run(self, handler: OccurrenceHandler) -> None:
        """Begin what is due from now on."""
        self._handler = handler
        self.look()

    def look(self) -> None:
        """Wait, if there is something to wait for."""
        if self._handler is not None and self.orders and self._waiting is None:
            self._waiting = asyncio.create_task(self._wait())

    async def _wait(self) -> None:
        try:
            while self.orders and self._handler is not None:
                try:
                    await self._give(self._handler)
                except RecordUnavailable:
                    log.warning("planned orders wait while nothing can be written down")
                await self._clock.sleep(LOOK_S)
        finally:
            self._waiting = None

    async def _give(self, handler: OccurrenceHandler) -> None:
        """Begin what is due; what could not begin in time is over, and is said."""
        keys = self._due()
        try:
            now_ns = self._clock.wall_ns()
            for key in keys:
                due = self._now(key)
                if due is not None and now_ns - due.at_ns > due.order.lives_ns:
                    self._changes.note((self._passed(due),))
                    handler.missed(due)
            if not keys:
                return
            async with self._changes.turn() as turn:
                found = [due for due in map(self._now, keys) if due is not None]
                records = [record for due in found for record in self._begun(due)]
                await turn.write(records)
            for due in found:
                handler.begin(due)
        finally:
            for key in keys:
                if (at_ns := self.next_ns.get(key)) is not None:
                    self._put(at_ns, key)

    def _due(self) -> list[str]:
        """Take out what is due; only what is next is looked at, however many wait."""
        now_ns, found = self._clock.wall_ns(), dict[str, None]()
        while self._times and self._times[0][0] <= now_ns and len(found) < AT_ONCE:
            at_ns, key = heappop(self._times)
            if self.next_ns.get(key) == at_ns:
                found[key] = None
        return list(found)

    def _now(self, key: str) -> OrderOccurrence | None:
        """Return one that is due still: nobody has taken it back meanwhile."""
        at_ns, order = self.next_ns.get(key), self.orders.get(key)
        if order is None or at_ns is None or at_ns > self._clock.wall_ns():
            return None
        return OrderOccurrence(key, order, self.texts[key], at_ns)

    def _passed(self, due: OrderOccurrence) -> Fact:
        now_ns = self._clock.wall_ns()  # of what was slept through again and again, once is said
        order = replace(due.order, after_ns=max(due.at_ns, now_ns - due.order.lives_ns - 1))
        if order.when.after(order.after_ns) is None:
            return self.end(due.key)
        return fact_of(due.key, order, due.text)

    def _begun(self, due: OrderOccurrence) -> tuple[Decided, Fact]:
        order = replace(due.order, after_ns=due.at_ns, begun_ns=due.at_ns)
        now_ns = self._clock.wall_ns()
        decided = Decided(act="scheduled-run", by=order.author, about=due.key, at_ns=now_ns)
        return decided, fact_of(due.key, order, due.text)

    async def close(self) -> None:
        """Begin nothing any more."""
        self._handler = None
        if self._waiting is not None:
            self._waiting.cancel()
            await asyncio.gather(self._waiting, return_exceptions=True)
        await self._behind.written()


def fact_of(key: str, order: ScheduledOrder, text: ScheduledText) -> Fact:
    """Return what keeps an order that waits for its time."""
    return Fact(kind=KIND, key=key, body=_encode(order), letter=Letter(order.author, _encode(text)))
