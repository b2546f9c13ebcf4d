"""The guards around tasks: each promise of a fleet was seen broken."""

from __future__ import annotations

from tests.planted.faults import Fault

HISTORIES = "tests/core/fleet/test_histories.py::test_whatever_fails_no_promise_is_broken"
REACTING = "core/fleet/reacting.py"
ASSIGNING = "tests/rooms/organiser/test_assigning.py"

OF_FLEET = (
    Fault(
        name="a robot gets a second task",
        file=REACTING,
        guard="        and robot not in fleet.holds\n",
        without="",
        caught_by=(HISTORIES,),
    ),
    Fault(
        name="a late answer counts for whoever has the task now",
        file=REACTING,
        guard="return attempt == task.attempt and task.state in HELD",
        without="return task.state in HELD",
        caught_by=(HISTORIES,),
    ),
    Fault(
        name="a task moves before its robot is at rest",
        file=REACTING,
        guard="    return _leave(task, _LEAVES[end], now_ns)\n",
        without="    return _left(fleet, task, _LEAVES[end], now_ns)\n",
        caught_by=(HISTORIES,),
    ),
    Fault(
        name="a task moves twice from one robot",
        file=REACTING,
        guard="return e.NOTHING if task.leaving else _leave(task, event.why, now_ns)",
        without="return _leave(task, event.why, now_ns)",
        caught_by=(HISTORIES,),
    ),
    Fault(
        name="somebody's robot is given to another's task",
        file="core/fleet/planning.py",
        guard="if glance.holder is not None and glance.holder != task.author:",
        without="if False:",
        caught_by=(HISTORIES,),
    ),
    Fault(
        name="a task that waits is lost",
        file="core/fleet/state.py",
        guard="        elif task.state is State.QUEUED:\n            self.waiting[key] = None\n",
        without="",
        caught_by=(HISTORIES,),
    ),
    Fault(
        name="a step that is done is done again",
        file=REACTING,
        guard="    if task.done != task.asked:\n",
        without="    if task.done != task.asked or task.leaving:\n",
        caught_by=(HISTORIES,),
    ),
    Fault(
        name="what may have been done is repeated after a crash",
        file=REACTING,
        guard="        return _doubted(task, Why.RESTARTED, now_ns)\n",
        without="        return _left(fleet, task, Why.TAKEN, now_ns)\n",
        caught_by=(HISTORIES,),
    ),
    Fault(
        name="what must not be done twice is moved while in doubt",
        file=REACTING,
        guard="    if task.once and why in _IN_DOUBT:",
        without="    if False:",
        caught_by=(HISTORIES,),
    ),
    Fault(
        name="what is urgent is weighed like anything else",
        file="core/fleet/planning.py",
        guard="            levels.setdefault(task.priority, []).append(task)",
        without="            levels.setdefault(0, []).append(task)",
        caught_by=(f"{ASSIGNING}::test_what_is_urgent_chooses_first_even_if_that_costs_more",),
    ),
)
