"""Guards of what is told, when and to whom."""

from __future__ import annotations

from tests.planted.faults import Fault

OUTBOX = "tests/gateway/test_outbox.py"
EXPIRING = "tests/gateway/test_button_expiry.py"
SPEAKING = "tests/gateway/test_chat_queue.py"

END_BUTTONS = "tests/gateway/test_end_buttons.py"
LISTENING = "tests/messengers/test_polling_gap.py"

OF_TELLING = (
    Fault(
        name="I16 whatever a tap brings is taken for something that moves nothing",
        file="authoriser/button_tokens.py",
        guard="if nonce.startswith(OPEN) and is_open(nonce[1:]):",
        without="if nonce.startswith(OPEN):",
        caught_by=(f"{END_BUTTONS}::test_nothing_else_can_be_asked_for_that_way",),
    ),
    Fault(
        name="I1 two taps on what is nobody's are one",
        file="gateway/requests.py",
        guard="if nonce is not None and not nonce.startswith(OPEN):",
        without="if nonce is not None:",
        caught_by=(
            f"{END_BUTTONS}::test_they_are_good_for_as_long_as_they_are_shown_and_more_than_once",
        ),
    ),
    Fault(
        name="what is tapped beneath an end takes its place",
        file="gateway/replies.py",
        guard='return "" if lasts else inbound.under',
        without="return inbound.under",
        caught_by=(f"{END_BUTTONS}::test_again_asks_with_the_same_values_and_moves_once",),
    ),
    Fault(
        name="I7 the network is blamed though somebody answered",
        file="messengers/telegram/polling_gap.py",
        guard="if self._away and not self._answered:",
        without="if self._away:",
        caught_by=(
            f"{LISTENING}::test_the_network_was_away_if_there_was_no_way_and_nobody_answered",
        ),
    ),
    Fault(
        name="I7 the network is blamed for a time in which we slept",
        file="messengers/telegram/polling_gap.py",
        guard="if took_ns > within_s * SECOND_NS:",
        without="if False:",
        caught_by=(f"{LISTENING}::test_of_a_time_in_which_we_did_not_run_nothing_is_said",),
    ),
    Fault(
        name="L1 an alarm is not written down before it is said",
        file="gateway/delivery/notifier.py",
        guard="if lasts:",
        without="if False:",
        caught_by=(f"{OUTBOX}::test_an_alarm_that_was_not_said_is_said_by_the_next_run_once",),
    ),
    Fault(
        name="L1 an alarm that is said again cannot be acknowledged",
        file="gateway/delivery/outbox.py",
        guard="if found.matter:",
        without="if False:",
        caught_by=("tests/features/alerts/test_alert_said_again.py",),
    ),
    Fault(
        name="a name gives others a command",
        file="core/language/sanitise.py",
        guard='return inert_text(" ".join(',
        without='return (" ".join(',
        caught_by=("tests/core/language/test_cleaning.py",),
    ),
    Fault(
        name="L1 the answer to a stop is owed by nobody",
        file="gateway/stop.py",
        guard="        if by:\n",
        without="        if False:\n",
        caught_by=(f"{OUTBOX}::test_a_stop_whose_answer_was_cut_off_is_answered_by_the_next_run",),
    ),
    Fault(
        name="L3 a backlog is answered one by one",
        file="gateway/replies.py",
        guard="if is_missed(inbound):",
        without="if False:",
        caught_by=("tests/gateway/test_catch_up.py",),
    ),
    Fault(
        name="what was said in a group in the last minute is forgotten over a restart",
        file="messengers/telegram/rate_limiter.py",
        guard="pace.go_on(self._lately.take(chat))",
        without="pass",
        caught_by=(
            "tests/messengers/test_rate_limiter.py::test_a_groups_minute_outlives_a_restart",
        ),
    ),
    Fault(
        name="L2 the next message of a chat waits until a refusal is on disk",
        file="gateway/replies.py",
        guard="if self.backlog.settles(message.messenger):",
        without="if is_missed(message.inbound) and self.backlog.settles(message.messenger):",
        caught_by=("tests/gateway/test_catch_up.py",),
    ),
    Fault(
        name="L1 what has become an outcome goes on waiting as a question",
        file="gateway/delivery/chat_queue.py",
        guard="            self.asking.cancel()\n",
        without="            pass\n",
        caught_by=(f"{SPEAKING}::test_an_outcome_goes_before_an_answer_and_progress_goes_last",),
    ),
    Fault(
        name="what was taken out of a chat is said there again",
        file="gateway/delivery/chat_queue.py",
        guard="if note.edit_only:",
        without="if False:",
        caught_by=(
            f"{EXPIRING}::test_a_message_that_is_gone_is_not_said_again_only_to_lose_its_buttons",
        ),
    ),
    Fault(
        name="buttons outlive their time beside ones that live longer",
        file="gateway/button_expiry.py",
        guard="if self._watching is not None and due_ns < self._looks_ns:",
        without="if False:",
        caught_by=(
            f"{EXPIRING}::test_what_expires_sooner_than_a_menu_that_was_shown_before_goes_in_its_time",
        ),
    ),
    Fault(
        name="L1 a life that was perhaps told is told again unmarked",
        file="gateway/order_status.py",
        guard="        self.doubted = True\n",
        without="        pass\n",
        caught_by=(f"{SPEAKING}::test_what_may_stand_there_already_is_said_again_with_a_mark",),
    ),
    Fault(
        name="I15 a chat with much to say keeps the others waiting",
        file="messengers/telegram/rate_limiter.py",
        guard="return one.weight, self._of(one)[0].paid_ns, one.number",
        without="return one.weight, 0, one.number",
        caught_by=("tests/messengers/test_rate_limiter.py",),
    ),
)
