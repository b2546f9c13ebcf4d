"""Why a decision is as it is, rule by rule, for whoever looks after the place.

It says more than the person who was refused may hear: never show it to them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import msgspec

from rosic.core.policy.query import STOP, Allow, Deny, PolicyCode, PolicyRule
from rosic.core.policy.roles import Assurance, StepRequired

if TYPE_CHECKING:
    from rosic.core.policy.query import Decision


class PolicyTexts(msgspec.Struct, frozen=True, kw_only=True):
    """How ids and times read here.

    Attributes:
        person, robot, time: From a principal's id, a robot's id, a wall clock in nanoseconds.
    """

    person: Callable[[str], str] = str
    robot: Callable[[str], str] = str
    time: Callable[[int], str] = "{} ns".format


_NEEDS = {
    StepRequired.CONFIRMATION: "a tap that confirms it",
    StepRequired.STEP_UP: "a second factor",
    StepRequired.SECOND_PERSON: "a second person who agrees",
}
PLAIN = PolicyTexts()


def explain(decision: Decision, wording: PolicyTexts = PLAIN) -> tuple[str, ...]:
    """Return one line for each rule that was asked, in order, in plain words."""
    refused = decision.rules[-1] if isinstance(decision, Deny) else None
    lines: list[str] = []
    for rule in decision.rules:
        if isinstance(decision, Deny) and rule is refused:
            mark, text = "no", _REFUSALS[decision.code](decision, wording)
        else:
            mark, text = "ok", _passed(rule, decision, wording)
        lines.append(f"{mark:<3} {rule.value + ':':<9} {text}")
    return tuple(lines)


def _passed(rule: PolicyRule, decision: Decision, wording: PolicyTexts) -> str:
    if rule in _PASSED:
        return _PASSED[rule].format(robot=wording.robot(decision.ask.robot), ask=decision.ask)
    if rule is PolicyRule.RIGHT:
        return _origin(decision, wording)
    if rule is PolicyRule.LIMITS:
        return _limits(decision)
    if isinstance(decision, Allow):
        return _care(decision) if rule is PolicyRule.CARE else _taking(rule, decision, wording)
    return "leaves it to them"


_PASSED = {
    PolicyRule.KEY: "their own, and good",
    PolicyRule.SIGHT: "they may see {robot}",
    PolicyRule.REACH: "the key reaches {ask.skill}",
    PolicyRule.CHANNEL: "the conversation is {ask.channel.said}, which is enough",
    PolicyRule.STOPPED: "{robot} is not stopped",
    PolicyRule.LOCK: "not locked, or it is a stop",
}


def _origin(decision: Decision, wording: PolicyTexts) -> str:
    way, grant = decision.way, decision.grant
    if way is None or grant is None:
        return "there is one"
    if way.via:
        said = f"the role {' which includes '.join(way.via)} gives {way.scope}"
    else:
        said = f"they were given {way.scope} itself"
    if grant.robots:
        said += f", only on {', '.join(grant.robots)}"
    if grant.expires_ns is not None:
        said += f", until {wording.time(grant.expires_ns)}"
    return said


def _limits(decision: Decision) -> str:
    limits = decision.way.limits if decision.way is not None else ()
    if not limits:
        return "none"
    said = ", ".join(limit.said for limit in limits)
    unchecked = isinstance(decision, Allow) and decision.unchecked
    return f"{said} (asked once the values are known)" if unchecked else f"within {said}"


def _taking(rule: PolicyRule, decision: Allow, wording: PolicyTexts) -> str:
    if not decision.preempts:
        return "no slot in the way" if rule is PolicyRule.SLOT else "nobody else has it"
    others = ", ".join(map(wording.person, decision.preempts))
    return f"free, or taken over from {others}, whose priority is below {decision.priority}"


def _care(decision: Allow) -> str:
    if not decision.care:
        return "nothing has to come first"
    wanted = ", ".join(_NEEDS[need] for need in decision.care)
    if not decision.needs:
        return f"wants {wanted}: done"
    return f"wants {wanted}; still missing: {', '.join(_NEEDS[need] for need in decision.needs)}"


def _helpers(denied: Deny, wording: PolicyTexts) -> str:
    return f"; {' or '.join(map(wording.person, denied.who))} can help" if denied.who else ""


def _when(denied: Deny, wording: PolicyTexts, word: str) -> str:
    return f"{word} {wording.time(denied.when_ns)}" if denied.when_ns is not None else ""


def _not_seen(denied: Deny, wording: PolicyTexts) -> str:
    said = f"nothing shows them {denied.ask.robot}; to them there is no such robot"
    return said + _when(denied, wording, "; all their rights ended at") + _helpers(denied, wording)


def _not_given(denied: Deny, wording: PolicyTexts) -> str:
    robot = wording.robot(denied.ask.robot)
    by = f"; it takes the role {' or '.join(denied.roles)}" if denied.roles else "; no role does"
    said = f"nothing of theirs gives {denied.ask.skill} on {robot}{by}"
    return said + _helpers(denied, wording)


def _too_weak(denied: Deny, wording: PolicyTexts) -> str:
    wanted = (denied.channel or Assurance.PROVIDER_READABLE).said
    return f"the conversation is {denied.ask.channel.said}, it takes {wanted}" + _helpers(
        denied, wording
    )


def _over(denied: Deny, wording: PolicyTexts) -> str:
    limit = denied.limit
    if limit is None:
        return "over a limit" + _helpers(denied, wording)
    value = (denied.ask.arguments or {}).get(limit.parameter, "missing")
    return f"{limit.said} is broken ({limit.parameter} is {value}, in SI)" + _helpers(
        denied, wording
    )


def _slot_taken(denied: Deny, wording: PolicyTexts) -> str:
    owner = wording.person(denied.holder or "")
    return f"the time is {owner}'s" + _when(denied, wording, "; free at")


def _robot_taken(denied: Deny, wording: PolicyTexts) -> str:
    who = wording.person(denied.holder or "")
    return f"{who} has {wording.robot(denied.ask.robot)}" + _when(denied, wording, " until")


_Refusal = Callable[[Deny, PolicyTexts], str]
_REFUSALS: dict[PolicyCode, _Refusal] = {
    PolicyCode.KEY_UNKNOWN: lambda d, w: "none of theirs" + _helpers(d, w),
    PolicyCode.KEY_REVOKED: lambda d, w: "taken back" + _helpers(d, w),
    PolicyCode.KEY_EXPIRED: lambda d, w: _when(d, w, "expired at") + _helpers(d, w),
    PolicyCode.LOCKED: lambda d, w: f"locked; only {STOP} is left to them" + _helpers(d, w),
    PolicyCode.NO_SUCH_ROBOT: _not_seen,
    PolicyCode.KEY_TOO_NARROW: lambda d, w: (
        f"the key does not reach {d.ask.skill}" + _helpers(d, w)
    ),
    PolicyCode.NOT_GRANTED: _not_given,
    PolicyCode.RIGHT_ENDED: lambda d, w: _when(d, w, "it ended at") + _helpers(d, w),
    PolicyCode.CHANNEL_TOO_WEAK: _too_weak,
    PolicyCode.OVER_LIMIT: _over,
    PolicyCode.ROBOT_STOPPED: lambda d, w: f"{w.robot(d.ask.robot)} is stopped until it is resumed",
    PolicyCode.SLOT_NEEDED: lambda d, w: "a slot of one's own is needed" + _when(d, w, "; free at"),
    PolicyCode.SLOT_TAKEN: _slot_taken,
    PolicyCode.ROBOT_TAKEN: _robot_taken,
}
