"""What the handlers of people share, as the composition root made it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable

import msgspec

from rosic.authoriser.account_links import AccountLinks
from rosic.authoriser.authoriser import Authoriser
from rosic.authoriser.enrolment import Enrolment
from rosic.authoriser.keys import KeyRing
from rosic.authoriser.locks import AccountLocks
from rosic.authoriser.security_report import SecurityReports
from rosic.authoriser.two_factor import TwoFactor
from rosic.contracts.clock import Clock
from rosic.core.identity import PrincipalId
from rosic.core.policy.permissions import Permissions
from rosic.core.records import Record
from rosic.gateway.delivery.notifier import Notifier
from rosic.gateway.delivery.redaction import SecretRedaction
from rosic.gateway.transactions import Transactions
from rosic.organiser.grants import Grants


class AccessContext(msgspec.Struct, frozen=True, kw_only=True):
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
    links: AccountLinks
    keys: KeyRing
    locks: AccountLocks
    two_factor: TwoFactor
    security: SecurityReports
    grants_book: Grants
    changes: Transactions
    reach: Notifier
    clock: Clock
    rights: Callable[[], Permissions]
    ahead: Callable[[PrincipalId], Iterable[Record]]
    ended: Callable[[PrincipalId], Awaitable[object]]
    retracting: SecretRedaction

    def name(self, principal: PrincipalId) -> str:
        """Return how somebody is shown."""
        return self.authoriser.directory.name(principal)
