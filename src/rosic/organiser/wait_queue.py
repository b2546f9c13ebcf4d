"""Who waits for a robot, in which order, and whose turn it is now.

The queue is written down; an offer is not. It lives a minute on the monotonic clock, and after a
restart the first in line is simply asked again.
"""

from __future__ import annotations

import logging
from bisect import insort
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from rosic.core.i18n import said
from rosic.core.identity import PrincipalId
from rosic.core.records import Fact
from rosic.core.robot.profile import RobotId
from rosic.core.slot import read_fact
from rosic.core.time_units import SECOND_NS
from rosic.errors import Expired, OutOfBounds, RobotTaken
from rosic.organiser.calendar_messages import moment

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.contracts.clock import Clock
    from rosic.organiser.timezones import Zone


# ---- sentences ----


def queue_full(shown: str, people: int) -> str:
    """No more may wait."""
    return said(
        "{people} people wait for {shown} already. Book a time instead.", people=people, shown=shown
    )


def waits_enough(most: int) -> str:
    """The person is in too many queues."""
    return said("You wait for {most} robots already. Leave one of these queues first.", most=most)


def turn_over(shown: str) -> str:
    """An offer was not taken in time."""
    return said("Your turn with {shown} has passed on. Say wait to queue again.", shown=shown)


def not_your_turn(shown: str, place: int) -> str:
    """Somebody takes what was not offered to them.

    Args:
        shown: The robot's title.
        place: 0 if they do not wait.
    """
    if not place:
        return said("You are not waiting for {shown}.", shown=shown)
    return said(
        "{shown} is offered to somebody else now. You are number {place} in the queue.",
        shown=shown,
        place=place,
    )


def your_turn(shown: str, offer_s: float) -> str:
    """The offer itself."""
    return said(
        "{shown} is free and it is your turn. Tap within {offer_s:.0f} s to take it.",
        shown=shown,
        offer_s=offer_s,
    )


def your_place(shown: str, place: int, about_ns: int, now_ns: int, zone: Zone) -> str:
    """Where somebody stands, and about when it is their turn."""
    if about_ns <= now_ns:
        return said("You are number {place} in the queue for {shown}.", place=place, shown=shown)
    about = moment(about_ns, now_ns, zone)
    return said(
        "You are number {place} in the queue for {shown}: about {about}.",
        place=place,
        shown=shown,
        about=about,
    )


# ---- the queue ----

WAITING = "waiting"

log = logging.getLogger("rosic.organiser")


class QueueEntry(msgspec.Struct, frozen=True, gc=False, kw_only=True):
    """Somebody waits for a robot.

    Attributes:
        number: Grows with each who joins; the lowest is next.
        since_ns: Wall clock.
    """

    robot: RobotId
    principal: PrincipalId
    number: int
    since_ns: int

    @property
    def key(self) -> str:
        """Once per robot and person."""
        return f"{self.robot} {self.principal}"

    def fact(self) -> Fact:
        """Return it as it is written down."""
        return Fact(kind=WAITING, key=self.key, body=msgspec.msgpack.encode(self))

    def no_more(self) -> Fact:
        """Return what is written down when they wait no longer."""
        return Fact(kind=WAITING, key=self.key, body=b"")


