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

from rosic.core.asking import STOP, Allowed, Ask, Code, Decision, Denied, Rule, State
from rosic.core.authority import READ
from rosic.core.limits import broken_limit
from rosic.core.reach import FLEET
from rosic.core.roles import Need

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.rights import Rights
    from rosic.core.robot import RobotId
    from rosic.core.roles import Grant
    from rosic.core.slot import Slot
    from rosic.core.tables import Holding, Way

RULES = tuple(Rule)
_STOPPING = RULES[:3]
_STILL = (*RULES[:7], Rule.CARE)
_UP_TO = {rule: RULES[: RULES.index(rule) + 1] for rule in RULES}


def decide(state: State, ask: Ask) -> Decision:
    """Decide. Pure: the same state and question give the same answer."""
    denied = _key(state, ask) or _lock(state, ask) or _sight(state, ask)
    if denied is not None:
        return denied
    if ask.skill == STOP:
        return Allowed(ask=ask, rules=_STOPPING)
    chosen = _choose(state, ask)
    if isinstance(chosen, Denied):
        return chosen
    way, holding = chosen
    preempts: tuple[PrincipalId, ...] = ()
    actuates = state.rights.actuates(ask.robot, ask.skill)
    if actuates:
        taken = _take(state, ask, way, holding.grant)
        if isinstance(taken, Denied):
            return taken
        preempts = taken
    care = state.rights.caution(ask.robot, ask.skill).needs
    return Allowed(
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


def _key(state: State, ask: Ask) -> Denied | None:
    key = state.key
    if key is None or key.id != ask.key or key.principal != ask.principal:
        code, when_ns = Code.KEY_UNKNOWN, None
    elif key.revoked:
        code, when_ns = Code.KEY_REVOKED, None
    elif key.expires_ns is not None and state.now_ns >= key.expires_ns:
        code, when_ns = Code.KEY_EXPIRED, key.expires_ns
    else:
        return None
    return Denied(
        ask=ask, code=code, rules=_UP_TO[Rule.KEY], when_ns=when_ns, who=_keepers(state, ask)
    )


def _lock(state: State, ask: Ask) -> Denied | None:
    if ask.principal not in state.locked or ask.skill == STOP:
        return None
    return Denied(ask=ask, code=Code.LOCKED, rules=_UP_TO[Rule.LOCK], who=_keepers(state, ask))


def _sight(state: State, ask: Ask) -> Denied | None:
    rights = state.rights
    if rights.sees(ask.principal, ask.robot, state.now_ns) and _reaches(state, ask.robot, READ):
        return None
    # Nothing in it may depend on whether there is such a robot.
    return Denied(
        ask=ask,
        code=Code.NO_SUCH_ROBOT,
        rules=_UP_TO[Rule.SIGHT],
        when_ns=rights.ended_ns(ask.principal, state.now_ns),
        who=_keepers(state, ask),
    )


def _reaches(state: State, robot: RobotId, skill: str) -> bool:
    return state.key is not None and state.rights.covers(state.key.scopes, robot, skill)


def _choose(state: State, ask: Ask) -> tuple[Way, Holding] | Denied:
    """Return the right they act under."""
    rights = state.rights
    if not _reaches(state, ask.robot, ask.skill):
        return _refuse(state, ask, Code.KEY_TOO_NARROW, Rule.REACH)
    found = list(rights.ways(ask.principal, ask.robot, ask.skill))
    live = [one for one in found if state.now_ns < one[1].until_ns]
    if not live:
        return _not_given(state, ask, found)
    least = rights.caution(ask.robot, ask.skill).assurance
    near = [one for one in live if ask.channel >= one[0].assurance and ask.channel >= least]
    if not near:
        wanted = max(least, min(way.assurance for way, _ in live))
        denied = _refuse(state, ask, Code.CHANNEL_TOO_WEAK, Rule.CHANNEL)
        return msgspec.structs.replace(denied, channel=wanted)
    return _within(state, ask, near)


def _within(
    state: State, ask: Ask, near: list[tuple[Way, Holding]]
) -> tuple[Way, Holding] | Denied:
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
        _refuse(state, ask, Code.OVER_LIMIT, Rule.LIMITS),
        limit=broken_limit(way.limits, arguments),
        way=way,
        grant=holding.grant,
    )


