"""Guards against a disk that neither writes nor fails, each taken out by one small change."""

from __future__ import annotations

from tests.planted.faults import Fault

HUNG = "tests/gateway/test_hung.py"
PURSUED = "tests/gateway/test_stop_pursued.py"

OF_HANGING = (
    Fault(
        name="I8 what ends by the clock waits behind a write",
        file="app/maintenance.py",
        guard="both.create_task(self._again_and_again(self._end_in_time, self._rights_changed))\n",
        without="await self._again_and_again(self.look, self._rights_changed)\n",
        caught_by=(
            f"{HUNG}::test_a_right_that_ends_while_the_record_hangs_moves_nothing_any_more",
            f"{HUNG}::test_a_clock_that_is_set_back_while_the_record_hangs_is_said",
        ),
    ),
    Fault(
        name="I8 a slot ends only once those who wait were written down",
        file="features/booking/scheduler.py",
        guard="            await self._until(serving, due_ns)\n",
        without="            await asyncio.wait((serving,))\n",
        caught_by=(
            "tests/features/booking/test_scheduler.py::test_a_time_ends_though_somebody_elses_write_hangs",
        ),
    ),
    Fault(
        name="I10 a stop is answered only once it is on disk",
        file="gateway/stop.py",
        guard="        if not await halting.kept(self._clock):\n",
        without="        if not await halting.latched:\n",
        caught_by=(f"{HUNG}::test_a_stop_is_answered_though_the_stop_file_hangs",),
    ),
    Fault(
        name="I7 of several who stopped a robot one reads that it rests",
        file="linker/pursuit.py",
        guard="        while (task := self._under_way.get(robot)) is not None:\n",
        without="        if (task := self._under_way.get(robot)) is not None:\n",
        caught_by=(f"{PURSUED}::test_everybody_who_stopped_it_reads_that_it_is_at_rest",),
    ),
)
