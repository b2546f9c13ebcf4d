"""Guards between Telegram and the rooms."""

from __future__ import annotations

from tests.planted.faults import Fault

TWO_BOTS = "tests/gateway/test_two_bots.py"
LIMITER = "tests/messengers/test_rate_limiter.py"
STOPPING = "tests/gateway/test_stopping.py"
STOP_WORDS = "tests/core/language/test_stopping.py"
CLEANING = "tests/core/language/test_cleaning.py"
STEPS = "tests/gateway/test_steps.py"
GROUPS = "tests/real/telegram/test_groups.py"
RECEIVING = "tests/real/telegram/test_receiving.py"

MESSENGER_FAULTS = (
    Fault(
        name="I17 an edited message counts as fresh",
        file="messengers/telegram/incoming.py",
        guard='if message.chat.type == "channel" else MessageValidity.EDITED',
        without='if message.chat.type == "channel" else MessageValidity.FRESH',
        caught_by=("tests/real/telegram/test_generated.py",),
    ),
    Fault(
        name="I15 a sign that stands for a sentence is written out wherever it is read",
        file="core/language/sanitise.py",
        guard="_bounded_marks(text.translate(_SENTENCES))",
        without="_bounded_marks(text)",
        caught_by=(f"{STOP_WORDS}::test_a_sign_that_is_a_whole_sentence_hides_no_stop",),
    ),
    Fault(
        name="I15 however many marks on one letter are put in order",
        file="core/language/sanitise.py",
        guard="_MAY_BE_MARKS.sub(lambda found: _first_marks(found[0]), text)",
        without="text",
        caught_by=(f"{CLEANING}::test_of_the_marks_on_a_letter_the_first_thirty_are_kept",),
    ),
    Fault(
        name="I15 a chat's messages are one step",
        file="messengers/telegram/update_window.py",
        guard="            await asyncio.sleep(0)  # a message is a step",
        without="            # a message is a step",
        caught_by=(f"{STEPS}::test_no_batch_makes_a_step_long",),
    ),
    Fault(
        name="L2 a stop waits for what strangers sent before it",
        file="messengers/telegram/reading.py",
        guard="(rank := self._rank(update)) != KNOWN:",
        without="(rank := self._rank(update)) != KNOWN and False:",
        caught_by=(f"{STEPS}::test_what_strangers_sent_is_read_last",),
    ),
    Fault(
        name="L2 what came is followed before all of it is searched for a stop",
        file="messengers/telegram/update_window.py",
        guard="            self._admitted.append((one.update_id, one.inbound))\n",
        without="            self._queue(one.update_id, one.inbound)\n",
        caught_by=(f"{STEPS}::test_a_stop_is_found_before_anything_that_came_with_it_is_followed",),
    ),
    Fault(
        name="I1 a message is known without the bot that received it",
        file="gateway/requests.py",
        guard="    if inbound.account:\n",
        without="    if False:\n",
        caught_by=(f"{TWO_BOTS}::test_messages_of_the_same_number_to_two_bots_are_two_commands",),
    ),
    Fault(
        name="I1 after an upgrade nothing is known of what was done before",
        file="app/messenger_setup.py",
        guard="    since_ns = 0 if memory == Memory() else now_ns + CLOCKS_APART_NS\n",
        without="    since_ns = 0\n",
        caught_by=(
            f"{TWO_BOTS}::test_what_an_earlier_version_did_is_not_done_again_after_the_upgrade",
        ),
    ),
    Fault(
        name="I1 since when the bot counts is not kept",
        file="app/messenger_setup.py",
        guard='await store.write(Fact(kind=KIND, key=KEY, body=b"%d" % since_ns))',
        without="pass",
        caught_by=(f"{TWO_BOTS}::test_what_is_brought_once_more_over_a_restart_is_done_once",),
    ),
    Fault(
        name="I1 a supergroup's message is done once for each bot that hears it",
        file="messengers/telegram/incoming.py",
        guard='shared = message.chat.type in {"supergroup", "channel"}',
        without="shared = False",
        caught_by=(f"{TWO_BOTS}::test_all_who_are_in_a_supergroup_share_its_numbers",),
    ),
    Fault(
        name="429 what is under way does not count for Telegram's limits",
        file="messengers/telegram/rate_limiter.py",
        guard="        most = self._rate.within[weight] - self._under_way\n",
        without="        most = self._rate.within[weight]\n",
        caught_by=(
            f"{LIMITER}::test_a_call_counts_from_its_sending_until_a_second_after_its_answer",
        ),
    ),
    Fault(
        name="429 a run begins as if nothing had been said before it",
        file="messengers/telegram/rate_limiter.py",
        guard="            self._overall.used_up(self._begun_ns)\n",
        without="            pass\n",
        caught_by=(
            f"{LIMITER}::test_after_a_restart_nothing_is_counted_on_that_an_earlier_run_may_have_used",
        ),
    ),
    Fault(
        name="429 a gesture does not wait where Telegram asked to wait",
        file="messengers/telegram/messenger.py",
        guard="        await self._limiter.obey(str(where))\n        await self._line.ask(",
        without="        await self._line.ask(",
        caught_by=(
            "tests/real/telegram/test_sending.py::test_a_gesture_waits_where_telegram_asked_to_wait",
        ),
    ),
    Fault(
        name="I17 who was in a group is forgotten with the run",
        file="container/container.py",
        guard="            self._choose(principal, digest, MET)\n",
        without="            self.restore_selection(principal, digest, MET)\n",
        caught_by=(
            f"{STOPPING}::test_a_stop_of_nobody_counts_for_those_who_wrote_there_in_an_earlier_run",
        ),
    ),
    Fault(
        name="I17 a chat's admins are not asked for",
        file="gateway/stop.py",
        guard="        visible = visible or await self._company.ask(messenger, inbound)\n",
        without="",
        caught_by=(
            f"{STOPPING}::test_where_nobody_is_known_the_chats_admins_are_asked_for_now_and_then",
        ),
    ),
    Fault(
        name="a chat that we were put out of is written to all the same",
        file="messengers/telegram/outgoing.py",
        guard="if self._chats.gone(chat):",
        without="if False:",
        caught_by=(f"{GROUPS}::test_where_we_were_put_out_nothing_is_tried_until_we_are_let_in",),
    ),
    Fault(
        name="what is said to another bot is taken for ours",
        file="messengers/telegram/incoming.py",
        guard="if to_another and",
        without="if False and to_another and",
        caught_by=(f"{GROUPS}::test_of_two_bots_in_a_group_the_addressed_one_answers",),
    ),
    Fault(
        name="a reply means whatever was chosen, not the robot it replies to",
        file="gateway/reply_context.py",
        guard="if about and visible.intersection(members(about)):",
        without="if False:",
        caught_by=("tests/gateway/test_reply_context.py",),
    ),
    Fault(
        name="what stayed behind in a group is sought where the group is now",
        file="messengers/telegram/chats.py",
        guard="return chat in self._moved and (chat, message) not in self._since",
        without="return False",
        caught_by=(
            f"{RECEIVING}::test_what_stayed_behind_when_a_group_moved_changes_nothing_where_it_is_now",
        ),
    ),
    Fault(
        name="everything in a topic is an answer to whoever created it",
        file="messengers/telegram/incoming.py",
        guard="if first is not None and message.is_topic_message:",
        without="if False:",
        caught_by=(f"{GROUPS}::test_in_a_topic_that_a_bot_created_people_are_heard_as_anywhere",),
    ),
    Fault(
        name="a bank card's number can be tapped",
        file="messengers/telegram/formatting.py",
        guard="if _DIGITS.search(text) is not None:",
        without="if False:",
        caught_by=("tests/real/telegram/test_inert_text.py",),
    ),
)
