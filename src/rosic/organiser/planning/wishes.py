"""Who would like a robot for a while, until a plan is made of all wishes together."""

from __future__ import annotations

import logging
from collections import defaultdict
from contextlib import suppress
from hashlib import blake2b
from typing import TYPE_CHECKING

import msgspec

from rosic.core.i18n import said, said_n
from rosic.core.identity import REQUEST_ID_BYTES, PrincipalId
from rosic.core.records import Fact
from rosic.core.robot.profile import RobotId
from rosic.core.time_units import HOUR_S, MINUTE_NS, SECOND_NS
from rosic.errors import NotUnderstood, OutOfBounds, TooManyRequests
from rosic.organiser.calendar_messages import length
from rosic.organiser.planning.problem import PRIORITIES, Wish

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.organiser.planning.problem import Span


# ---- sentences ----


def window_too_short(length_s: int) -> OutOfBounds:
    """Say that nothing that long fits."""
    return OutOfBounds(said("The window is shorter than {length}.", length=length(length_s)))


def window_over() -> OutOfBounds:
    """Say that it is too late for this."""
    return OutOfBounds(said("That window is over."))


def no_such_priority(least: int, most: int) -> OutOfBounds:
    """Say which numbers there are."""
    return OutOfBounds(
        said("A priority is a number from {least} to {most}.", least=least, most=most)
    )


def enough(most: int) -> str:
    """Say that somebody has as many wishes as one person may."""
    return said_n(
        "You have {n} wish already, and more are not possible. /wish off 1 takes it back.",
        "You have {n} wishes already, and more are not possible. /wish off 1 takes one back.",
        most,
    )


def all_enough(most: int) -> str:
    """Say that there are as many as are planned at a time."""
    return said("There are {most} wishes already. An admin has to make a plan first.", most=most)


def no_such_wish(count: int) -> str:
    """Say which numbers there are."""
    if not count:
        return said("You have no wishes.")
    return said_n(
        "You have {n} wish. Say its number: /wish off 1",
        "You have {n} wishes. Say the number of one: /wish off 1",
        count,
    )


# ---- the list of wishes ----

WISH = "wish"
MOST_EACH = 10
MOST_OF_ALL = 300

log = logging.getLogger("rosic.organiser")


class RecordedWish(msgspec.Struct, frozen=True, kw_only=True):
    """The body of the fact; its key is the id. Ids and numbers only.

    Attributes:
        number: Grows with each wish; the lowest came first.
        robots: Any one of these will do.
        earliest_ns: Wall clock; the time begins then at the earliest.
        latest_ns: Wall clock; the time is over by then.
        priority: 1 (ordinary) to 5, as its person says.
    """

    id: str
    number: int
    principal: PrincipalId
    robots: tuple[RobotId, ...]
    length_s: int
    earliest_ns: int
    latest_ns: int
    priority: int = PRIORITIES[0]

    def fact(self) -> Fact:
        """Return it as it is written down."""
        return Fact(kind=WISH, key=self.id, body=msgspec.msgpack.encode(self))

    def no_more(self) -> Fact:
        """Return what is written down when it is served, taken back or over."""
        return Fact(kind=WISH, key=self.id, body=b"")

    def over(self, now_ns: int) -> bool:
        """Whether nothing that long fits into what is left of the window."""
        return self.latest_ns - self.length_s * SECOND_NS < _full_minute(now_ns)

    def wish(self, robots: tuple[RobotId, ...], now_ns: int) -> Wish:
        """Return it as a part of a problem, from now on."""
        return Wish(
            id=self.id,
            principal=self.principal,
            robots=robots,
            length_s=self.length_s,
            earliest_ns=max(self.earliest_ns, _full_minute(now_ns)),
            latest_ns=self.latest_ns,
            priority=self.priority,
        )


_decode = msgspec.msgpack.Decoder(RecordedWish).decode


