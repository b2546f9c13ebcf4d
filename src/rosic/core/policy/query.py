"""A question of authority, all that its answer rests on, and the answer."""

from __future__ import annotations

import enum
from collections.abc import Collection, Mapping
from typing import TypeAlias

import msgspec

from rosic.core.identity import KeyId, PrincipalId
from rosic.core.policy.compiled import RightReason
from rosic.core.policy.limits import Limit
from rosic.core.policy.permissions import Permissions
from rosic.core.policy.roles import Assurance, Grant, StepRequired
from rosic.core.policy.scope import Scope
from rosic.core.robot.profile import RobotId
from rosic.core.robot.skill import Argument
from rosic.core.slot import BookedSlot, SlotRule

STOP = "stop"


class PolicyRule(enum.Enum):
    """One of the rules of `rosic.core.policy.evaluate`, in the order in which they are asked."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    KEY = "key"
    LOCK = "lock"
    SIGHT = "sight"
    REACH = "reach"
    RIGHT = "right"
    CHANNEL = "channel"
    LIMITS = "limits"
    STOPPED = "stopped"
    SLOT = "slot"
    LEASE = "lease"
    CARE = "care"


class PolicyCode(enum.Enum):
    """Why not: stable, for sentences, logs and tests."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    KEY_UNKNOWN = "key-unknown"
    KEY_REVOKED = "key-revoked"
    KEY_EXPIRED = "key-expired"
    LOCKED = "locked"
    NO_SUCH_ROBOT = "no-such-robot"
    KEY_TOO_NARROW = "key-too-narrow"
    NOT_GRANTED = "not-granted"
    RIGHT_ENDED = "right-ended"
    CHANNEL_TOO_WEAK = "channel-too-weak"
    OVER_LIMIT = "over-limit"
    ROBOT_STOPPED = "robot-stopped"
    SLOT_NEEDED = "slot-needed"
    SLOT_TAKEN = "slot-taken"
    ROBOT_TAKEN = "robot-taken"


class PolicyKey(msgspec.Struct, frozen=True, gc=False, kw_only=True):
    """An authorisation key as deciding sees it.

    Attributes:
        expires_ns: Wall clock; it is no good from then on.
        scopes: It reaches only these; empty: wherever the person's rights do.
    """

    id: KeyId
    principal: PrincipalId
    expires_ns: int | None = None
    revoked: bool = False
    scopes: tuple[Scope, ...] = ()


class Query(msgspec.Struct, frozen=True, kw_only=True):
    """What somebody wants to do.

    Attributes:
        key: Id of the key that the request carries.
        arguments: SI; None while they are not complete.
        channel: What the conversation is worth.
    """

    principal: PrincipalId
    key: KeyId
    robot: RobotId
    skill: str
    arguments: Mapping[str, Argument] | None = None
    channel: Assurance = Assurance.PROVIDER_READABLE


class PolicyState(msgspec.Struct, frozen=True, kw_only=True):
    """Everything that a decision rests on.

    Attributes:
        key: The record of the key that the request carries; None: there is none.
        locked: Ids of everybody who is locked.
        now_ns: Wall clock.
        stopped: The robot is latched.
        holder: Who has the robot's lease now; None: nobody.
        holder_until_ns: When that would end; None: not known.
        slots: What slots mean for the robot.
        slot: The slot that is now, whosever; one that is not now counts as none.
        next_free_ns: When the person could have the robot next, if that is known.
        stepped_up: They have shown their second factor, and it still counts.
        confirmed: They have confirmed this very request.
        second: Who else has agreed to this very request.
    """

    rights: Permissions
    key: PolicyKey | None
    now_ns: int
    locked: Collection[PrincipalId]
    stopped: bool
    holder: PrincipalId | None
    slots: SlotRule
    slot: BookedSlot | None
    holder_until_ns: int | None = None
    next_free_ns: int | None = None
    stepped_up: bool = False
    confirmed: bool = False
    second: PrincipalId | None = None


class Allow(msgspec.Struct, frozen=True, kw_only=True):
    """They may, once ``needs`` is empty.

    Attributes:
        rules: Asked, in order.
        way, grant: What made it; None for a stop.
        needs: What still has to come first.
        care: Everything that the skill asks for, done or not.
        preempts: From whom the robot is taken over; each once, the slot's owner first.
        unchecked: Limits that have to be asked again once the arguments are complete.
        priority: Of the right they act under.
    """

    ask: Query
    rules: tuple[PolicyRule, ...]
    way: RightReason | None = None
    grant: Grant | None = None
    needs: tuple[StepRequired, ...] = ()
    care: tuple[StepRequired, ...] = ()
    preempts: tuple[PrincipalId, ...] = ()
    unchecked: tuple[Limit, ...] = ()
    priority: int = 0

    @property
    def until_ns(self) -> int | None:
        """Return when the grant ends, wall clock; None: it does not."""
        return None if self.grant is None else self.grant.expires_ns


class Deny(msgspec.Struct, frozen=True, kw_only=True):
    """They may not. Facts for the sentence; what is unknown or not theirs to know is left out.

    Attributes:
        rules: Asked, in order; the last one refused.
        who: Up to three people who can help.
        when_ns: Wall clock: from when it may be possible, or when something ended.
        holder: Who has the robot, or its slot.
        limit: The limit that was broken.
        channel: What the conversation would have to be worth.
        roles: Roles that would give the right, the least of them first.
        way, grant: What would have made it; None if nothing does.
    """

    ask: Query
    code: PolicyCode
    rules: tuple[PolicyRule, ...]
    who: tuple[PrincipalId, ...] = ()
    when_ns: int | None = None
    holder: PrincipalId | None = None
    limit: Limit | None = None
    channel: Assurance | None = None
    roles: tuple[str, ...] = ()
    way: RightReason | None = None
    grant: Grant | None = None

    @property
    def rule(self) -> PolicyRule:
        """Return the rule that refused."""
        return self.rules[-1]


Decision: TypeAlias = Allow | Deny


# ---- what counts besides rights ----


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
