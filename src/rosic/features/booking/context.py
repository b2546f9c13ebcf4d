"""What the handlers and the keeper of times work with, as the composition root made it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from hashlib import blake2b
from typing import TYPE_CHECKING, TypeAlias

import msgspec

from rosic.contracts.clock import Clock
from rosic.core.identity import DIGEST_BYTES, PrincipalId
from rosic.core.language import Vocabulary, VocabularyHolder
from rosic.core.lease import Lease
from rosic.core.message import Chat
from rosic.core.records import Decided, Fact
from rosic.core.robot.profile import RobotId
from rosic.core.slot import BookedSlot
from rosic.errors import Refusal
from rosic.gateway.delivery.notifier import Notifier
from rosic.gateway.transactions import Transactions
from rosic.organiser.calendar import Calendar
from rosic.organiser.planning.wishes import Wishes
from rosic.organiser.timezones import Zone
from rosic.organiser.wait_queue import WaitingList

if TYPE_CHECKING:
    from rosic.core.records import Record


# ---- what booking works with ----

Handover: TypeAlias = Callable[[RobotId, str], Awaitable[bool]]


class BookingQueries(msgspec.Struct, frozen=True, kw_only=True):
    """What other rooms say, each as a question; none of them waits for anything but `handover`.

    Attributes:
        visible: The robots that somebody may see.
        may_book: Why somebody may not move a robot at all, whatever the time; None if they may.
        right_ends_ns: When somebody's right to a robot ends, wall clock; None: it does not.
        may_cancel_any: Whether somebody may cancel other people's times with a robot.
        selected: The robot or group that somebody chose in a chat; empty for none.
        zone_of: Where somebody reads times.
        lease: A robot's lease; it is kept for whoever's turn it is.
        ready: Whether a robot is there and not stopped.
        handover: End what a robot does, measure rest, release its lease; the string says why, as
            it stands in the outcome of an order. False: rest was not confirmed, and the robot is
            stopped until somebody who may resumes it: not `ready`.
        barred: Why a robot must stay stopped, whoever resumes it; None if it need not.
        may_resume: Whether somebody could resume a robot now.
        may_stay: Whether a holder may go on in another's slot: a senior who took over.
    """

    visible: Callable[[PrincipalId], frozenset[RobotId]]
    may_book: Callable[[PrincipalId, RobotId], Refusal | None]
    may_cancel_any: Callable[[PrincipalId, RobotId], bool]
    selected: Callable[[PrincipalId, Chat], str]
    zone_of: Callable[[PrincipalId], Zone]
    lease: Callable[[RobotId], Lease]
    ready: Callable[[RobotId], bool]
    handover: Handover
    barred: Callable[[RobotId], Refusal | None]
    may_resume: Callable[[PrincipalId, RobotId], bool]
    may_stay: Callable[[PrincipalId, BookedSlot], bool]
    right_ends_ns: Callable[[PrincipalId, RobotId], int | None]


class BookingContext(msgspec.Struct, frozen=True, kw_only=True):
    """The calendar, the queues, and everything around them.

    Attributes:
        lease_idle_s: How long a robot stays somebody's after their last order.
        idle_release_s: After so long without an order a slot is given to whoever waits.
        notice_s: So long before that its owner is asked.
    """

    calendar: Calendar
    waiting: WaitingList
    wishes: Wishes
    vocabularies: VocabularyHolder
    changes: Transactions
    reach: Notifier
    clock: Clock
    sides: BookingQueries
    lease_idle_s: float = 60.0
    idle_release_s: float = 900.0
    notice_s: float = 60.0

    @property
    def vocabulary(self) -> Vocabulary:
        """What can be said now; not to be kept, as it may be replaced."""
        return self.vocabularies.current

    def shown(self, robot: RobotId) -> str:
        """Return a robot's title."""
        return self.calendar.shown_of(robot)

    def upcoming(self, principal: PrincipalId) -> tuple[BookedSlot, ...]:
        """Return somebody's slots that are not over, in order."""
        now_ns = self.clock.wall_ns()
        return tuple(slot for slot in self.calendar.of(principal) if slot.end_ns > now_ns)


# ---- changes on record ----


def decided(act: str, by: PrincipalId, at_ns: int, facts: tuple[Fact, ...]) -> tuple[Record, ...]:
    """Return facts with who decided them before them; the first fact is what it is about."""
    digest = blake2b(digest_size=DIGEST_BYTES)
    for fact in facts:
        digest.update(ascii((fact.kind, fact.key)).encode())
        digest.update(fact.body)
    about = facts[0].key
    return (Decided(act=act, by=by, about=about, at_ns=at_ns, digest=digest.digest()), *facts)
