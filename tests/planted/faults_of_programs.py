"""Guards of programs, which confirm nothing and are answered each time, each taken out."""

from __future__ import annotations

from tests.planted.faults import Fault

PROGRAMS = "tests/gateway/test_programs.py"
KEYS = "tests/authoriser/test_program_keys.py"
ORDERS, ONCE = "tests/api/test_orders.py", "tests/api/test_idempotency_keys.py"

OF_PROGRAMS = (
    Fault(
        name="a program confirms what it asked for itself",
        file="gateway/confirmation.py",
        guard="            if caller.is_program:\n                raise NotPermitted",
        without="            if not caller:\n                raise NotPermitted",
        caught_by=(f"{PROGRAMS}::test_a_program_confirms_nothing_whatever_it_gets_hold_of",),
    ),
    Fault(
        name="a program agrees for somebody else",
        file="gateway/confirmation.py",
        guard="        if asked.caller.is_program:\n",
        without="        if not asked.caller:\n",
        caught_by=(f"{PROGRAMS}::test_no_program_is_asked_or_may_agree_for_somebody_else",),
    ),
    Fault(
        name="a program is asked to agree",
        file="gateway/confirmation.py",
        guard="            and not self._reach.is_program(who)\n",
        without="",
        caught_by=(f"{PROGRAMS}::test_no_program_is_asked_or_may_agree_for_somebody_else",),
    ),
    Fault(
        name="a program is asked itself whether what it asks for is meant",
        file="gateway/confirmation.py",
        guard="        if caller.is_program:\n            return self._ask_for_program(",
        without="        if not caller:\n            return self._ask_for_program(",
        caught_by=(f"{PROGRAMS}::test_what_has_to_be_confirmed_is_asked_of_people_and_then_begun",),
    ),
    Fault(
        name="a program that asks too much waits for an answer that never comes",
        file="gateway/replies.py",
        guard="        awaited = message.inbound.awaits_answer\n",
        without="        awaited = False\n",
        caught_by=(f"{PROGRAMS}::test_a_program_is_told_each_time_that_it_asks_too_much",),
    ),
    Fault(
        name="a file that meets a limit waits for an answer that never comes",
        file="gateway/chat_handler.py",
        guard="            if not why.silent or inbound.awaits_answer:",
        without="            if not why.silent:",
        caught_by=(f"{ORDERS}::test_whoever_waits_is_answered_each_time_that_they_meet_a_limit",),
    ),
    Fault(
        name="an order that met a limit is refused under its key for good",
        file="api/ordering.py",
        guard="        if placed.met_limit:\n",
        without="        if placed is None:\n",
        caught_by=(
            f"{ONCE}::test_what_met_a_limit_is_tried_again_under_the_same_key_when_its_time_has_come",
        ),
    ),
    Fault(
        name="I1 what met a limit is settled, so it is done anew under another name",
        file="gateway/replies.py",
        guard="        if awaited and isinstance(refusal, TooManyRequests):\n",
        without="        if awaited and refusal.silent:\n",
        caught_by=(f"{ONCE}::test_an_order_that_met_a_limit_again_and_again_is_done_once",),
    ),
    Fault(
        name="a call hears what is said in another program's conversation",
        file="messengers/program/messenger.py",
        guard="        if call is None or call.address.account != outbound.chat.id:\n",
        without="        if call is None:\n",
        caught_by=(f"{PROGRAMS}::test_what_is_said_in_another_conversation_is_not_told",),
    ),
    Fault(
        name="a call that gives up leaves its order under way",
        file="messengers/mcp/messenger.py",
        guard="        except asyncio.CancelledError:\n            self._cancel(call)\n",
        without="        except asyncio.CancelledError:\n",
        caught_by=(
            f"{PROGRAMS}::test_a_no_is_the_answer_and_one_that_gives_up_takes_its_question_back",
        ),
    ),
    Fault(
        name="any secret that names a key is good",
        file="authoriser/program_keys.py",
        guard="        if not compare_digest(known, _digest(secret)):\n",
        without="        if not known:\n",
        caught_by=(f"{KEYS}::test_only_the_secret_that_was_shown_is_good",),
    ),
    Fault(
        name="the secret of a key that was taken back is good",
        file="authoriser/program_keys.py",
        guard="self._directory.person(self._keys.check(key_id).principal)",
        without="self._directory.person(self._keys._keys[key_id].principal)",
        caught_by=(f"{KEYS}::test_a_key_that_was_taken_back_or_has_ended_lets_nobody_in",),
    ),
    Fault(
        name="values become a line that was not read again",
        file="gateway/programs.py",
        guard="        if len(read) != 1 or not _says(read[0], robot, skill, given):\n",
        without="        if not read:\n",
        caught_by=(f"{PROGRAMS}::test_a_text_that_would_say_something_else_is_not_said",),
    ),
)
