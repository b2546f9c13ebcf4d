"""The guards around planned orders, places, and missions that are put together in a chat."""

from __future__ import annotations

from tests.planted.faults import Fault

RUNS = "features/scheduled_orders/runs.py"
SCHEDULE = "features/scheduled_orders/schedule.py"
COMMANDS = "features/scheduled_orders/commands.py"
AT_ITS_TIME = "tests/features/scheduled_orders/test_at_its_time.py::"
PLANNING = "tests/features/scheduled_orders/test_planning.py::"
PLACES = "tests/features/places/test_places.py::"
EDITOR = "tests/features/fleet/test_mission_builder.py::"
COSTS = "tests/features/scheduled_orders/test_clocks_and_costs.py::"

OF_SCHEDULING = (
    Fault(
        name="a plan does what its words mean by then",
        file=RUNS,
        guard="        if act.digest[:DIGEST_BYTES] != due.order.digests[step]:\n",
        without="        if False:\n",
        caught_by=(
            AT_ITS_TIME + "test_what_would_be_something_else_by_then_is_not_done",
            AT_ITS_TIME + "test_a_group_that_has_another_member_by_then_is_not_moved",
        ),
    ),
    Fault(
        name="a plan goes on after a stop that was resumed",
        file=RUNS,
        guard="if stopped is not None and stopped.generation != agreed.get(robot, -1):\n",
        without="if False:\n",
        caught_by=(
            AT_ITS_TIME + "test_what_was_planned_before_a_stop_is_not_done_though_it_is_resumed",
            AT_ITS_TIME + "test_a_stop_between_two_steps_is_meant_for_those_that_follow",
        ),
    ),
    Fault(
        name="a plan begins without the robot of its next step, which was stopped",
        file=RUNS,
        guard="        for robot in dict.fromkeys((*line.robots, *agreed)):\n",
        without="        for robot in line.robots:\n",
        caught_by=(AT_ITS_TIME + "test_a_plan_is_not_begun_once_any_of_its_robots_was_stopped",),
    ),
    Fault(
        name="a planned order is as fresh as if it were said at its time",
        file=RUNS,
        guard="        age_ns = 0 if step else max(0, wall_ns - due.at_ns)\n",
        without="        age_ns = 0\n",
        caught_by=(AT_ITS_TIME + "test_an_order_is_as_old_as_its_time",),
    ),
    Fault(
        name="what was slept through is done late",
        file=SCHEDULE,
        guard="now_ns - due.at_ns > due.order.lives_ns",
        without="now_ns < 0",
        caught_by=(AT_ITS_TIME + "test_it_is_never_late",),
    ),
    Fault(
        name="a step begins though its author has cancelled",
        file=RUNS,
        guard="        if run.cancelled:\n            raise OrderVoid(CANCELLED_BEFORE)\n",
        without="        pass\n",
        caught_by=(AT_ITS_TIME + "test_cancelled_by_its_number_it_begins_no_further_step",),
    ),
    Fault(
        name="a step follows one that was not carried out",
        file=RUNS,
        guard="if not all(outcome.ending in CARRIED_OUT for outcome in ended):",
        without="if not ended:",
        caught_by=(AT_ITS_TIME + "test_what_is_not_carried_out_ends_it",),
    ),
    Fault(
        name="a plan begins while a stop may be on its way",
        file=RUNS,
        guard="        while any(map(catching_up, self._hands.reach.messengers)):\n",
        without="        while False:\n",
        caught_by=(AT_ITS_TIME + "test_nothing_begins_before_what_was_sent_meanwhile_has_come",),
    ),
    Fault(
        name="what was planned before a lock is done once it is lifted",
        file="features/scheduled_orders/__init__.py",
        guard="            if who in locked or not authoriser.has_access(who):\n",
        without="            if False:\n",
        caught_by=(
            AT_ITS_TIME + "test_what_was_planned_before_a_lock_is_not_done_though_it_is_lifted",
        ),
    ),
    Fault(
        name="a plan stands by words",
        file=COMMANDS,
        guard="            raise NotPermitted(words.ONLY_BY_TAP)\n",
        without="            pass\n",
        caught_by=(PLANNING + "test_a_plan_stands_by_the_same_person_once_and_not_by_words",),
    ),
    Fault(
        name="a plan stands though the rules have changed since it was shown",
        file=COMMANDS,
        guard="            if not self._agreements.is_current(act, line, asked.caller):\n",
        without="            if False:\n",
        caught_by=(PLANNING + "test_whoever_taps_agrees_to_what_was_shown_under_the_same_rules",),
    ),
    Fault(
        name="somebody takes back what another has planned",
        file=COMMANDS,
        guard="        if order.author != who and not assigns:\n",
        without="        if False:\n",
        caught_by=(PLANNING + "test_others_see_and_cancel_nothing_but_whoever_assigns_tasks_may",),
    ),
    Fault(
        name="the number of somebody's plans is not bounded",
        file=COMMANDS,
        guard="        if len(self._schedule.of(who)) >= OF_ONE_AT_MOST:\n",
        without="        if False:\n",
        caught_by=(PLANNING + "test_one_person_plans_so_much_and_no_more",),
    ),
    Fault(
        name="what wants a tap each time is planned",
        file="features/scheduled_orders/order_plan.py",
        guard="            if rooms.organiser.rights.caution(robot, skill.id).needs:\n",
        without="            if False:\n",
        caught_by=(PLANNING + "test_what_wants_a_tap_each_time_cannot_be_planned",),
    ),
    Fault(
        name="times that count no more are kept",
        file=SCHEDULE,
        guard="        if len(self._times) > 2 * len(self.orders) + STALE_AT_MOST:\n",
        without="        if False:\n",
        caught_by=(COSTS + "test_what_was_planned_and_taken_back_leaves_nothing_that_grows",),
    ),
    Fault(
        name="anybody keeps places for a robot",
        file="features/places/commands.py",
        guard="        self._rooms.organiser.check_word(asked.caller, robot, PLACES)\n",
        without="",
        caught_by=(PLACES + "test_whoever_has_the_right_keeps_places_and_nobody_else",),
    ),
    Fault(
        name="a place is called like something else",
        file="features/places/commands.py",
        guard="        if urgent or taken or number or name in REMOVE or means_else(name):\n",
        without="        if False:\n",
        caught_by=(PLACES + "test_what_names_no_place_is_said_in_one_sentence",),
    ),
    Fault(
        name="a place is kept of a robot that moves",
        file="features/places/place_book.py",
        guard="    if seen.moves:\n",
        without="    if False:\n",
        caught_by=(
            PLACES + "test_nothing_is_kept_of_a_robot_that_moves_or_does_not_say_where_it_is",
        ),
    ),
    Fault(
        name="a robot goes to the place of another",
        file="core/language/kept_places.py",
        guard="    if not known or len(line.robots) > 1:\n",
        without="    if not known:\n",
        caught_by=(PLACES + "test_a_group_goes_to_no_place_by_its_name",),
    ),
    Fault(
        name="a step of a mission is done while it is put together",
        file="gateway/chat_handler.py",
        guard="        elif self._hooks.drafting:\n",
        without="        elif False:\n",
        caught_by=(EDITOR + "test_lines_become_steps_and_are_saved_and_started",),
    ),
    Fault(
        name="whose draft it is does not matter",
        file="gateway/chat_handler.py",
        guard="        if where not in self._hooks.drafting:\n",
        without="        if False:\n",
        caught_by=(EDITOR + "test_only_orders_typed_there_by_the_same_person_are_steps",),
    ),
    Fault(
        name="a draft that was left lying takes lines in",
        file="features/fleet/mission_builder.py",
        guard="        if now_ns - draft.touched_ns > LEFT_AFTER_NS:\n",
        without="        if False:\n",
        caught_by=(EDITOR + "test_what_was_left_lying_takes_no_line_in_and_does_none",),
    ),
    Fault(
        name="anybody saves missions for everybody",
        file="features/fleet/mission_builder.py",
        guard="            self._check_shares(who)\n",
        without="            pass\n",
        caught_by=(EDITOR + "test_a_mission_is_its_authors_or_with_the_right_everybodys",),
    ),
)
