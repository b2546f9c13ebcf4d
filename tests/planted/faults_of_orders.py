"""Guards of one order on its way: whose it is, in which turn, and what outlives a restart."""

from __future__ import annotations

from tests.planted.faults import BUTTONS, GATE, STOPPING, WAY, Fault

ROBOTS = "tests/conformance/test_robots.py"
MISSIONS = "tests/features/fleet/test_missions.py"
AGREED = "tests/gateway/test_agreed_acts.py"
VICTIMS = "tests/features/access/test_victims.py"
MAILBOX = "tests/linker/test_robot_queue.py"

LATE = "tests/gateway/test_suspended.py"

OF_ORDERS = (
    Fault(
        name="I2 only the monotonic clock ends an order at the robot",
        file="core/order_gate.py",
        guard="late = now_ns > order.deadline_ns or wall_ns > order.expires_ns",
        without="late = now_ns > order.deadline_ns",
        caught_by=(
            f"{GATE}::test_no_history_lets_a_wrong_order_act",
            f"{LATE}::test_wherever_it_waits_nothing_moves_after_a_pause",
        ),
    ),
    Fault(
        name="I2 only the wall clock ends an order at the robot",
        file="core/order_gate.py",
        guard="late = now_ns > order.deadline_ns or wall_ns > order.expires_ns",
        without="late = wall_ns > order.expires_ns",
        caught_by=(f"{GATE}::test_no_history_lets_a_wrong_order_act",),
    ),
    Fault(
        name="I2 an order that waited too long is dispatched",
        file="linker/linker.py",
        guard="if clock.monotonic_ns() > order.deadline_ns or clock.wall_ns() > order.expires_ns:",
        without="if False:",
        caught_by=(f"{LATE}::test_what_is_late_is_not_handed_to_the_robot",),
    ),
    Fault(
        name="I3 a lower number that arrives later acts",
        file="core/order_gate.py",
        guard="if order.n <= self.n:",
        without="if order.n == self.n:",
        caught_by=(f"{GATE}::test_no_history_lets_a_wrong_order_act", f"{ROBOTS}::TestMemory"),
    ),
    Fault(
        name="what hears of a common start too late begins all the same",
        file="core/order_gate.py",
        guard=" or (together and misses_start(order, now_ns, wall_ns))",
        without="",
        caught_by=("tests/robots/test_common_start.py",),
    ),
    Fault(
        name="I5 a stop that is old is not applied",
        file="gateway/pipeline.py",
        guard="if urgent is not None and await",
        without=(
            "if urgent is not None and inbound.sent_ns >= inbound.listening_since_ns and await"
        ),
        caught_by=(f"{STOPPING}::test_a_stop_sent_while_nobody_listened_is_applied_however_old",),
    ),
    Fault(
        name="I8 what somebody has no right to is done",
        file="organiser/organiser.py",
        guard=(
            "        if isinstance(decision, Deny):\n"
            "            raise self._refusing.denial(decision)\n"
            "        if decision.needs:"
        ),
        without=(
            "        if isinstance(decision, Deny):\n            return\n        if decision.needs:"
        ),
        caught_by=(f"{WAY}::test_a_viewer_reads_and_does_not_move",),
    ),
    Fault(
        name="I8 nobody's orders are counted",
        file="organiser/rate_limits.py",
        guard="            if wait_s:\n                return self._refusal(kind, name, wait_s)\n",
        without="",
        caught_by=("tests/gateway/test_limits.py",),
    ),
    Fault(
        name="I16 a tap does what its words mean by then",
        file="gateway/agreement.py",
        guard="        if now == act:\n            return",
        without="        if True:\n            return",
        caught_by=(f"{AGREED}::test_what_has_changed_is_said",),
    ),
    Fault(
        name="I16 a task is bound to nothing of what its robots do",
        file="gateway/agreement.py",
        guard="elif isinstance(line, CommandLine) and line.verb in TASKS:",
        without="elif False:",
        caught_by=(f"{AGREED}::test_a_task_is_for_those_who_could_do_it_when_it_was_agreed_to",),
    ),
    Fault(
        name="I16 a mission is bound to nothing of what its robots do",
        file="features/fleet/agreement_steps.py",
        guard='self._tasks.asked if verb == "task" else self._missions.asked',
        without='self._tasks.asked if verb == "task" else (lambda *_: [])',
        caught_by=(f"{MISSIONS}::test_a_mission_begins_by_a_button_as_it_was_shown_or_not_at_all",),
    ),
    Fault(
        name="I16 what two agreed to is not compared with what is done",
        file="gateway/confirmation.py",
        guard="or request.act.command != text or request.act.digest != act:",
        without="or request.act.command != text:",
        caught_by=(f"{AGREED}::test_an_agreement_counts_for_its_own_act_alone",),
    ),
    Fault(
        name="I16 a second person agrees to what is something else by then",
        file="gateway/confirmation.py",
        guard="if self._agreements.is_current(request.act, request.line, request.caller):\n",
        without="if True:\n",
        caught_by=(
            (
                "tests/gateway/test_second_person.py"
                "::test_whose_limits_shrank_meanwhile_agrees_to_nothing"
            ),
        ),
    ),
    Fault(
        name="I16 what was agreed to under other rules goes on waiting for its turn",
        file="organiser/refusals.py",
        guard="if policy <= epoch or AGREED.isdisjoint(allowed.care):",
        without="if True:",
        caught_by=(
            f"{AGREED}::test_an_order_that_waited_while_the_rules_changed_counts_as_agreed_to_no_more",
        ),
    ),
    Fault(
        name="what somebody has said is lowered in silence",
        file="gateway/limit_clamping.py",
        guard="if limit.parameter in given or not isinstance(value, int | float):",
        without="if not isinstance(value, int | float):",
        caught_by=(
            "tests/gateway/test_limit_clamping.py::test_what_was_said_above_the_limit_is_refused_as_ever",
        ),
    ),
    Fault(
        name="a word in the line confirms that somebody's access ends",
        file="features/access/revoke_lock.py",
        guard="        if asked.act != agreed:\n            self._check_revocable(found)",
        without=(
            '        if asked.act != agreed and not asked.rest.endswith("confirmed"):\n'
            "            self._check_revocable(found)"
        ),
        caught_by=(f"{VICTIMS}::test_who_is_called_confirmed_ends_nobodys_access",),
    ),
    Fault(
        name="whoever has the longest name is meant, unasked",
        file="features/access/grant.py",
        guard="        if len(found) == 1:\n            return found[0]",
        without="        if found:\n            return found[0]",
        caught_by=(f"{VICTIMS}::test_a_line_that_can_mean_two_people_is_asked_about",),
    ),
    Fault(
        name="I10 a stop is kept in memory only",
        file="linker/linker.py",
        guard="*(self._latch.write(s.robot, s.generation, latched=True) for s in stops),",
        without="",
        caught_by=(f"{STOPPING}::test_a_stop_that_only_the_stop_file_knows_survives_a_restart",),
    ),
    Fault(
        name="a stop is said to be at rest before that is measured",
        file="rosic_sim/robots/robot.py",
        guard=(
            "if self.machine.at_rest() or past_ns > limit_ns:\n"
            "                return past_ns / 1e9, self.machine.at_rest()"
        ),
        without="if True:\n                return past_ns / 1e9, True",
        caught_by=("tests/rosic_sim/robots/test_simulation_loop.py",),
    ),
    Fault(
        name="I13 fences begin anew after a restart",
        file="organiser/organiser.py",
        guard="{r: Lease(fence) for r, fence",
        without="{r: Lease(0) for r, fence",
        caught_by=(f"{STOPPING}::test_numbers_and_fences_go_on_after_a_restart",),
    ),
    Fault(
        name="I13 a stop that only the record knows is forgotten by a restart",
        file="app/robot_startup.py",
        guard="if generation > joined.get(robot, (0, False))[0]:",
        without="if False:",
        caught_by=(f"{STOPPING}::test_a_stop_that_only_the_record_knows_survives_a_restart",),
    ),
    Fault(
        name="I13 an older stop is written over a younger one",
        file="stores/stop_latch.py",
        guard="        elif state.generation < known.generation:\n            return\n",
        without="",
        caught_by=("tests/stores/test_stop_latch.py",),
    ),
    Fault(
        name="I14 a tap on what nobody was shown is taken for a command",
        file="authoriser/button_tokens.py",
        guard='            raise Expired(said("This button is no longer good. Nothing was done."))',
        without="            return nonce",
        caught_by=(f"{BUTTONS}::test_a_tap_on_what_was_never_shown_does_nothing",),
    ),
    Fault(
        name="I15 a robot's queue is as long as people make it",
        file="linker/robot_queue.py",
        guard="if len(self._waiting) >= profile.queue_length:",
        without="if False:",
        caught_by=(f"{MAILBOX}::test_a_full_queue_refuses",),
    ),
    Fault(
        name="I15 what was settled is remembered for ever",
        file="stores/memory.py",
        guard="            self._older = self._ids\n",
        without="            self._older |= self._ids\n",
        caught_by=("tests/stores/test_memory.py",),
    ),
)
