"""Guards of what ends between acceptance and dispatch."""

from __future__ import annotations

from tests.planted.faults import Fault

BETWEEN = "tests/gateway/test_between.py"

OF_DISPATCH = (
    Fault(
        name="I8 a slot that ended is not noticed at dispatch",
        file="linker/linker.py",
        guard="self._wall_ns() >= permit.until_ns or ",
        without="",
        caught_by=(f"{BETWEEN}::test_a_slot_that_ends",),
    ),
    Fault(
        name="I8 a robot that was taken from somebody is still theirs at dispatch",
        file="organiser/organiser.py",
        guard="or not self.leases[order.robot].runs(fence)",
        without="",
        caught_by=(f"{BETWEEN}::test_a_session_that_is_ended",),
    ),
    Fault(
        name="a clock that was set back is not noticed at dispatch",
        file="organiser/organiser.py",
        guard="(doubt or not",
        without="(not",
        caught_by=(f"{BETWEEN}::test_a_clock_that_is_set_back",),
    ),
    Fault(
        name="a booking leaves what was admitted before as it was",
        file="gateway/access_registry.py",
        guard="calendar.apply(fact)\n        self._authority.moved()",
        without="calendar.apply(fact)",
        caught_by=(f"{BETWEEN}::test_a_slot_that_is_given_back_by_somebody_else",),
    ),
)
