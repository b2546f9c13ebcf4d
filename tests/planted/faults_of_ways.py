"""Guards of the ways in, each taken out: whole histories by all of them at once notice it."""

from __future__ import annotations

from tests.planted.faults import Fault

ALL_WAYS = (
    "tests/api/test_histories_by_all_ways.py"
    "::test_whatever_comes_by_whichever_way_no_promise_is_broken"
)

OF_WAYS = (
    Fault(
        name="I8 a key of a program that was replaced counts on",
        file="authoriser/program_keys.py",
        guard="if not compare_digest(known, _digest(secret)):",
        without="if not known:",
        caught_by=(ALL_WAYS,),
    ),
    Fault(
        name="I10 a stop over the connection of a page is heard and not given",
        file="api/events.py",
        guard="group.create_task(self._stop(listener, heard))",
        without="pass",
        caught_by=(ALL_WAYS,),
    ),
)
