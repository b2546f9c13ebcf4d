"""Guards of authority, each taken out by one small change; the oracle has to notice every one."""

from __future__ import annotations

from tests.planted.faults import Fault

AGREES = ("tests/core/policy/test_oracle.py::test_twenty_thousand_random_cases_agree",)

FAULTS = (
    Fault(
        name="a key that was taken back is good",
        file="core/policy/evaluate.py",
        guard="    elif key.revoked:\n",
        without="    elif False:\n",
        caught_by=AGREES,
    ),
    Fault(
        name="somebody else's key is good",
        file="core/policy/evaluate.py",
        guard=" or key.principal != ask.principal:",
        without=":",
        caught_by=AGREES,
    ),
    Fault(
        name="a right is good for one moment too long",
        file="core/policy/evaluate.py",
        guard="if state.now_ns < one[1].until_ns]",
        without="if state.now_ns <= one[1].until_ns]",
        caught_by=AGREES,
    ),
    Fault(
        name="a lock is looked at only after the right was found wanting",
        file="core/policy/evaluate.py",
        guard="denied = _key(state, ask) or _lock(state, ask) or _sight(state, ask)",
        without="denied = _key(state, ask) or _sight(state, ask)",
        caught_by=AGREES,
    ),
    Fault(
        name="a robot that a person may not see is talked about",
        file="core/policy/evaluate.py",
        guard="if rights.sees(ask.principal, ask.robot, state.now_ns) and _reaches(",
        without="if _reaches(",
        caught_by=AGREES,
    ),
    Fault(
        name="a wildcard stands for the right to give rights",
        file="core/policy/scope.py",
        guard="        found.discard(GRANT)\n",
        without="        pass\n",
        caught_by=AGREES,
    ),
    Fault(
        name="an included role leaves the limits behind",
        file="core/policy/roles.py",
        guard="limits = (*limits, role.limits) if role.limits else limits",
        without="limits = (role.limits,) if role.limits else limits",
        caught_by=AGREES,
    ),
    Fault(
        name="an upper limit says nothing about going backwards",
        file="core/policy/limits.py",
        guard="        low = -high\n",
        without="        pass\n",
        caught_by=AGREES,
    ),
    Fault(
        name="what is not a number is within every limit",
        file="core/policy/limits.py",
        guard="or not limit.min <= value <= limit.max:",
        without="or value < limit.min or value > limit.max:",
        caught_by=AGREES,
    ),
    Fault(
        name="a limit that does not fit a skill sets it free",
        file="core/policy/compiled.py",
        guard="        except LimitMismatch:\n            return None\n",
        without="        except LimitMismatch:\n            return ()\n",
        caught_by=AGREES,
    ),
    Fault(
        name="equals take the robot from each other",
        file="core/policy/evaluate.py",
        guard="way.priority > rights.priority(",
        without="way.priority >= rights.priority(",
        caught_by=AGREES,
    ),
    Fault(
        name="nobody has to have booked",
        file="core/policy/evaluate.py",
        guard='if slot is None and state.slots == "required":',
        without="if False:",
        caught_by=AGREES,
    ),
    Fault(
        name="people agree with themselves",
        file="core/policy/evaluate.py",
        guard="        and second != ask.principal\n",
        without="",
        caught_by=AGREES,
    ),
    Fault(
        name="the second person needs no right of their own",
        file="core/policy/evaluate.py",
        guard="        and may_agree(state.rights, second, ask, state.now_ns)\n",
        without="",
        caught_by=AGREES,
    ),
    Fault(
        name="the second person's own limits are not asked",
        file="core/policy/evaluate.py",
        guard="and (ask.arguments is None or broken_limit(way.limits, ask.arguments) is None)",
        without="and True",
        caught_by=AGREES,
    ),
    Fault(
        name="the care of a skill forgets the conversation",
        file="core/policy/evaluate.py",
        guard=" and ask.channel >= least]",
        without="]",
        caught_by=AGREES,
    ),
    Fault(
        name="a change of grants forgets who gives rights no more",
        file="core/policy/permissions.py",
        guard="            people[principal] = after\n",
        without="            people[principal] = before or after\n",
        caught_by=AGREES,
    ),
)
