"""Guards of a cancel, and of the stop of one's own order, each taken out by one small change."""

from __future__ import annotations

from tests.planted.faults import Fault

CANCEL = "tests/gateway/test_cancel.py"
ASKED = "tests/gateway/test_asked_care.py"
OWN_STOP = "tests/gateway/test_own_stop.py"
CONTINUING = "tests/gateway/test_continuing.py"
SEVERAL = "tests/gateway/test_resuming_several.py"

CONSOLE = "tests/app/test_console.py"
LOWERING = "tests/gateway/test_limit_clamping.py"

OF_CANCELLING = (
    Fault(
        name="what is said to others in a group undoes a stop",
        file="features/fleet/pause.py",
        guard="meant = addressed or bool(robots)",
        without="meant = True",
        caught_by=(
            f"{CONTINUING}::test_what_is_said_to_others_in_a_group_resumes_nothing_and_is_offered",
            f"{CONTINUING}::test_paused_tasks_do_not_go_on_by_what_is_said_to_others",
        ),
    ),
    Fault(
        name="continue lets a robot begin a task that waits, and does not ask first",
        file="features/fleet/pause.py",
        guard="elif begins := self._begin_by_themselves(who, stopped):",
        without="elif begins := None:",
        caught_by=(f"{CONTINUING}::test_where_a_task_would_begin_by_itself_it_is_asked_first",),
    ),
    Fault(
        name="a stop of one's own hides somebody else's, and continue undoes both",
        file="core/stop_registry.py",
        guard="        if not self.latched:\n            self.stoppers = {}",
        without="        self.stoppers = {}",
        caught_by=(
            f"{CONTINUING}::test_ones_own_stop_covers_nobody_elses_and_continue_does_not_undo_theirs",
        ),
    ),
    Fault(
        name="a second Ctrl-C waits until rest is measured",
        file="app/closing.py",
        guard="                showing = await _bring_to_rest(console, gateway)\n",
        without="                showing = await _bring_to_rest(console, gateway)\n"
        "                await showing\n",
        caught_by=(f"{CONSOLE}::test_the_second_one_is_heard_while_robots_come_to_rest",),
    ),
    Fault(
        name="a default within one's limits is said to a group in one robot's unit",
        file="gateway/limit_clamping.py",
        guard='word = "" if all(one.unit == unit for one in robots) else unit.symbol',
        without='word = ""',
        caught_by=(
            f"{LOWERING}::test_of_a_group_each_reads_it_in_its_own_unit_and_none_goes_further_than_it_has_to",
        ),
    ),
    Fault(
        name="a cancel ends everybody's orders",
        file="gateway/order_execution.py",
        guard="if entry is not None and entry.order.permit.principal == principal\n",
        without="if entry is not None\n",
        caught_by=(f"{CANCEL}::test_in_a_group_it_is_whoever_says_it",),
    ),
    Fault(
        name="a cancel leaves what waits for a robot",
        file="linker/robot_queue.py",
        guard="if entry.order.permit.principal == principal]",
        without="if False]",
        caught_by=(f"{CANCEL}::test_what_waits_for_a_busy_robot_is_not_done",),
    ),
    Fault(
        name="what is on its way to the disk begins though it was cancelled",
        file="gateway/order_execution.py",
        guard="elif self._linker.cancels and self._linker.outdated(order):",
        without="elif False:",
        caught_by=(f"{CANCEL}::test_an_order_on_its_way_to_the_disk_does_not_begin",),
    ),
    Fault(
        name="what was received before a cancel and is read after it is done",
        file="gateway/cancel.py",
        guard="if recent and inbound.received_ns <= received_ns:",
        without="if False:",
        caught_by=(f"{CANCEL}::test_what_was_received_before_and_is_read_after_it_is_void",),
    ),
    Fault(
        name="what is admitted after a cancel that came while it was worked out begins",
        file="gateway/cancel.py",
        guard="if all(self._cancels.get(robot, 0) < cancelled(who, robot) for robot in robots):",
        without="if False:",
        caught_by=(
            f"{CANCEL}::test_many_that_are_looked_at_when_a_cancel_comes_do_not_begin",
            f"{CANCEL}::test_a_task_that_is_worked_out_when_a_cancel_comes_is_not_given",
        ),
    ),
    Fault(
        name="the others of a broadcast begin after a cancel",
        file="features/fleet/multi_robot.py",
        guard="                before.check((robot,))\n",
        without="",
        caught_by=(f"{CANCEL}::test_nobody_of_a_broadcast_begins_that_waits_for_the_disk_of_one",),
    ),
    Fault(
        name="a cancel leaves tasks, which take the next robot",
        file="features/fleet/__init__.py",
        guard="    pipeline.cancels.also(pausing.cancel)\n",
        without="",
        caught_by=(f"{CANCEL}::test_tasks_end_and_nobody_else_takes_them",),
    ),
    Fault(
        name="what does not come to rest by a cancel is left moving",
        file="gateway/cancel.py",
        guard="        if not rests:\n",
        without="        if False:\n",
        caught_by=(f"{CANCEL}::test_what_does_not_come_to_rest_is_stopped",),
    ),
    Fault(
        name="a question of before a cancel may still be answered",
        file="gateway/cancel.py",
        guard="self._rooms.authoriser.buttons.void(who, CONFIRMED)",
        without="pass",
        caught_by=(f"{CANCEL}::test_a_question_that_waits_for_an_answer_is_void",),
    ),
    Fault(
        name="I18 who stopped their own order resumes it over a channel that is too weak",
        file="gateway/resume.py",
        guard="            if not own or auth_context.channel < least:\n",
        without="            if not own:\n",
        caught_by=(
            f"{ASKED}::test_what_a_resume_wants_holds_for_ones_own_stop_and_not_for_the_operator",
        ),
    ),
    Fault(
        name="I18 care is accepted that nothing asks for",
        file="core/policy/validation.py",
        guard="                yield from _never_asked(place, text, care)\n",
        without="                pass\n",
        caught_by=(f"{ASKED}::test_what_care_accepts_is_asked_for_and_the_rest_is_refused",),
    ),
    Fault(
        name="whoever may move a robot may resume it, whoever stopped it",
        file="organiser/why_stopped.py",
        guard="own = stops[robot].own == principal",
        without="own = True",
        caught_by=(
            f"{OWN_STOP}::test_a_stop_of_everything_stays_though_ones_own_robot_is_among_it",
        ),
    ),
    Fault(
        name="I5 the operator's resume undoes a stop that came meanwhile",
        file="gateway/resume.py",
        guard="            await self._container.resume(cid, OPERATING, robot, generation)\n",
        without="            generation = self._stops[robot].generation\n"
        "            await self._container.resume(cid, OPERATING, robot, generation)\n",
        caught_by=(
            f"{SEVERAL}::test_a_stop_that_comes_meanwhile_is_not_undone_by_the_operators_resume",
        ),
    ),
    Fault(
        name="stopping what somebody else has stopped makes it one's own",
        file="gateway/stop.py",
        guard="if r in own and (not stops[r].latched or stops[r].own == by)]",
        without="if r in own]",
        caught_by=(f"{OWN_STOP}::test_what_others_stopped_besides_is_not_ones_own",),
    ),
    Fault(
        name="a later stop of somebody else leaves it one's own",
        file="core/stop_registry.py",
        guard='self.by, self.own = by, ""',
        without="self.by = by",
        caught_by=(f"{OWN_STOP}::test_what_others_stopped_besides_is_not_ones_own",),
    ),
    Fault(
        name="the stop of somebody else's order counts as one's own",
        file="gateway/order_execution.py",
        guard='            and principal in {"", entry.order.permit.principal}\n',
        without="",
        caught_by=(
            f"{OWN_STOP}::test_of_a_group_only_what_carries_ones_own_order_out_is_ones_own",
            f"{OWN_STOP}::test_the_stop_beneath_somebody_elses_order_stays",
        ),
    ),
)