class WaitingLimits(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How many may wait, and how long a turn is held for somebody.

    Attributes:
        offer_s: After this the turn goes to the next.
        usual_s: How long somebody is expected to keep a robot, for estimates.
        most_per_robot: So many people in one queue.
        most_per_person: So many queues with one person in them.
    """

    offer_s: float = 60.0
    usual_s: int = 1800
    most_per_robot: int = 50
    most_per_person: int = 10


class TurnOffer(msgspec.Struct, frozen=True):
    """It is somebody's turn, for a while.

    Attributes:
        expires_ns: Monotonic clock.
    """

    robot: RobotId
    principal: PrincipalId
    expires_ns: int


class WaitingList:
    """The queues of all robots.

    Attributes:
        shown_of: A robot's title, for sentences.
    """

    def __init__(
        self, clock: Clock, shown_of: Callable[[RobotId], str], limits: WaitingLimits | None = None
    ) -> None:
        self.limits = limits or WaitingLimits()
        self.shown_of = shown_of
        self._clock = clock
        self._keys: dict[str, QueueEntry] = {}
        self._queues: dict[RobotId, list[QueueEntry]] = {}
        self._offers: dict[RobotId, TurnOffer] = {}
        self._passed: dict[RobotId, set[PrincipalId]] = {}

    # ---- what is so ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Start from what was written down; what cannot be read is logged and left out."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Make one fact so, once it is written down. Doing it twice changes nothing more."""
        if fact.kind != WAITING:
            return
        old = self._keys.get(fact.key)
        new = _read(fact) if fact.body else None
        if new == old or (fact.body and new is None):
            return
        if old is not None:
            self._take(old)
        if new is not None:
            self._keys[new.key] = new
            insort(self._queues.setdefault(new.robot, []), new, key=_number)

    def _take(self, waiting: QueueEntry) -> None:
        robot, principal = waiting.robot, waiting.principal
        del self._keys[waiting.key]
        self._queues[robot].remove(waiting)
        if not self._queues[robot]:
            del self._queues[robot]
        self._passed.get(robot, set()).discard(principal)
        if (offer := self._offers.get(robot)) is not None and offer.principal == principal:
            del self._offers[robot]

    # ---- deciding ----

    def join(self, principal: PrincipalId, robot: RobotId) -> tuple[Fact, ...]:
        """Decide on waiting at the end of a queue. Who is in it keeps their place: nothing to do.

        Raises:
            OutOfBounds: The queue is full, or the person waits in too many.
        """
        queue = self.queue(robot)
        if principal in queue:
            return ()
        if len(queue) >= self.limits.most_per_robot:
            raise OutOfBounds(queue_full(self.shown_of(robot), len(queue)))
        if len(self.waits_for(principal)) >= self.limits.most_per_person:
            raise OutOfBounds(waits_enough(self.limits.most_per_person))
        last = self._queues[robot][-1].number if queue else 0
        waiting = QueueEntry(
            robot=robot, principal=principal, number=last + 1, since_ns=self._clock.wall_ns()
        )
        return (waiting.fact(),)

    def leave(self, principal: PrincipalId, robot: RobotId) -> tuple[Fact, ...]:
        """Return what takes somebody out of a queue; nothing if they are not in it."""
        return tuple(
            waiting.no_more()
            for waiting in self._queues.get(robot, ())
            if waiting.principal == principal
        )

    def leave_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what takes somebody who is locked or leaves out of every queue."""
        return tuple(w.no_more() for w in self._keys.values() if w.principal == principal)

    def offer(self, robot: RobotId) -> TurnOffer | None:
        """Return whose turn it is: the standing offer, or a new one to the first in line.

        Whoever let theirs expire is passed over; `lapsed` says who, to take them out.
        """
        now_ns = self._clock.monotonic_ns()
        standing = self._offers.get(robot)
        if standing is not None and now_ns < standing.expires_ns:
            return standing
        if standing is not None:
            self._passed.setdefault(robot, set()).add(standing.principal)
            del self._offers[robot]
        passed = self._passed.get(robot, set())
        following = next((p for p in self.queue(robot) if p not in passed), None)
        if following is None:
            return None
        made = TurnOffer(robot, following, now_ns + int(self.limits.offer_s * SECOND_NS))
        self._offers[robot] = made
        return made

    def standing(self, robot: RobotId) -> TurnOffer | None:
        """Return the offer that stands, if one does."""
        offer = self._offers.get(robot)
        return offer if offer and self._clock.monotonic_ns() < offer.expires_ns else None

    def take(self, principal: PrincipalId, robot: RobotId) -> tuple[Fact, ...]:
        """Decide on somebody taking the turn that was offered to them: they wait no longer.

        Raises:
            Expired: Their minute is over.
            RobotTaken: It is not their turn. They keep their place.
        """
        standing = self._offers.get(robot)
        offered = standing is not None and standing.principal == principal
        over = standing is not None and self._clock.monotonic_ns() >= standing.expires_ns
        if (offered and over) or principal in self._passed.get(robot, ()):
            raise Expired(turn_over(self.shown_of(robot)), offers=(f"wait {robot}",))
        if not offered:
            raise RobotTaken(not_your_turn(self.shown_of(robot), self.place(principal, robot)))
        return self.leave(principal, robot)

    def withdraw(self, robot: RobotId) -> None:
        """Take an offer back, because the robot is not free after all; nobody loses a place."""
        self._offers.pop(robot, None)

    def age(self, ns: int) -> None:
        """Make every offer older: so much time has passed that the monotonic clock missed."""
        self._offers = {
            robot: replace(offer, expires_ns=offer.expires_ns - ns)
            for robot, offer in self._offers.items()
        }

    def lapsed(self) -> tuple[QueueEntry, ...]:
        """Return who let their turn pass; write ``no_more()`` of each, apply it, and tell them."""
        now_ns = self._clock.monotonic_ns()
        passed = [(robot, p) for robot, people in self._passed.items() for p in sorted(people)]
        passed += [(o.robot, o.principal) for o in self._offers.values() if o.expires_ns <= now_ns]
        keys = (f"{robot} {principal}" for robot, principal in passed)
        return tuple(self._keys[key] for key in keys if key in self._keys)

    def next_expiry_ns(self) -> int | None:
        """Return when the next offer expires, monotonic clock."""
        return min((offer.expires_ns for offer in self._offers.values()), default=None)

    # ---- looking ----

    def wanted(self) -> tuple[RobotId, ...]:
        """Return the robots that somebody waits for."""
        return tuple(self._queues)

    def queue(self, robot: RobotId) -> tuple[PrincipalId, ...]:
        """Return who waits for a robot, the next one first."""
        return tuple(waiting.principal for waiting in self._queues.get(robot, ()))

    def waits_for(self, principal: PrincipalId) -> tuple[RobotId, ...]:
        """Return which robots somebody waits for; looks once into each queue."""
        return tuple(r for r in self._queues if f"{r} {principal}" in self._keys)

    def place(self, principal: PrincipalId, robot: RobotId) -> int:
        """Return somebody's place, 1 being next; 0 if they do not wait."""
        queue = self.queue(robot)
        return queue.index(principal) + 1 if principal in queue else 0

    def estimate_ns(self, principal: PrincipalId, robot: RobotId, free_ns: int) -> int | None:
        """Return about when it is somebody's turn, wall clock; None if they do not wait.

        Args:
            principal: Who waits.
            robot: For which.
            free_ns: When it is free next: `Calendar.next_free`.
        """
        place = self.place(principal, robot)
        return free_ns + (place - 1) * self.limits.usual_s * SECOND_NS if place else None


def _number(waiting: QueueEntry) -> tuple[int, int]:
    return waiting.number, waiting.since_ns


def _read(fact: Fact) -> QueueEntry | None:
    try:
        waiting = read_fact(fact, QueueEntry)
    except ValueError:
        log.warning("a place in a queue that was written down cannot be read; left out")
        return None
    return waiting if waiting.key == fact.key else None
