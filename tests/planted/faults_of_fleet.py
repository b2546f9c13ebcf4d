"""The guards around tasks: each promise of a fleet was seen broken."""

from __future__ import annotations

from tests.planted.faults import Fault

HISTORIES = "tests/core/fleet/test_histories.py::test_whatever_fails_no_promise_is_broken"
FOLLOW = "tests/rosic_sim/robots/machines/test_follow.py"
TIMES = "tests/features/fleet/test_mission_schedule.py"
REACTING = "core/fleet/transitions.py"
ASSIGNING = "tests/organiser/test_planning_solver.py"

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
        file="core/fleet/candidates.py",
        guard="if candidate.holder is not None and candidate.holder != task.author:",
        without="if False:",
        caught_by=(HISTORIES,),
    ),
    Fault(
        name="a task that waits is lost",
        file="core/fleet/state.py",
        guard=(
            "        elif task.state is TaskState.QUEUED:\n            self.waiting[key] = None\n"
        ),
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
        guard="        return _doubted(task, TaskReason.RESTARTED, now_ns)\n",
        without="        return _left(fleet, task, TaskReason.TAKEN, now_ns)\n",
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
        file="core/fleet/candidates.py",
        guard="            levels.setdefault(task.priority, []).append(task)",
        without="            levels.setdefault(0, []).append(task)",
        caught_by=(f"{ASSIGNING}::test_what_is_urgent_chooses_first_even_if_that_costs_more",),
    ),
)

TASKS = "tests/features/fleet/test_tasks.py"
EDGES = "tests/features/fleet/test_tasks_at_the_edges.py"
ROBOTS = "tests/features/fleet/test_fleet.py"
USAGE = "tests/features/fleet/test_usage.py"
COMPLETIONS = "tests/features/fleet/test_alternatives.py"

DISABLED = (
    f"{ROBOTS}::test_a_robot_that_is_disabled_in_the_middle_gives_its_task_away_and_stays_stopped"
)

