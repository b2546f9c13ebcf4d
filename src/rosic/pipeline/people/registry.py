"""What the clerks of people share, as the composition root made it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable

import msgspec

from rosic.authoriser.authoriser import Authoriser
from rosic.authoriser.enrolment import Enrolment
from rosic.authoriser.keys import KeyRing
from rosic.authoriser.locks import Locks
from rosic.authoriser.security import Security
from rosic.authoriser.stepup import StepUp
from rosic.contracts.clock import Clock
from rosic.core.identity import PrincipalId
from rosic.core.record import Record
from rosic.core.rights import Rights
from rosic.organiser.roster import Roster
from rosic.pipeline.changes import Changes
from rosic.pipeline.reach import Reach
from rosic.pipeline.retracting import Retracting


class Registry(msgspec.Struct, frozen=True, kw_only=True):
    """The rooms' objects that know people, and the two ways to change and to reach them.

    Attributes:
        rights: Returns the snapshot in force.
        retracting: Takes away what held a secret.
        ahead: Returns what takes away what somebody still had to come: times, queues and wishes.
        ended: Ends what somebody has in hand: leases and motion. Called when their lock or their
            revocation is in force already, and outside of any turn.
    """

    authoriser: Authoriser
    enrolment: Enrolment
    keys: KeyRing
    locks: Locks
    stepup: StepUp
    security: Security
    roster: Roster
    changes: Changes
    reach: Reach
    clock: Clock
    rights: Callable[[], Rights]
    ahead: Callable[[PrincipalId], Iterable[Record]]
    ended: Callable[[PrincipalId], Awaitable[object]]
    retracting: Retracting

    def name(self, principal: PrincipalId) -> str:
        """Return how somebody is shown."""
        return self.authoriser.directory.name(principal)