def _priority(one: tuple[Way, Holding]) -> int:
    return one[0].priority


def _take(state: State, ask: Ask, way: Way, grant: Grant) -> tuple[PrincipalId, ...] | Denied:
    """Return from whom the robot is taken over; nobody if it is free."""

    def no(code: Code, rule: Rule, holder: PrincipalId | None, when_ns: int | None) -> Denied:
        return Denied(
            ask=ask, code=code, rules=_UP_TO[rule], holder=holder, when_ns=when_ns, way=way,
            grant=grant,
        )  # fmt: skip

    if state.stopped:
        return no(Code.ROBOT_STOPPED, Rule.STOPPED, None, None)
    slot = _slot_now(state)
    if slot is None and state.slots == "required":
        return no(Code.SLOT_NEEDED, Rule.SLOT, None, state.next_free_ns)
    owner = None
    if slot is not None and slot.principal != ask.principal:
        owner = slot.principal
        if not _outranks(state, ask, way, owner):
            when_ns = slot.end_ns if state.next_free_ns is None else state.next_free_ns
            return no(Code.SLOT_TAKEN, Rule.SLOT, owner, when_ns)
    holder = state.holder if state.holder != ask.principal else None
    if holder is not None and not _outranks(state, ask, way, holder):
        return no(Code.ROBOT_TAKEN, Rule.LEASE, holder, state.holder_until_ns)
    return tuple(dict.fromkeys(other for other in (owner, holder) if other is not None))


def _slot_now(state: State) -> Slot | None:
    slot = state.slot
    if state.slots == "none" or slot is None or not slot.covers(state.now_ns):
        return None
    return slot


def _outranks(state: State, ask: Ask, way: Way, other: PrincipalId) -> bool:
    rights = state.rights
    return rights.may_take_over(ask.robot) and way.priority > rights.priority(
        other, ask.robot, state.now_ns
    )


def _outstanding(care: tuple[Need, ...], state: State, ask: Ask) -> tuple[Need, ...]:
    done = {
        Need.CONFIRMATION: state.confirmed,
        Need.STEP_UP: state.stepped_up,
        Need.SECOND_PERSON: _seconded(state, ask),
    }
    return tuple(need for need in care if not done[need])


def _seconded(state: State, ask: Ask) -> bool:
    """Whether somebody else who may do just that has agreed. Nobody agrees with themselves."""
    second = state.second
    return (
        second is not None
        and second != ask.principal
        and second not in state.locked
        and may_agree(state.rights, second, ask, state.now_ns)
    )


def may_agree(rights: Rights, second: PrincipalId, ask: Ask, now_ns: int) -> bool:
    """Whether what somebody asks for is within a right of another person, limits and all.

    While the arguments are not known yet, any right to the skill does.
    """
    return any(
        now_ns < holding.until_ns
        and (ask.arguments is None or broken_limit(way.limits, ask.arguments) is None)
        for way, holding in rights.ways(second, ask.robot, ask.skill)
    )


def _not_given(state: State, ask: Ask, found: list[tuple[Way, Holding]]) -> Denied:
    if not found:
        return _refuse(state, ask, Code.NOT_GRANTED, Rule.RIGHT)
    _, holding = max(found, key=lambda one: one[1].until_ns)
    return msgspec.structs.replace(
        _refuse(state, ask, Code.RIGHT_ENDED, Rule.RIGHT),
        when_ns=holding.until_ns,
        grant=holding.grant,
    )


def _refuse(state: State, ask: Ask, code: Code, rule: Rule) -> Denied:
    """Refuse something about a robot they may see: say who gives rights on it, and which."""
    rights = state.rights
    return Denied(
        ask=ask,
        code=code,
        rules=_UP_TO[rule],
        who=rights.givers(ask.robot, state.now_ns, besides=ask.principal),
        roles=rights.roles_giving(ask.robot, ask.skill),
    )


def _keepers(state: State, ask: Ask) -> tuple[PrincipalId, ...]:
    return state.rights.givers(FLEET, state.now_ns, besides=ask.principal)
