"""The guards of robots among themselves, each taken out."""

from __future__ import annotations

from tests.planted.faults import Fault

AMONG = "tests/features/robot_to_robot"
SHARING = f"{AMONG}/test_shared_state.py"
HELPING = f"{AMONG}/test_help_service.py"
GUARD = f"{AMONG}/test_loop_guard.py"
STORM = f"{AMONG}/test_storm.py"
STRATEGIES = f"{AMONG}/test_strategies.py"

OF_AMONG = (
    Fault(
        name="a robot's rights are not asked for",
        file="features/robot_to_robot/permissions.py",
        guard="        self._rooms.organiser.check_word(caller, robot, word)\n",
        without="",
        caught_by=(
            f"{SHARING}::test_rights_are_checked_like_a_persons",
            f"{HELPING}::test_who_may_not_help_does_not",
        ),
    ),
    Fault(
        name="a locked robot is heard",
        file="features/robot_to_robot/permissions.py",
        guard="        self._rooms.organiser.check_unlocked(caller)\n",
        without="",
        caught_by=(
            f"{SHARING}::test_a_robot_whose_key_is_taken_back_or_that_is_locked_is_heard_no_more",
        ),
    ),
    Fault(
        name="I11 who follows goes on to hear when the right has ended",
        file="features/robot_to_robot/subscriptions.py",
        guard=" or not self._rights.robot_may(to, shared.robot, READ)",
        without="",
        caught_by=(f"{SHARING}::test_a_follower_whose_right_ends_hears_nothing_more",),
    ),
    Fault(
        name="I15 what a robot says may be of any length",
        file="core/robot/dialogue_protocol.py",
        guard="    if len(words) > at_most:",
        without="    if len(words) < 0:",
        caught_by=(f"{SHARING}::test_data_of_10_mb_is_refused_in_a_sentence_and_nothing_is_kept",),
    ),
    Fault(
        name="I15 a flood is worked on as fast as it comes",
        file="features/robot_to_robot/inbox.py",
        guard="wait_s = self._bucket.take(self._clock.monotonic_ns())",
        without="wait_s = 0.0",
        caught_by=(f"{STORM}::test_ten_thousand_a_second_are_bounded_and_the_newest_gets_through",),
    ),
    Fault(
        name="a flood is told again and again",
        file="features/robot_to_robot/inbox.py",
        guard="if not self._told and ",
        without="if ",
        caught_by=(f"{STORM}::test_ten_thousand_a_second_are_bounded_and_the_newest_gets_through",),
    ),
    Fault(
        name="a chain of answers has no end",
        file="features/robot_to_robot/inbox.py",
        guard="return hops <= HOPS_AT_MOST and ",
        without="return ",
        caught_by=(f"{GUARD}::test_a_chain_of_answers_ends_and_is_told_once",),
    ),
    Fault(
        name="robots that do not say why they speak answer each other for ever",
        file="features/robot_to_robot/inbox.py",
        guard="self._bucket(one, other, now_ns).take(now_ns) == 0",
        without="self._bucket(one, other, now_ns) is not None",
        caught_by=(f"{GUARD}::test_who_hides_why_it_speaks_is_cut_by_the_budget_of_the_pair",),
    ),
    Fault(
        name="a cut is told again and again",
        file="features/robot_to_robot/inbox.py",
        guard="news = pair not in self._last_cut_ns",
        without="news = True",
        caught_by=(
            f"{GUARD}::test_who_begins_again_at_once_is_cut_again_without_being_told_again",
        ),
    ),
    Fault(
        name="the same help is accepted twice",
        file="features/robot_to_robot/help_requests.py",
        guard="        if found.by:\n            raise",
        without="        if found.by and not by:\n            raise",
        caught_by=(f"{HELPING}::test_the_same_help_is_accepted_once_whoever_comes_together",),
    ),
    Fault(
        name="help is accepted that is not on disk",
        file="features/robot_to_robot/help_service.py",
        guard="await turn.write(self.book.accept(",
        without="await turn.act(self.book.accept(",
        caught_by=(f"{HELPING}::test_what_cannot_be_written_is_not_accepted",),
    ),
    Fault(
        name="a robot that helps is given tasks",
        file="features/fleet/monitor.py",
        guard="            and (helping or not self._engaged(robot))\n",
        without="",
        caught_by=(
            f"{HELPING}::test_the_tasks_of_both_go_on_with_others_and_neither_gets_one_meanwhile",
        ),
    ),
    Fault(
        name="a strategy counts before the robot has acknowledged it",
        file="features/robot_to_robot/strategies.py",
        guard="return standing.now if standing.known else standing.before",
        without="return standing.now",
        caught_by=(f"{STRATEGIES}::test_it_is_checked_sent_acknowledged_and_undone",),
    ),
    Fault(
        name="a strategy is changed under somebody's hands",
        file="features/robot_to_robot/strategies.py",
        guard="if holder is not None and holder != caller.principal:",
        without="if holder is None and not caller.principal:",
        caught_by=(f"{STRATEGIES}::test_nobody_adjusts_a_robot_that_somebody_else_has",),
    ),
    Fault(
        name="a strategy that is to wait does not",
        file="features/robot_to_robot/strategies.py",
        guard="if idle and not await self._is_idle(made.robot):",
        without="if not made.robot:",
        caught_by=(f"{STRATEGIES}::test_when_idle_it_waits_until_the_robot_carries_out_nothing",),
    ),
)
