"""The guards that matter, each taken out by one small change to the source.

A check proves something only once it has been seen to fail: every fault names the tests that must
fail because of it. The product itself has no switch for any of this.
"""

from __future__ import annotations

from pathlib import Path

import msgspec

WAY = "tests/gateway/test_pipeline.py"
STOPPING = "tests/gateway/test_stopping.py"
BUTTONS = "tests/gateway/test_buttons.py"
EDGES = "tests/gateway/test_edges.py"
RIGHTS = "tests/gateway/test_rights.py"
ONE_LEASE = "tests/gateway/test_one_lease.py"
TURNED_AWAY = "tests/gateway/test_turned_away.py"
REDEEMERS = "tests/gateway/test_redeemers.py"
WRONG = "tests/gateway/test_wrong_rights_and_times.py"
ISOLATION = "tests/gateway/test_isolation.py"
HUNG = "tests/gateway/test_hung.py"
ENDING = "tests/features/access/test_revoke_lock.py"
GATE = "tests/core/test_order_gate.py"


def place(file: str) -> Path:
    """Return where a file of a fault is, below ``src``."""
    return Path(file) if file.startswith("rosic_sim/") else Path("rosic", file)


class Fault(msgspec.Struct, frozen=True, kw_only=True):
    """One planted fault.

    Attributes:
        file: Below ``src/rosic``, or below ``src`` where that begins with ``rosic_sim``.
        guard: The text that is there, exactly once.
        without: What stands there instead.
        caught_by: Ids of tests of which at least one must fail.
    """

    name: str
    file: str
    guard: str
    without: str
    caught_by: tuple[str, ...]