class Wishes:
    """All that are not over; bounded for each person and in all.

    Args:
        wall_ns: Returns the wall clock that never goes back.
    """

    def __init__(self, wall_ns: Callable[[], int]) -> None:
        self._wall_ns = wall_ns
        self._known: dict[str, RecordedWish] = {}
        self._of: defaultdict[PrincipalId, set[str]] = defaultdict(set)
        self._number = 0

    # ---- state ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. What cannot be read is forgotten: it gives nobody anything."""
        old = self._known.pop(fact.key, None)
        if old is not None:
            self._of[old.principal].discard(old.id)
        if not fact.body:
            return
        try:
            found = _decode(fact.body)
        except msgspec.MsgspecError:
            log.warning("a wish cannot be read; whoever had it has to say it again")
            return
        self._known[fact.key] = found
        self._of[found.principal].add(found.id)
        self._number = max(self._number, found.number)

    def of(self, principal: PrincipalId) -> tuple[RecordedWish, ...]:
        """Return somebody's wishes that are not over, as they came."""
        return self._ordered(self._known[key] for key in self._of.get(principal, ()))

    def everybodys(self) -> tuple[RecordedWish, ...]:
        """Return every wish that is not over, as they came."""
        return self._ordered(self._known.values())

    def get(self, wish: str) -> RecordedWish | None:
        """Return one by its id, even if it is over."""
        return self._known.get(wish)

    def _ordered(self, some: Iterable[RecordedWish]) -> tuple[RecordedWish, ...]:
        now_ns = self._wall_ns()
        return tuple(sorted((w for w in some if not w.over(now_ns)), key=lambda w: w.number))

    # ---- deciding ----

    def put(
        self,
        principal: PrincipalId,
        robots: tuple[RobotId, ...],
        length_s: int,
        window: Span,
        priority: int = PRIORITIES[0],
    ) -> tuple[Fact, ...]:
        """Decide on one more wish; the first fact is it, others forget what is over.

        Raises:
            OutOfBounds: The window is over, or too short for it; or there is no such priority.
            TooManyRequests: The person has enough, or all together do.
        """
        now_ns = self._wall_ns()
        earliest_ns, latest_ns = window
        number = self._number + 1
        digest = blake2b(ascii((principal, number, now_ns)).encode(), digest_size=REQUEST_ID_BYTES)
        wished = RecordedWish(
            id=digest.hexdigest(),
            number=number,
            principal=principal,
            robots=robots,
            length_s=length_s,
            earliest_ns=earliest_ns,
            latest_ns=latest_ns,
            priority=priority,
        )
        if priority not in PRIORITIES:
            raise no_such_priority(PRIORITIES[0], PRIORITIES[-1])
        if length_s * SECOND_NS > latest_ns - earliest_ns:
            raise window_too_short(length_s)
        if wished.over(now_ns):
            raise window_over()
        if len(self.of(principal)) >= MOST_EACH:
            raise TooManyRequests(enough(MOST_EACH), retry_after_s=float(HOUR_S))
        if len(self.everybodys()) >= MOST_OF_ALL:
            raise TooManyRequests(all_enough(MOST_OF_ALL), retry_after_s=float(HOUR_S))
        return (wished.fact(), *self.outdated())

    def off(self, principal: PrincipalId, place: int) -> tuple[RecordedWish, tuple[Fact, ...]]:
        """Decide on taking one back, by its place in the person's list, from 1.

        Raises:
            NotUnderstood: There is no such place.
        """
        mine = self.of(principal)
        if not 0 < place <= len(mine):
            raise NotUnderstood(no_such_wish(len(mine)), offers=("wish",))
        return mine[place - 1], (mine[place - 1].no_more(), *self.outdated())

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what forgets every wish of somebody who leaves."""
        return tuple(self._known[key].no_more() for key in sorted(self._of.get(principal, ())))

    def outdated(self) -> tuple[Fact, ...]:
        """Return what forgets wishes whose window is over."""
        now_ns = self._wall_ns()
        return tuple(wished.no_more() for wished in self._known.values() if wished.over(now_ns))


def place_of(text: str) -> int:
    """Return the number that somebody said; 0 for what is none."""
    with suppress(ValueError):
        return int(text) if text.isascii() and len(text) < len("1000") else 0
    return 0


def _full_minute(at_ns: int) -> int:
    return -(-at_ns // MINUTE_NS) * MINUTE_NS
