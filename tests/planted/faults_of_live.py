"""Guards of live orders: what a sample may do, who has the controls, and when they are silent."""

from __future__ import annotations

from tests.planted.faults import Fault

GATE = "tests/core/test_sample_gate.py"
WHOLE = "tests/gateway/test_live_control.py"
LINKER = "tests/linker/test_linker.py"
REAL = "tests/real/ros2/test_live.py"
ANY = f"{GATE}::test_whatever_comes_only_what_is_young_in_order_and_bounded_steers"

OF_LIVE = (
    Fault(
        name="I6 a sample that is late steers",
        file="core/sample_gate.py",
        guard="return SampleVerdict.LATE if now_ns - sent_ns > self._late_ns else sent_ns",
        without="return sent_ns",
        caught_by=(ANY, f"{WHOLE}::test_samples_that_are_late_or_out_of_order_steer_nothing"),
    ),
    Fault(
        name="I3 a sample that was overtaken steers",
        file="core/sample_gate.py",
        guard="if self._sequence is not None and sample.sequence <= self._sequence:",
        without="if False:",
        caught_by=(ANY, f"{WHOLE}::test_samples_that_are_late_or_out_of_order_steer_nothing"),
    ),
    Fault(
        name="I2 a clock that was set forward makes old samples young",
        file="core/sample_gate.py",
        guard="if ahead_ns > self._slack_ns:",
        without="if False:",
        caught_by=(
            f"{GATE}::test_a_clock_that_runs_ahead_by_more_than_that_steers_nothing",
            f"{WHOLE}::test_a_clock_of_whoever_steers_that_is_set_forward_ends_it",
        ),
    ),
    Fault(
        name="I2 a clock may be set forward a little, again and again",
        file="core/sample_gate.py",
        guard="        self._slack_ns -= ahead_ns\n",
        without="",
        caught_by=(f"{GATE}::test_a_clock_that_runs_ahead_by_more_than_that_steers_nothing",),
    ),
    Fault(
        name="I6 nobody notices that the controls are silent",
        file="core/sample_gate.py",
        guard="if self.end is None and self.begun_ns and now_ns > self.until_ns:",
        without="if False:",
        caught_by=(
            f"{GATE}::test_what_was_silent_for_too_long_is_over_for_good",
            f"{WHOLE}::test_silence_ends_it_for_good",
        ),
    ),
    Fault(
        name="I6 what was silent for too long goes on with the next sample",
        file="core/sample_gate.py",
        guard="        if self.look(now_ns) is not None:\n            return OVER\n",
        without="",
        caught_by=(
            f"{GATE}::test_what_was_silent_for_too_long_is_over_for_good",
            f"{WHOLE}::test_silence_ends_it_for_good",
        ),
    ),
    Fault(
        name="I6 the dead man counts from when a sample came",
        file="core/sample_gate.py",
        guard="self.taken_ns = max(self.taken_ns, sent_ns)",
        without="self.taken_ns = now_ns",
        caught_by=(f"{WHOLE}::test_it_counts_from_when_a_sample_was_sent",),
    ),
    Fault(
        name="I6 a live order lasts for ever",
        file="core/sample_gate.py",
        guard="return min(silent_ns, self.begun_ns + self._most_ns)",
        without="return silent_ns",
        caught_by=(
            f"{GATE}::test_it_lasts_no_longer_than_it_may",
            f"{WHOLE}::test_nobody_drives_for_ever",
        ),
    ),
    Fault(
        name="I14 a sample for another order steers",
        file="core/sample_gate.py",
        guard="if sample.order != self.order:",
        without="if False:",
        caught_by=(ANY, f"{WHOLE}::test_samples_that_are_late_or_out_of_order_steer_nothing"),
    ),
    Fault(
        name="what is no number steers",
        file="core/sample_gate.py",
        guard="if not is_finite_number(value):",
        without="if False:",
        caught_by=(f"{WHOLE}::test_what_is_no_finite_number_steers_nothing",),
    ),
    Fault(
        name="a sample goes beyond the bounds",
        file="core/sample_gate.py",
        guard="within = min(max(value, one.low), one.high)",
        without="within = value",
        caught_by=(ANY, f"{WHOLE}::test_bounds_hold_and_that_is_told"),
    ),
    Fault(
        name="I8 whoever steers is bound by nobody's limits but the robot's",
        file="gateway/live_control.py",
        guard="limits = decision.way.limits if decision.way is not None else ()",
        without="limits: tuple[Limit, ...] = ()",
        caught_by=(
            f"{WHOLE}::test_the_limits_of_whoever_steers_hold",
            f"{WHOLE}::test_other_limits_hold_from_the_next_sample_on",
        ),
    ),
    Fault(
        name="I8 whoever began to steer goes on whatever becomes of their rights",
        file="gateway/live_control.py",
        guard="if live.lost or not (self._is_current(live) or self._is_admitted_anew(live)):",
        without="if live.lost:",
        caught_by=(f"{WHOLE}::test_a_right_that_is_gone_ends_it_and_says_why",),
    ),
    Fault(
        name="I12 the controls are anybody's",
        file="gateway/live_control.py",
        guard="if live is None or live.order.permit.principal != principal:",
        without="if live is None:",
        caught_by=(f"{WHOLE}::test_two_people_at_once_are_told",),
    ),
    Fault(
        name="I12 two places have the controls",
        file="gateway/live_control.py",
        guard="        if self.taken:\n            raise RobotBusy(STEERED_ALREADY)\n",
        without="",
        caught_by=(f"{WHOLE}::test_two_people_at_once_are_told",),
    ),
    Fault(
        name="limits that leave no rest let somebody drive",
        file="gateway/live_control.py",
        guard="if not low <= 0.0 <= high:",
        without="if False:",
        caught_by=(f"{WHOLE}::test_limits_that_leave_no_rest_let_nobody_drive",),
    ),
    Fault(
        name="what does not stream is driven live",
        file="gateway/live_control.py",
        guard="if not skill.streams:",
        without="if False:",
        caught_by=(f"{WHOLE}::test_what_does_not_stream_is_not_driven_live",),
    ),
    Fault(
        name="I16 what was agreed to with its values is steered",
        file="gateway/agreement.py",
        guard="acts: list[object] = [LIVE] if live else []",
        without="acts: list[object] = []",
        caught_by=(
            f"{WHOLE}::test_what_was_confirmed_to_be_steered_is_not_done_otherwise",
            f"{WHOLE}::test_what_was_confirmed_with_its_values_is_not_steered",
        ),
    ),
    Fault(
        name="I18 a live order that nobody steers is carried out",
        file="linker/linker.py",
        guard=(
            "        if order.live:\n"
            "            return execute_live(robot, order, tell, controls)\n"
        ),
        without="",
        caught_by=(f"{LINKER}::test_a_live_order_that_nobody_steers_is_void",),
    ),
    Fault(
        name="I6 over ROS the stream goes on whatever its controls say",
        file="robots/ros2/live_stream.py",
        guard="return self.end is not None",
        without="return False",
        caught_by=(f"{REAL}::test_silence_brings_it_to_rest_for_good",),
    ),
)
