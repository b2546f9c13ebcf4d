"""Authority as a pure function: may this person do this with this robot, now?

The rules, in the order in which they are asked. The first that refuses decides; whatever it says,
nothing that a person may not see has been looked at before ``SIGHT``, so that a refusal about a
robot they may not read is, to the letter, that about a robot that does not exist.

=========  =========================================================================================
KEY        The request carries the person's own key, known, not taken back, not expired.
LOCK       The person is not locked. (A stop passes: it can only make things safer.)
SIGHT      A right that lives shows them the robot, and the key reaches it. A stop asks no more.
REACH      The key, if it is narrowed, reaches the skill.
RIGHT      A role or a grant that lives gives the skill.
CHANNEL    The conversation is worth what the role and the skill ask for.
LIMITS     One of the rights that are left allows these arguments; each of its limits holds.
STOPPED    The robot is not latched. This and the next two are asked only for what actuates.
SLOT       The robot's slots leave it to them now, or they may take over from the slot's owner.
LEASE      Nobody else has it, or they may take over from whoever has.
CARE       Never refuses: says what has to come first (confirmation, second factor, second person).
=========  =========================================================================================

Somebody may take over where the rulebook allows it on the robot and the priority of the right they
act under is higher than any that the other has there. While the arguments are not known yet, the
right without limits counts; if every right has limits, the one of the lowest priority does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.core.policy.limits import broken_limit
from rosic.core.policy.query import (
    STOP,
    Allow,
    Decision,
    Deny,
    PolicyCode,
    PolicyRule,
    PolicyState,
    Query,
)
from rosic.core.policy.roles import StepRequired
from rosic.core.policy.scope import FLEET, READ

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.policy.compiled import HeldGrant, RightReason
    from rosic.core.policy.permissions import Permissions
    from rosic.core.policy.roles import Grant
    from rosic.core.robot.profile import RobotId
    from rosic.core.slot import BookedSlot

RULES = tuple(PolicyRule)
_STOPPING = RULES[:3]
_STILL = (*RULES[:7], PolicyRule.CARE)
_UP_TO = {rule: RULES[: RULES.index(rule) + 1] for rule in RULES}


def decide(state: PolicyState, ask: Query) -> Decision:
    """Decide. Pure: the same state and question give the same answer."""
    denied = _key(state, ask) or _lock(state, ask) or _sight(state, ask)
    if denied is not None:
        return denied
    if ask.skill == STOP:
        return Allow(ask=ask, rules=_STOPPING)
    chosen = _choose(state, ask)
    if isinstance(chosen, Deny):
        return chosen
    way, holding = chosen
    preempts: tuple[PrincipalId, ...] = ()
    actuates = state.rights.actuates(ask.robot, ask.skill)
    if actuates:
        taken = _take(state, ask, way, holding.grant)
        if isinstance(taken, Deny):
            return taken
        preempts = taken
    care = state.rights.caution(ask.robot, ask.skill).needs
    return Allow(
        ask=ask,
        rules=RULES if actuates else _STILL,
        way=way,
        grant=holding.grant,
        needs=_outstanding(care, state, ask) if care else care,
        care=care,
        preempts=preempts,
        unchecked=way.limits if ask.arguments is None else (),
        priority=way.priority,
    )


def _key(state: PolicyState, ask: Query) -> Deny | None:
    key = state.key
    if key is None or key.id != ask.key or key.principal != ask.principal:
        code, when_ns = PolicyCode.KEY_UNKNOWN, None
    elif key.revoked:
        code, when_ns = PolicyCode.KEY_REVOKED, None
    elif key.expires_ns is not None and state.now_ns >= key.expires_ns:
        code, when_ns = PolicyCode.KEY_EXPIRED, key.expires_ns
    else:
        return None
    return Deny(
        ask=ask, code=code, rules=_UP_TO[PolicyRule.KEY], when_ns=when_ns, who=_keepers(state, ask)
    )


def _lock(state: PolicyState, ask: Query) -> Deny | None:
    if ask.principal not in state.locked or ask.skill == STOP:
        return None
    return Deny(
        ask=ask, code=PolicyCode.LOCKED, rules=_UP_TO[PolicyRule.LOCK], who=_keepers(state, ask)
    )


def _sight(state: PolicyState, ask: Query) -> Deny | None:
    rights = state.rights
    if rights.sees(ask.principal, ask.robot, state.now_ns) and _reaches(state, ask.robot, READ):
        return None
    # Nothing in it may depend on whether there is such a robot.
    return Deny(
        ask=ask,
        code=PolicyCode.NO_SUCH_ROBOT,
        rules=_UP_TO[PolicyRule.SIGHT],
        when_ns=rights.ended_ns(ask.principal, state.now_ns),
        who=_keepers(state, ask),
    )


def _reaches(state: PolicyState, robot: RobotId, skill: str) -> bool:
    return state.key is not None and state.rights.covers(state.key.scopes, robot, skill)


def _choose(state: PolicyState, ask: Query) -> tuple[RightReason, HeldGrant] | Deny:
    """Return the right they act under."""
    rights = state.rights
    if not _reaches(state, ask.robot, ask.skill):
        return _refuse(state, ask, PolicyCode.KEY_TOO_NARROW, PolicyRule.REACH)
    found = list(rights.ways(ask.principal, ask.robot, ask.skill))
    live = [one for one in found if state.now_ns < one[1].until_ns]
    if not live:
        return _not_given(state, ask, found)
    least = rights.caution(ask.robot, ask.skill).assurance
    near = [one for one in live if ask.channel >= one[0].assurance and ask.channel >= least]
    if not near:
        wanted = max(least, min(way.assurance for way, _ in live))
        denied = _refuse(state, ask, PolicyCode.CHANNEL_TOO_WEAK, PolicyRule.CHANNEL)
        return msgspec.structs.replace(denied, channel=wanted)
    return _within(state, ask, near)


def _within(
    state: PolicyState, ask: Query, near: list[tuple[RightReason, HeldGrant]]
) -> tuple[RightReason, HeldGrant] | Deny:
    """Return the right of the highest priority under whose limits the arguments are."""
    if len(near) == 1 and not near[0][0].limits:
        return near[0]
    if ask.arguments is None:
        free = [one for one in near if not one[0].limits]
        return max(free, key=_priority) if free else min(near, key=_priority)
    arguments = ask.arguments
    fit = [one for one in near if broken_limit(one[0].limits, arguments) is None]
    if fit:
        return max(fit, key=_priority)
    way, holding = max(near, key=_priority)
    return msgspec.structs.replace(
        _refuse(state, ask, PolicyCode.OVER_LIMIT, PolicyRule.LIMITS),
        limit=broken_limit(way.limits, arguments),
        way=way,
        grant=holding.grant,
    )


def _priority(one: tuple[RightReason, HeldGrant]) -> int:
    return one[0].priority


def _take(
    state: PolicyState, ask: Query, way: RightReason, grant: Grant
) -> tuple[PrincipalId, ...] | Deny:
    """Return from whom the robot is taken over; nobody if it is free."""

    def no(
        code: PolicyCode, rule: PolicyRule, holder: PrincipalId | None, when_ns: int | None
    ) -> Deny:
        return Deny(
            ask=ask,
            code=code,
            rules=_UP_TO[rule],
            holder=holder,
            when_ns=when_ns,
            way=way,
            grant=grant,
        )

    if state.stopped:
        return no(PolicyCode.ROBOT_STOPPED, PolicyRule.STOPPED, None, None)
    slot = _slot_now(state)
    if slot is None and state.slots == "required":
        return no(PolicyCode.SLOT_NEEDED, PolicyRule.SLOT, None, state.next_free_ns)
    owner = None
    if slot is not None and slot.principal != ask.principal:
        owner = slot.principal
        if not _outranks(state, ask, way, owner):
            when_ns = slot.end_ns if state.next_free_ns is None else state.next_free_ns
            return no(PolicyCode.SLOT_TAKEN, PolicyRule.SLOT, owner, when_ns)
    holder = state.holder if state.holder != ask.principal else None
    if holder is not None and not _outranks(state, ask, way, holder):
        return no(PolicyCode.ROBOT_TAKEN, PolicyRule.LEASE, holder, state.holder_until_ns)
    return tuple(dict.fromkeys(other for other in (owner, holder) if other is not None))


def _slot_now(state: PolicyState) -> BookedSlot | None:
    slot = state.slot
    if state.slots == "none" or slot is None or not slot.covers(state.now_ns):
        return None
    return slot


def _outranks(state: PolicyState, ask: Query, way: RightReason, other: PrincipalId) -> bool:
    rights = state.rights
    return rights.may_take_over(ask.robot) and way.priority > rights.priority(
        other, ask.robot, state.now_ns
    )


def _outstanding(
    care: tuple[StepRequired, ...], state: PolicyState, ask: Query
) -> tuple[StepRequired, ...]:
    done = {
        StepRequired.CONFIRMATION: state.confirmed,
        StepRequired.STEP_UP: state.stepped_up,
        StepRequired.SECOND_PERSON: _seconded(state, ask),
    }
    return tuple(need for need in care if not done[need])


def _seconded(state: PolicyState, ask: Query) -> bool:
    """Whether somebody else who may do just that has agreed. Nobody agrees with themselves."""
    second = state.second
    return (
        second is not None
        and second != ask.principal
        and second not in state.locked
        and may_agree(state.rights, second, ask, state.now_ns)
    )


def may_agree(rights: Permissions, second: PrincipalId, ask: Query, now_ns: int) -> bool:
    """Whether what somebody asks for is within a right of another person, limits and all.

    While the arguments are not known yet, any right to the skill does.
    """
    return any(
        now_ns < holding.until_ns
        and (ask.arguments is None or broken_limit(way.limits, ask.arguments) is None)
        for way, holding in rights.ways(second, ask.robot, ask.skill)
    )


def _not_given(state: PolicyState, ask: Query, found: list[tuple[RightReason, HeldGrant]]) -> Deny:
    if not found:
        return _refuse(state, ask, PolicyCode.NOT_GRANTED, PolicyRule.RIGHT)
    _, holding = max(found, key=lambda one: one[1].until_ns)
    return msgspec.structs.replace(
        _refuse(state, ask, PolicyCode.RIGHT_ENDED, PolicyRule.RIGHT),
        when_ns=holding.until_ns,
        grant=holding.grant,
    )


def _refuse(state: PolicyState, ask: Query, code: PolicyCode, rule: PolicyRule) -> Deny:
    """Refuse something about a robot they may see: say who gives rights on it, and which."""
    rights = state.rights
    return Deny(
        ask=ask,
        code=code,
        rules=_UP_TO[rule],
        who=rights.givers(ask.robot, state.now_ns, besides=ask.principal),
        roles=rights.roles_giving(ask.robot, ask.skill),
    )


def _keepers(state: PolicyState, ask: Query) -> tuple[PrincipalId, ...]:
    return state.rights.givers(FLEET, state.now_ns, besides=ask.principal)
