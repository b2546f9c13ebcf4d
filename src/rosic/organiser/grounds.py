"""What counts for a decision besides the rights: of one request, and of everybody's access."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import msgspec

from rosic.contracts.clock import Clock
from rosic.core.identity import KeyId, PrincipalId
from rosic.core.policy.roles import Assurance

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from rosic.core.policy.query import PolicyKey
    from rosic.core.robot.profile import RobotId


class AuthContext(msgspec.Struct, frozen=True, kw_only=True):
    """What counts for one request.

    Attributes:
        channel: What the conversation is worth.
        stepped_up: A second factor was shown lately, in this chat.
        confirmed: This very request was confirmed by a tap.
        second: Who else has agreed to this very request.
    """

    channel: Assurance = Assurance.PROVIDER_READABLE
    stepped_up: bool = False
    confirmed: bool = False
    second: PrincipalId | None = None


NOTHING = AuthContext()


class CheckedClock(Clock, Protocol):
    """A clock that knows when the machine's was set back.

    Attributes:
        behind: It was, and nobody has said yet that it is right: nothing new moves.
    """

    behind: bool


class AccessState(NamedTuple):
    """What the authoriser keeps and the organiser decides by: live views, never copies.

    Attributes:
        clock: By which rights, slots and leases end.
        key_of: Returns a key as deciding sees it; None: there is none.
        narrow: Keys that reach less than their principal's rights.
        locked: Who is locked.
        own_limits: Returns what somebody has set for themselves, as the texts of limits.
        locked_out: Hears of whoever was turned away because they are locked.
        released: Hears of a robot that was taken from whoever had it: what has not begun yet is to
            be admitted once more.
    """

    clock: CheckedClock
    key_of: Callable[[KeyId], PolicyKey | None]
    narrow: Collection[KeyId]
    locked: Collection[PrincipalId]
    own_limits: Callable[[PrincipalId], tuple[str, ...]]
    locked_out: Callable[[PrincipalId], object]
    released: Callable[[RobotId], object]
