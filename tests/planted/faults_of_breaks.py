"""Guards of what ends motion at a break, for good."""

from __future__ import annotations

from tests.planted.faults import Fault

STILL = "tests/rosic_sim/robots/test_standing_still.py"
RUNTIME = "tests/real/ros2/test_runtime.py"
AFTER = "tests/gateway/test_after_a_break.py"
AWAY = "tests/features/alerts/test_offline_notices.py"
DEAD_MAN = "tests/core/test_deadman.py"

PURSUED = "tests/linker/test_pursuit.py"
FROZEN = "tests/real/ros2/test_frozen_goal.py"
HALVES = "tests/real/ros2/test_halves.py"
UNANSWERED = "tests/real/ros2/test_unanswered.py"
MOVES = "tests/gateway/test_broken_stops.py"
CLIENTS = "tests/robots/ros2/test_client_link.py"
REBIRTHS = "tests/robots/ros2/test_endpoint_identity.py"

OF_BREAKS = (
    Fault(
        name="I5 a stop that was not confirmed is left at that",
        file="linker/linker.py",
        guard="        self.pursuit.begin(stop, task)\n",
        without="",
        caught_by=(
            f"{PURSUED}::test_a_stop_is_applied_once_a_second_until_rest_is_measured",
            f"{PURSUED}::test_what_is_not_there_is_stopped_once_it_is_back",
        ),
    ),
    Fault(
        name="I5 what is seen to move is resumed",
        file="linker/linker.py",
        guard="if self.presence(robot_id).moves:",
        without="if False:",
        caught_by=(f"{PURSUED}::test_what_moves_is_not_resumed_and_stays_stopped_on_disk_too",),
    ),
    Fault(
        name="I6 after a crash a robot is held, and its goal goes on",
        file="linker/linker.py",
        guard="        self._brake(Stop(robot_id, generation))\n",
        without="",
        caught_by=(
            f"{PURSUED}::test_one_whose_last_order_is_in_doubt_is_brought_to_rest_and_held",
        ),
    ),
    Fault(
        name="I5 a stop goes on after it was undone",
        file="linker/linker.py",
        guard="        self.pursuit.end(robot_id)\n",
        without="",
        caught_by=(f"{PURSUED}::test_a_resume_ends_it",),
    ),
    Fault(
        name="I6 a gap of our own sending is not noticed",
        file="core/deadman.py",
        guard="if gap_s > self._watchdog_s:",
        without="if gap_s < 0.0:",
        caught_by=(
            f"{DEAD_MAN}::test_a_break_is_final",
            f"{STILL}::test_a_drive_ends_for_good_and_says_for_how_long_it_drove",
        ),
    ),
    Fault(
        name="I6 a goal whose acceptance was not heard goes on",
        file="robots/ros2/bindings/action.py",
        guard="            call.unanswered()\n",
        without="",
        caught_by=(
            f"{UNANSWERED}::test_a_robot_whose_acceptance_was_not_heard_is_brought_to_rest",
        ),
    ),
    Fault(
        name="I6 a client is dropped whose goal may still be accepted",
        file="robots/ros2/client/client_link.py",
        guard="        if self._unresolved or self._sees(self._handle):\n",
        without="        if self._sees(self._handle):\n",
        caught_by=(f"{CLIENTS}::test_what_was_sent_while_another_was_made_keeps_its_client",),
    ),
    Fault(
        name="I6 what a service did not answer to goes on",
        file="robots/ros2/bindings/service.py",
        guard="        binding_call.unanswered()\n",
        without="",
        caught_by=(
            f"{UNANSWERED}::test_what_a_service_did_not_answer_is_brought_to_rest_before_anything_else",
        ),
    ),
    Fault(
        name="I6 a goal goes on after ROSIC stood still",
        file="robots/ros2/goal_watch.py",
        guard=(
            "return MotionBreak(BreakCause.LATE, late_s)"
            " if late_s > self._call.side.watchdog_s else None"
        ),
        without="return None",
        caught_by=(f"{FROZEN}::test_a_goal_of_a_gateway_that_was_frozen_is_called_off",),
    ),
    Fault(
        name="I6 a robot that is not heard is driven on",
        file="core/deadman.py",
        guard="if age_s is not None and age_s > self._heard_within_s:",
        without="if age_s is None:",
        caught_by=(f"{DEAD_MAN}::test_a_break_is_final",),
    ),
    Fault(
        name="I6 a break is forgotten once both sides are well",
        file="core/deadman.py",
        guard="        if self._broken is None:\n            self._broken = self._look(",
        without="        if True:\n            self._broken = self._look(",
        caught_by=(f"{DEAD_MAN}::test_a_break_is_final",),
    ),
    Fault(
        name="I6 a robot whose software began anew is driven on",
        file="core/deadman.py",
        guard="if self._broken is None and another is not None:",
        without="if False:",
        caught_by=(f"{DEAD_MAN}::test_a_robot_that_began_anew_knows_nothing_of_what_it_was_told",),
    ),
    Fault(
        name="I6 a drive goes on after nothing was sent for as long as the watchdog waits",
        file="robots/ros2/velocity_stream.py",
        guard="            if sent and unsent_s > side.watchdog_s:",
        without="            if False:",
        caught_by=("tests/robots/ros2/test_velocity_gaps.py",),
    ),
    Fault(
        name="I6 whose name came after the drive began is not known again",
        file="robots/ros2/publishers.py",
        guard="self.first = named_since(self.first, now)",
        without="self.first = self.first",
        caught_by=(
            f"{REBIRTHS}::test_a_name_that_comes_later_is_taken_in_and_told_again_when_it_is_born_anew",
        ),
    ),
    Fault(
        name="I6 beside one without a name, whoever joins is driven on",
        file="robots/ros2/publishers.py",
        guard="any(unknown or not name for name in joined)",
        without="any(not name for name in joined)",
        caught_by=(
            f"{REBIRTHS}::test_while_one_of_the_first_has_no_name_whoever_joins_may_be_that_one",
        ),
    ),
    Fault(
        name="I6 who has no name yet is driven on after a while",
        file="robots/ros2/publishers.py",
        guard="return self.waits and now_ns - self._since_ns >= self._patience_ns",
        without="return False",
        caught_by=(
            f"{REBIRTHS}::test_whoever_joins_is_waited_for_until_a_name_is_known_and_no_longer",
        ),
    ),
    Fault(
        name="I6 what breaks off before a goal is accepted is not noticed",
        file="robots/ros2/goal_watch.py",
        guard="            self.broken = self._late() or self._look()\n",
        without="            self._late()\n",
        caught_by=(
            f"{HALVES}::test_a_goal_ends_when_what_drives_was_frozen_before_it_was_accepted",
        ),
    ),
    Fault(
        name="I6 simulated machines go on while this process stands still",
        file="rosic_sim/robots/simulation_loop.py",
        guard="            self._lose_links(now_s)\n",
        without="",
        caught_by=(
            f"{STILL}::test_what_a_machine_does_by_itself_ends_as_without_a_link",
            f"{STILL}::test_a_drone_that_follows_does_not_follow_on",
        ),
    ),
    Fault(
        name="I6 what waits behind a broken motion begins",
        file="gateway/order_execution.py",
        guard="            self._linker.void(running.order.robot, AFTER_A_BREAK)",
        without="            pass",
        caught_by=(f"{AFTER}::test_what_waits_behind_a_motion_that_was_broken_off_is_not_done",),
    ),
    Fault(
        name="I6 a task is begun again after ROSIC stood still",
        file="features/fleet/attempt.py",
        guard="    if outcome.code == STOOD_STILL:\n        return AttemptEnd.INTERRUPTED\n",
        without="",
        caught_by=(f"{AFTER}::test_a_task_waits_for_a_person_when_rosic_stood_still",),
    ),
    Fault(
        name="I6 a task comes back to the robot that ended it by itself",
        file="features/fleet/attempt.py",
        guard="return AttemptEnd.FAILED if outcome.code == INTERRUPTED else AttemptEnd.TAKEN",
        without="return AttemptEnd.TAKEN",
        caught_by=(
            f"{AFTER}::test_a_task_that_the_robots_own_side_ended_does_not_come_back_to_it",
        ),
    ),
    Fault(
        name="I7 nobody is told that a stopped robot moves all the same",
        file="features/alerts/__init__.py",
        guard=", self.broken_stops.run()",
        without="",
        caught_by=(
            f"{MOVES}::test_whoever_stopped_a_robot_is_told_once_that_it_moves_all_the_same",
        ),
    ),
    Fault(
        name="I7 nobody is told that a robot at work is not there any more",
        file="features/alerts/__init__.py",
        guard=", self.absences.run()",
        without="",
        caught_by=(
            f"{AWAY}::test_a_robot_that_vanishes_at_work_is_said_to_be_away_and_to_be_back",
        ),
    ),
    Fault(
        name="I6 a goal goes on whose acceptance came as whoever sent it was cut off",
        file="robots/ros2/client/executor_thread.py",
        guard="    if answered and late is not None:\n        late(answer.result())\n",
        without="    assert answered is not None\n",
        caught_by=(
            f"{RUNTIME}::test_an_answer_in_the_turn_in_which_whoever_asked_is_cut_off_is_late",
        ),
    ),
)