OF_TASKS = (
    Fault(
        name="of those that begin together some go on without the one that does not",
        file="features/fleet/multi_robot.py",
        guard="                status.over = partial(start.ended, order)\n",
        without="                pass\n",
        caught_by=("tests/features/fleet/test_multi_robot.py",),
    ),
    Fault(
        name="I8 a task is carried out although whoever gave it may not any more",
        file="organiser/organiser.py",
        guard="        if principal in self.locked:  # since",
        without="        if False:  # since",
        caught_by=(f"{TASKS}::test_whoever_is_locked_lets_no_robot_do_anything",),
    ),
    Fault(
        name="I16 a task confirms by itself",
        file="features/fleet/task_parser.py",
        guard="        if organiser.rights.caution(robot, skill.id).needs:\n",
        without="        if False:\n",
        caught_by=(f"{TASKS}::test_what_wants_a_tap_is_not_given_as_a_task",),
    ),
    Fault(
        name="a lost robot's late answer moves it again",
        file="features/fleet/attempt.py",
        guard='        self._hands.stop_lane.stop_robots((robot,), "")\n',
        without="",
        caught_by=(
            f"{TASKS}::test_a_lost_robot_is_cut_off_and_its_late_answer_counts_for_nothing",
        ),
    ),
    Fault(
        name="a robot counts as at rest without being seen so",
        file="gateway/rest_wait.py",
        guard="    while linker.presence(robot).at_rest is False:\n",
        without="    while False:\n",
        caught_by=(f"{TASKS}::test_a_failure_moves_it_once_and_what_is_done_is_not_repeated",),
    ),
    Fault(
        name="a stop sends the task to the next robot",
        file="features/fleet/attempt.py",
        guard="    if stopped and ending not in {OrderEnding.DONE, OrderEnding.SENT}:\n",
        without="    if False:\n",
        caught_by=(f"{TASKS}::test_a_stop_is_meant_so_the_task_goes_nowhere_else_by_itself",),
    ),
    Fault(
        name="I5 whoever is disabled can be resumed",
        file="gateway/resume.py",
        guard="            self._check_not_barred(robot)\n            self._check_later",
        without="            self._check_later",
        caught_by=(DISABLED,),
    ),
    Fault(
        name="people are told to resume a robot that must stay stopped",
        file="organiser/why_stopped.py",
        guard="        if barred is not None:\n",
        without="        if False:\n",
        caught_by=(f"{ROBOTS}::test_nobody_is_offered_to_resume_what_has_to_stay_stopped",),
    ),
    Fault(
        name="what is offered for a task is a direct order",
        file="features/fleet/alternatives.py",
        guard="offers=(*found, *lacking.other)",
        without="offers=why.offers",
        caught_by=(f"{COMPLETIONS}::test_where_to_is_asked_for_the_task_and_a_tap_gives_it",),
    ),
    Fault(
        name="what a robot worked is forgotten when it is given an order at work",
        file="features/fleet/overview.py",
        guard="            if robot not in self._held and robot not in self._ordered:\n",
        without="            if True:\n",
        caught_by=(f"{USAGE}::test_each_second_counts_once_whatever_begins_and_ends_in_it",),
    ),
    Fault(
        name="one that is not ready, and the others begin",
        file="features/fleet/multi_robot.py",
        guard="        if any(states.values()):\n",
        without="        if False:\n",
        caught_by=(f"{ROBOTS}::test_together_all_begin_at_one_moment_or_none",),
    ),
    Fault(
        name="a shift is handed over to whoever says so",
        file="features/fleet/shift_handover.py",
        guard="offer.taker != asked.caller.principal",
        without="False",
        caught_by=(f"{ROBOTS}::test_an_offer_is_good_for_one_person_and_for_a_while",),
    ),
    Fault(
        name="I1 a message gives its task again after a crash",
        file="features/fleet/idempotency.py",
        guard="if cid.hex() in self._seen:",
        without="if False:",
        caught_by=(f"{TASKS}::test_the_same_message_has_its_effect_once_whatever_crashes_between",),
    ),
    Fault(
        name="I9 a task is given to a robot before that is on disk",
        file="features/fleet/dispatcher.py",
        guard="            if happened:\n",
        without="            if True:\n",
        caught_by=(f"{TASKS}::test_nothing_moves_that_could_not_be_written_down",),
    ),
    Fault(
        name="I11 everybody reads what somebody has said for a task",
        file="features/fleet/integration.py",
        guard="        if who == task.author:\n",
        without="        if True:\n",
        caught_by=(f"{ROBOTS}::test_what_somebody_has_said_is_read_by_them_alone",),
    ),
    Fault(
        name="a task that was cancelled while it was claimed moves its robot",
        file="features/fleet/attempt.py",
        guard="        wanted = asker.wanted()\n",
        without="        wanted = True\n",
        caught_by=(
            f"{EDGES}::test_a_task_that_is_cancelled_while_it_is_claimed_moves_nothing",
            f"{EDGES}::test_a_task_that_is_paused_while_it_is_claimed_goes_on_with_one_robot",
        ),
    ),
    Fault(
        name="I2 a task that was sent long ago is given",
        file="gateway/requests.py",
        guard="    if is_missed(inbound):\n        raise",
        without="    if False:\n        raise",
        caught_by=(f"{EDGES}::test_a_task_that_waited_on_the_way_here_is_not_given",),
    ),
    Fault(
        name="I5 a task begins while a stop is still to come",
        file="features/fleet/dispatcher.py",
        guard="        while self.behind():  #",
        without="        while False:  #",
        caught_by=(f"{EDGES}::test_no_task_begins_before_what_was_sent_meanwhile_has_come",),
    ),
    Fault(
        name="a deadline of a mission is forgotten over a restart",
        file="core/fleet/state.py",
        guard="        if (task.due.lasts_ns or task.due.at_ns) and not task.over:\n",
        without="        if task.due.lasts_ns and not task.over:\n",
        caught_by=(
            f"{TIMES}::test_a_deadline_goes_on_over_a_restart_also_while_nothing_runs",
            f"{TIMES}::test_a_mission_that_is_late_is_said_once_and_the_rest_is_cancelled",
        ),
    ),
    Fault(
        name="a mission that is late is said again and again",
        file="core/fleet/transitions.py",
        guard="    if task.over or known:\n",
        without="    if task.over:\n",
        caught_by=(
            f"{TIMES}::test_what_is_late_as_a_whole_is_said_once_and_goes_on_if_nothing_else_is_written",
        ),
    ),
    Fault(
        name="a part is late before it could begin",
        file="features/fleet/monitor.py",
        guard="if not task.due.lasts_ns or not fleet.ready(task):",
        without="if not task.due.lasts_ns:",
        caught_by=(
            f"{TIMES}::test_a_part_is_late_from_when_it_could_begin_and_what_is_written_happens",
        ),
    ),
    Fault(
        name="a value of a mission is out of its bounds",
        file="core/fleet/template.py",
        guard="not quantity.min - edge <= value <= quantity.max + edge:",
        without="value != value:",
        caught_by=(f"{TIMES}::test_a_value_that_is_missing_wrong_or_unknown_begins_nothing",),
    ),
    Fault(
        name="a drone that follows does not keep up with whom it follows",
        file="rosic_sim/robots/machines/following.py",
        guard="flight.chase(place, self._velocity())",
        without="flight.chase(place)",
        caught_by=(f"{FOLLOW}::test_it_keeps_its_distance_and_bearing_while_the_leader_moves",),
    ),
    Fault(
        name="a stop of the leader is taken for the end of its order",
        file="rosic_sim/robots/machines/following.py",
        guard="if seen is None or seen.landing or not seen.flying:\n            return said(",
        without="if seen is None:\n            return said(",
        caught_by=(f"{FOLLOW}::test_a_stop_of_the_leader_ends_it_and_the_follower_hovers",),
    ),
    Fault(
        name="drones follow each other in a circle",
        file="rosic_sim/robots/machines/following.py",
        guard="        if seen.leader == robot:\n            return True\n",
        without="",
        caught_by=(f"{FOLLOW}::test_one_behind_the_other_is_a_row_and_a_circle_is_none",),
    ),
    Fault(
        name="a drone follows for ever",
        file="rosic_sim/robots/machines/following.py",
        guard="return self._busy and not seen.busy",
        without="return False",
        caught_by=(f"{FOLLOW}::test_it_keeps_its_distance_and_bearing_while_the_leader_moves",),
    ),
)
