"""The guards around alarms, and around what a rule lets its robot do."""

from __future__ import annotations

from tests.planted.faults import Fault

WATCH = "tests/core/alerts/test_state.py"
ALERTS = "tests/features/alerts/test_alerts.py"
STORM = "tests/features/alerts/test_alert_storm.py"
REACTIONS = "tests/features/alerts/test_reactions.py"
RUNS = "tests/features/alerts/test_alert_runs.py"

OF_ALERTS = (
    Fault(
        name="an alarm is raised before its time",
        file="core/alerts/state.py",
        guard="if now_ns - self._since_ns >= self._pace.lasting_ns:",
        without="if True:",
        caught_by=(f"{WATCH}::test_it_is_open_exactly_when_the_history_says",),
    ),
    Fault(
        name="an alarm flaps: what is not bad ends it",
        file="core/alerts/state.py",
        guard="            if reading is AlertReading.GOOD:\n",
        without="            if reading is not AlertReading.BAD:\n",
        caught_by=(f"{WATCH}::test_it_is_open_exactly_when_the_history_says",),
    ),
    Fault(
        name="an alarm is told without end",
        file="core/alerts/state.py",
        guard="if not due or self.level >= TOLD_AT_MOST - 1:",
        without="if not due:",
        caught_by=(f"{WATCH}::test_it_goes_on_being_told_a_bounded_number_of_times",),
    ),
    Fault(
        name="whoever is locked hears of alarms",
        file="features/alerts/recipients.py",
        guard="            and who not in self._organiser.locked\n",
        without="",
        caught_by=(f"{ALERTS}::test_whoever_is_locked_or_whose_key_is_over_is_not_told",),
    ),
    Fault(
        name="whoever only looks answers an alarm for all",
        file="features/alerts/recipients.py",
        guard="return self._organiser.why_not_move(who, robot) is None",
        without="return True",
        caught_by=(f"{ALERTS}::test_whoever_may_only_look_is_not_told_and_cannot_answer",),
    ),
    Fault(
        name="a rule goes round in circles",
        file="features/alerts/actions.py",
        guard="if past_ns < rule.run_every_ns or last.alarm_ns == alarm_ns:",
        without="if False:",
        caught_by=(f"{RUNS}::test_it_runs_once_an_occurrence_and_not_more_often_than_it_says",),
    ),
    Fault(
        name="a rule runs again after a restart",
        file="features/alerts/evaluator.py",
        guard="        if event is AlertEvent.RAISED and rule.alert.run:\n            self._spawn",
        without="        if rule.alert.run:\n            self._spawn",
        caught_by=(f"{RUNS}::test_a_restart_does_not_run_it_again",),
    ),
    Fault(
        name="I9 a rule moves its robot before its decision is on disk",
        file="features/alerts/actions.py",
        guard="await turn.write((decided, self._book.run(rule.key, AlertRun(now_ns, alarm_ns))))",
        without="await turn.act((decided, self._book.run(rule.key, AlertRun(now_ns, alarm_ns))))",
        caught_by=(f"{RUNS}::test_nothing_moves_before_the_decision_is_on_disk",),
    ),
    Fault(
        name="I16 a rule confirms by itself",
        file="features/alerts/actions.py",
        guard="lambda one: complete(one).arguments, lambda: NOTHING",
        without="lambda one: complete(one).arguments, lambda: AuthContext(confirmed=True)",
        caught_by=(f"{RUNS}::test_a_stopped_robot_stays_stopped_and_what_wants_a_tap_is_not_done",),
    ),
    Fault(
        name="a display name stands for the author of a rule",
        file="features/alerts/__init__.py",
        guard="lambda name: named.get(name.casefold())",
        without=(
            "lambda name: next((p.id for p in kernel.rooms.authoriser.directory.named(name)), None)"
        ),
        caught_by=(f"{RUNS}::test_a_name_means_the_person_of_the_configuration_alone",),
    ),
    Fault(
        name="a thousand alarms are a thousand messages",
        file="features/alerts/recipients.py",
        guard="        if window.left > 0:\n            window.left -= 1\n",
        without="        if window.left > 0:\n",
        caught_by=(
            f"{STORM}::test_a_thousand_alarms_are_a_few_messages_and_one_tap_has_seen_them",
        ),
    ),
    Fault(
        name="a storm that goes on is told one by one again",
        file="features/alerts/recipients.py",
        guard="                self._windows[who] = _Window(now_ns + WINDOW_NS, 0)\n",
        without="",
        caught_by=(f"{STORM}::test_a_storm_that_goes_on_is_one_message_a_window",),
    ),
    Fault(
        name="what is gathered at the end is lost",
        file="features/alerts/evaluator.py",
        guard="        self.telling.close()\n",
        without="",
        caught_by=(f"{STORM}::test_what_is_gathered_when_it_ends_is_told_then",),
    ),
    Fault(
        name="an old tap has seen a later alarm",
        file="features/alerts/evaluator.py",
        guard="alarm is not None and alarm.at_ns == at_ns:",
        without="alarm is not None:",
        caught_by=(
            f"{STORM}::test_what_is_over_is_gathered_too_and_a_later_alarm_is_not_seen_by_an_old_tap",
        ),
    ),
    Fault(
        name="whoever only looks has seen alarms of many for all",
        file="features/alerts/commands.py",
        guard="[f for f in meant if circles.may_acknowledge(who, f.rule.robot)]",
        without="meant",
        caught_by=(f"{REACTIONS}::test_who_may_only_look_is_told_once_why_it_does_not_count",),
    ),
)