FAULTS = (
    Fault(
        name="I1 dedup off",
        file="stores/memory.py",
        guard="if cid in young or cid in older or (fresh is not None and cid in fresh):",
        without="if False:",
        caught_by=(f"{WAY}::test_the_same_message_twice_moves_once_and_is_answered_once",),
    ),
    Fault(
        name="I1 the order number is ignored at the robot",
        file="core/order_gate.py",
        guard="if order.n <= self.n:",
        without="if False:",
        caught_by=(
            f"{GATE}::test_no_history_lets_a_wrong_order_act",
            "tests/conformance/test_robots.py::TestMemory",
        ),
    ),
    Fault(
        name="I2 expiry ignored at admission and at the robot",
        file="gateway/requests.py",
        guard="if now_ns > request.deadline_ns:",
        without="if False:",
        caught_by=(f"{WAY}::test_motion_older_than_its_lifetime_expires",),
    ),
    Fault(
        name="I2 expiry ignored at the robot",
        file="core/order_gate.py",
        guard="late = now_ns > order.deadline_ns or wall_ns > order.expires_ns",
        without="late = False",
        caught_by=(f"{GATE}::test_no_history_lets_a_wrong_order_act",),
    ),
    Fault(
        name="I4 fence ignored",
        file="core/order_gate.py",
        guard="if permit.fence < self.fence:",
        without="if False:",
        caught_by=(f"{GATE}::test_no_history_lets_a_wrong_order_act",),
    ),
    Fault(
        name="I4 the fence stands still when the holder changes",
        file="core/lease.py",
        guard="            self.fence += 1\n",
        without="",
        caught_by=(f"{WAY}::test_a_robot_has_one_holder_until_it_has_been_idle",),
    ),
    Fault(
        name="I5 a stop is not latched at the robot",
        file="core/order_gate.py",
        guard="            self.latched = True\n",
        without="",
        caught_by=(f"{STOPPING}::test_a_named_stop_stops_only_those",),
    ),
    Fault(
        name="I5 stop generation ignored",
        file="core/order_gate.py",
        guard="if self.latched or permit.stop_generation < self.generation:",
        without="if self.latched:",
        caught_by=(f"{GATE}::test_no_history_lets_a_wrong_order_act",),
    ),
    Fault(
        name="I5 a stop is queued like everything else",
        file="gateway/pipeline.py",
        guard="if urgent is not None and await self._urgent.take(messenger, inbound, urgent):",
        without=(
            "if urgent is not None:\n            await self._chat_locks.take(inbound.chat)\n"
            "            await self._urgent.take(messenger, inbound, urgent)"
        ),
        caught_by=(f"{STOPPING}::test_a_stop_does_not_wait_for_its_chat",),
    ),
    Fault(
        name="I5 whoever may see a robot may resume it",
        file="organiser/organiser.py",
        guard="decision = self.decision(caller, robot, word, auth_context=auth_context)",
        without='decision = self.decision(caller, robot, "read", auth_context=auth_context)',
        caught_by=(f"{STOPPING}::test_after_a_stop_nothing_moves_until_somebody_who_may_resumes",),
    ),
    Fault(
        name="I8 policy epoch ignored",
        file="linker/linker.py",
        guard=" or permit.epoch != self._policy.epoch:",
        without=":",
        caught_by=(
            f"{WAY}::test_a_right_that_ends_while_an_order_waits_is_asked_again",
            "tests/linker/test_robot_queue.py",
        ),
    ),
    Fault(
        name="I9 the order is relayed though the claim failed",
        file="container/container.py",
        guard=(
            "            raise RecordUnavailable(\n                said(\n"
            '                    "I cannot write down what'
        ),
        without=(
            "            return tuple(orders)\n"
            "            raise RecordUnavailable(\n                said(\n"
            '                    "I cannot write down what'
        ),
        caught_by=(
            f"{STOPPING}::test_without_a_record_nothing_moves_and_it_works_again_by_itself",
        ),
    ),
    Fault(
        name="I10 a stop waits for the record",
        file="gateway/stop.py",
        guard="        halting = self.stop_robots(robots, by, own_of(by) if by else ())\n",
        without=(
            "        await self._store.write(Stopped(robot=robots[0], generation=0, principal=by,"
            " at_ns=0))\n        halting = self.stop_robots(robots, by)\n"
        ),
        caught_by=(f"{STOPPING}::test_a_stop_needs_no_record_and_says_what_was_not_written",),
    ),
    Fault(
        name="I12 two holders",
        file="organiser/organiser.py",
        guard="or not (holder is None or holder == caller.principal):",
        without=":",
        caught_by=(f"{WAY}::test_a_robot_has_one_holder_until_it_has_been_idle",),
    ),
    Fault(
        name="I12 a robot that is asked for many times at once has many holders",
        file="organiser/organiser.py",
        guard="or not (holder is None or holder == caller.principal):",
        without=":",
        caught_by=(ONE_LEASE,),
    ),
    Fault(
        name="I12 a lease in use counts as one that has idled",
        file="core/lease.py",
        guard="if self.holder is None or self.active:",
        without="if self.holder is None:",
        caught_by=(ONE_LEASE,),
    ),
    Fault(
        name="I13 numbers begin anew after a restart",
        file="app/gateway.py",
        guard="memory.numbers.get(robot, (0, 0))",
        without="(0, 0)",
        caught_by=(f"{STOPPING}::test_numbers_and_fences_go_on_after_a_restart",),
    ),
    Fault(
        name="I16 a button works twice",
        file="authoriser/button_tokens.py",
        guard="        if bound.principal != ANYBODY:\n            del self._bound[nonce]\n",
        without="",
        caught_by=(f"{BUTTONS}::test_a_button_works_once",),
    ),
    Fault(
        name="I16 anybody's tap counts",
        file="authoriser/button_tokens.py",
        guard="if bound.principal not in {principal, ANYBODY} or bound.chat != inbound.chat.id:",
        without="if False:",
        caught_by=(f"{BUTTONS}::test_another_persons_tap_does_nothing_and_uses_nothing_up",),
    ),
    Fault(
        name="I16 a button survives a gap",
        file="authoriser/button_tokens.py",
        guard="missed = bound.issued.wall_ns < inbound.listening_since_ns and not bound.still",
        without="missed = False",
        caught_by=(f"{BUTTONS}::test_a_button_is_dead_after_a_gap_in_listening",),
    ),
    Fault(
        name="I17 edited and forwarded messages are accepted",
        file="gateway/pipeline.py",
        guard="if inbound.standing is not FRESH and inbound.standing is not UNVERIFIED:",
        without="if False:",
        caught_by=(f"{WAY}::test_what_is_not_fresh_changes_nothing",),
    ),
    Fault(
        name="a backlog moves robots",
        file="gateway/requests.py",
        guard="if request.skill.actuates and inbound.sent_ns < inbound.listening_since_ns:",
        without="if False:",
        caught_by=(f"{WAY}::test_what_was_sent_while_nobody_listened_moves_nothing",),
    ),
    Fault(
        name="identity by display name",
        file="authoriser/directory.py",
        guard="        principal = self._at.get((address.platform, address.account))\n",
        without="        principal = next(iter(self._at.values()), None)\n",
        caught_by=(f"{WAY}::test_a_strangers_message_gets_one_polite_line_and_nothing_else",),
    ),
    Fault(
        name="after a crash a robot in doubt moves on",
        file="gateway/recovery.py",
        guard="if exists(order.robot):",
        without="if False:",
        caught_by=(
            f"{STOPPING}::test_a_claim_without_an_outcome_is_unknown_held_and_never_repeated",
        ),
    ),
    Fault(
        name="I5 an older resume undoes a younger stop",
        file="gateway/resume.py",
        guard="if inbound.received_ns <= stopped_ns or inbound.sent_ns + SECOND_NS < stopped_ns:",
        without="if False:",
        caught_by=(f"{STOPPING}::test_a_resume_that_a_later_stop_overtook_undoes_nothing",),
    ),
    Fault(
        name="I7 an ending is told before it is on disk",
        file="gateway/order_execution.py",
        guard="conclude(running.order, outcome, words, at_ns, running.concluded)",
        without=(
            "conclude(running.order, outcome, words, at_ns, lambda: None)"
            "\n        running.concluded()"
        ),
        caught_by=(f"{WAY}::test_an_ending_is_not_told_before_it_is_on_disk",),
    ),
    Fault(
        name="I5 what waited over a stop moves after the resume",
        file="gateway/requests.py",
        guard=(
            "if inbound.received_ns <= stopped.at_ns and not stopped.latched "
            "and request.skill.actuates:"
        ),
        without="if False:",
        caught_by=("tests/gateway/test_waited.py",),
    ),
    Fault(
        name="L1 a message that shows an ending is not on disk before it does",
        file="gateway/delivery/sender.py",
        guard="if order_message.ending:",
        without="if order_message.untold:",
        caught_by=(f"{EDGES}::test_a_message_is_on_disk_before_it_shows_an_ending",),
    ),
    Fault(
        name="I7 a claim that nobody carries out is left open",
        file="container/container.py",
        guard="                self._disown(orders, NEVER_BEGUN)\n",
        without="                pass\n",
        caught_by=(
            f"{EDGES}::test_a_claim_under_way_when_the_gateway_closes_is_known_not_to_have_moved",
        ),
    ),
    Fault(
        name="L1 an order is cut off before its first step",
        file="gateway/order_execution.py",
        guard="worker.task is not None and begun:",
        without="worker.task is not None:",
        caught_by=(f"{EDGES}::test_an_order_that_has_not_begun_when_the_gateway_closes_is_told",),
    ),
    Fault(
        name="L1 a running that nobody can be told of takes room for ever",
        file="gateway/recovery.py",
        guard="self._let_go(order)  # erased with its container: there is nobody to tell",
        without="pass",
        caught_by=(f"{EDGES}::test_a_life_that_nobody_can_be_told_of_is_closed_at_the_next_start",),
    ),
    Fault(
        name="I8 a lock keeps nobody out",
        file="gateway/chat_handler.py",
        guard="        self._rooms.organiser.check_unlocked(caller)\n",
        without="",
        caught_by=(RIGHTS,),
    ),
    Fault(
        name="I8 what somebody locked out moves goes on",
        file="gateway/policy_service.py",
        guard="if locked or gone or lost:",
        without="if gone or lost:",
        caught_by=(RIGHTS,),
    ),
    Fault(
        name="I12 a robot is taken over without a word",
        file="organiser/organiser.py",
        guard="if decision.preempts and self.holder(request.robot) != caller.principal:",
        without="if False:",
        caught_by=(RIGHTS,),
    ),
    Fault(
        name="I8 somebody else's time keeps nobody out",
        file="organiser/organiser.py",
        guard="            return 0\n        return self.calendar.answer_ends_ns(",
        without="            pass\n        return self.calendar.answer_ends_ns(",
        caught_by=(RIGHTS,),
    ),
    Fault(
        name="I16 what has to be confirmed first is done",
        file="organiser/organiser.py",
        guard="if decision.needs:",
        without="if False:",
        caught_by=(RIGHTS,),
    ),
    Fault(
        name="I8 a right that is limited counts as one without limits",
        file="organiser/organiser.py",
        guard="plain = right is not None and right.plain",
        without="plain = right is not None",
        caught_by=(RIGHTS,),
    ),
    Fault(
        name="nobody hears of a code that a group was shown",
        file="authoriser/enrolment.py",
        guard='return EnrolmentRefused("code-in-group", words.IN_GROUP, alarm, records)',
        without='return EnrolmentRefused("code-in-group", words.IN_GROUP, None, records)',
        caught_by=(TURNED_AWAY,),
    ),
    Fault(
        name="a phone's code is good twice",
        file="authoriser/two_factor.py",
        guard="[step for step in steps if step > self._last_step(principal)]",
        without="list(steps)",
        caught_by=(TURNED_AWAY,),
    ),
    Fault(
        name="nobody counts taps on somebody else's button",
        file="authoriser/button_tokens.py",
        guard='            self._count("button-other")\n',
        without="",
        caught_by=(TURNED_AWAY,),
    ),
    Fault(
        name="I11 one person's settings count for others",
        file="container/preferences.py",
        guard="return self._set.get(principal, UNSET)",
        without="return next(iter(self._set.values()), UNSET)",
        caught_by=(ISOLATION,),
    ),
    Fault(
        name="I11 what somebody keeps can be read without being let",
        file="container/shared_data.py",
        guard="return reader == owner or self._sees_robot(reader, owner)",
        without="return True",
        caught_by=(ISOLATION,),
    ),
    Fault(
        name="a lock waits for the disk",
        file="gateway/transactions.py",
        guard=("        self._apply(records)\n        if self._one.locked():\n"),
        without=(
            "        await self._store.write(*records)\n        self._apply(records)\n"
            "        if self._one.locked():\n"
        ),
        caught_by=(f"{WRONG}::test_a_full_disk_keeps_nobody_from_being_locked",),
    ),
    Fault(
        name="I8 a revocation waits behind somebody else's hung write",
        file="gateway/transactions.py",
        guard=(
            "        self._apply(records)\n        if self._one.locked():\n"
            "            self._taken.append(again)\n"
        ),
        without="        async with self._one:\n            self._apply(records)\n",
        caught_by=(
            f"{ENDING}::test_revoking_waits_for_nobodys_disk_and_is_answered_in_a_second",
            "tests/cli/test_access.py::test_a_revocation_waits_for_no_other_change",
        ),
    ),
    Fault(
        name="I8 what was given before a revocation and written after it is theirs",
        file="gateway/transactions.py",
        guard="            self._taken.append(again)\n",
        without="            pass\n",
        caught_by=(
            f"{ENDING}::test_what_is_given_too_late_outlives_no_revoking",
            f"{ENDING}::test_an_unlocking_that_is_written_too_late_undoes_no_later_lock",
        ),
    ),
    Fault(
        name="L1 nobody is told that their change waits for a disk that hangs",
        file="app/gateway.py",
        guard="            changes_late=lambda: access.changes.late,\n",
        without="            changes_late=lambda: False,\n",
        caught_by=(
            f"{HUNG}::test_whoever_changes_something_is_told_that_it_waits_and_then_how_it_ended",
        ),
    ),
    Fault(
        name="changes are made side by side, and two come in by one code",
        file="gateway/transactions.py",
        guard="        async with self._one:\n            self._since_ns",
        without="        if True:\n            self._since_ns",
        caught_by=(REDEEMERS,),
    ),
)
