"""Guards of how what arrives is read: in which order, how long, and by which of several bots."""

from __future__ import annotations

from tests.planted.faults import Fault

READING = "tests/messengers/test_reading.py"
WINDOW = "tests/messengers/test_update_window.py"
STEPS = "tests/gateway/test_steps.py"
HUNG = "tests/gateway/test_hung.py"
IN_GROUPS = "tests/features/access/test_codes_in_groups.py"
SECRECY = "tests/core/language/test_secrecy.py"
TWO_BOTS = "tests/gateway/test_two_bots.py"

OF_READING = (
    Fault(
        name="L2 nothing is fetched while what strangers sent is read",
        file="messengers/telegram/reading.py",
        guard="self._later = group.create_task(self._read_on(window))",
        without="await self._read_on(window)",
        caught_by=(f"{STEPS}::test_what_takes_longest_to_read_is_not_waited_for",),
    ),
    Fault(
        name="what strangers sent is confirmed before it is read",
        file="messengers/telegram/reading.py",
        guard="                window.expect(number, light=rank != UNNAMED)\n",
        without="",
        caught_by=(f"{READING}::test_what_strangers_sent_is_not_confirmed_before_it_is_read",),
    ),
    Fault(
        name="what an earlier run left unread keeps the next from reading",
        file="messengers/telegram/reading.py",
        guard="        self._unread, self._later, self.hurried = [], None, False\n",
        without="",
        caught_by=(f"{READING}::test_nothing_is_lost_whenever_a_run_is_cut_off",),
    ),
    Fault(
        name="L2 what came is followed before what nobody in particular sent is read",
        file="messengers/telegram/reading.py",
        guard="self._unread[0].since if waited_for else None",
        without="None",
        caught_by=(
            f"{STEPS}::test_a_stop_of_nobody_is_found_before_anything_that_came_with_it_is_followed",
            f"{READING}::test_those_known_here_wait_for_what_nobody_sent_as_a_stop_may_be_in_it",
        ),
    ),
    Fault(
        name="L2 what is read beside the polling lets half of an answer be followed",
        file="messengers/telegram/reading.py",
        guard="        if not self._taking:\n",
        without="        if True:\n",
        caught_by=(
            f"{READING}::test_what_comes_while_strangers_are_read_is_searched_before_it_is_followed",
        ),
    ),
    Fault(
        name="L2 posts where nobody was met are searched before anything is followed",
        file="messengers/telegram/reading.py",
        guard="return UNMET_STOP if len(text) <= SHORT and self._says_stop(text) else UNMET",
        without="return UNNAMED",
        caught_by=(f"{STEPS}::test_a_stop_behind_a_mix_is_found_as_soon_as_it_is_handed_over",),
    ),
    Fault(
        name="L2 long posts where somebody was met are searched before anything is followed",
        file="messengers/telegram/reading.py",
        guard="return UNNAMED if len(text) <= UNNAMED_SIGNS else UNMET",
        without="return UNNAMED",
        caught_by=(f"{READING}::test_what_is_long_and_names_nobody_is_read_last_wherever_it_is",),
    ),
    Fault(
        name="L2 a stop where nobody was met is left unread when much comes with it",
        file="messengers/telegram/reading.py",
        guard="return UNMET_STOP if len(text) <= SHORT and self._says_stop(text) else UNMET",
        without="return UNMET",
        caught_by=(f"{READING}::test_of_too_much_a_stop_is_read_also_where_nobody_was_met",),
    ),
    Fault(
        name="L2 what strangers sent fills what Telegram gives out",
        file="messengers/telegram/polling.py",
        guard="        window.clear_the_way()\n",
        without="        pass\n",
        caught_by=(f"{STEPS}::test_a_stop_behind_a_mix_is_found_as_soon_as_it_is_handed_over",),
    ),
    Fault(
        name="L2 what strangers sent is read while more is to be fetched",
        file="messengers/telegram/polling.py",
        guard="self.reading.hurry(on=full and fresh > 0)",
        without="self.reading.hurry(on=False)",
        caught_by=(f"{STEPS}::test_a_stop_behind_a_mix_is_found_as_soon_as_it_is_handed_over",),
    ),
    Fault(
        name="I15 what cannot be followed piles up where strangers are read",
        file="messengers/telegram/reading.py",
        guard="(self.hurried or not window.has_room)",
        without="self.hurried",
        caught_by=(f"{READING}::test_while_much_waits_nothing_more_of_strangers_is_read",),
    ),
    Fault(
        name="I15 what strangers sent is kept without bound",
        file="messengers/telegram/reading.py",
        guard="        self._pass_over(window)\n",
        without="",
        caught_by=(
            f"{READING}::test_what_strangers_sent_hides_nothing_behind_it_however_much_it_is",
        ),
    ),
    Fault(
        name="L1 an order waits for what nobody sent after it",
        file="messengers/telegram/update_window.py",
        guard="if before is None or update_id < before:",
        without="if before is None:",
        caught_by=(f"{READING}::test_an_order_does_not_wait_for_what_nobody_sent_after_it",),
    ),
    Fault(
        name="L1 what was handed to nobody is confirmed where something is held up",
        file="messengers/telegram/update_window.py",
        guard=" - {number for number, _ in self._admitted}",
        without="",
        caught_by=(f"{WINDOW}::test_what_waits_for_something_to_be_read_is_never_confirmed",),
    ),
    Fault(
        name="L2 a hundred that are held up hide a stop",
        file="messengers/telegram/polling.py",
        guard="        window.relieve()\n",
        without="        pass\n",
        caught_by=(f"{READING}::test_what_people_sent_hides_no_stop_while_it_is_held_up",),
    ),
    Fault(
        name="L2 what is refused and not on disk hides a stop",
        file="messengers/telegram/polling.py",
        guard="if not settled and self._full_ns is None:",
        without="if not settled:",
        caught_by=(f"{READING}::test_what_people_sent_hides_no_stop_while_nothing_is_on_disk",),
    ),
    Fault(
        name="L3 nobody is told of what was given up",
        file="messengers/telegram/update_window.py",
        guard="standing=MessageValidity.DROPPED)",
        without="standing=MessageValidity.FORWARDED)",
        caught_by=(f"{WINDOW}::test_of_too_much_that_is_held_up_what_waited_for_long_is_given_up",),
    ),
    Fault(
        name="L3 nobody says that something was given up",
        file="gateway/unfollowed_messages.py",
        guard="if inbound.standing is MessageValidity.DROPPED:",
        without="if False:",
        caught_by=(f"{HUNG}::test_whoever_sent_what_is_given_up_is_told",),
    ),
    Fault(
        name="I10 whoever said something waits for the disk for as long as it hangs",
        file="container/bounded_writes.py",
        guard="            _end(over)\n",
        without="            pass\n",
        caught_by=(f"{HUNG}::test_what_moves_nothing_does_not_wait_longer_either",),
    ),
    Fault(
        name="I10 each order waits anew for a record that hangs",
        file="container/bounded_writes.py",
        guard="        if self._late:\n",
        without="        if False:\n",
        caught_by=(f"{HUNG}::test_while_something_is_late_nothing_else_waits",),
    ),
    Fault(
        name="I7 what is claimed too late is left open",
        file="container/bounded_writes.py",
        guard="            disown()\n",
        without="            pass\n",
        caught_by=(f"{HUNG}::test_what_is_claimed_too_late_is_disowned_and_never_done",),
    ),
    Fault(
        name="a code is good that a group read in a message that is not followed",
        file="gateway/unfollowed_messages.py",
        guard="burnt = not private and await self._showed_a_code(messenger, inbound)",
        without="burnt = False",
        caught_by=(IN_GROUPS,),
    ),
    Fault(
        name="of several codes that a group was shown one is burnt",
        file="features/access/join.py",
        guard="        for code in codes:\n",
        without="        for code in codes[:1]:\n",
        caught_by=(IN_GROUPS,),
    ),
    Fault(
        name="a code is good that a group reads behind a word, or in a line for another bot",
        file="features/access/join.py",
        guard='read = "\\n".join((inbound.written or text, *inbound.links))',
        without="read = text",
        caught_by=(f"{IN_GROUPS}::test_a_code_is_burnt_that_stands_beside_the_text",),
    ),
    Fault(
        name="a code is good that a group read beside a stop",
        file="gateway/pipeline.py",
        guard="await self._unfollowed.take(messenger, inbound)\n            return\n        if",
        without="self._unfollowed.answer(messenger, inbound)\n            return\n        if",
        caught_by=(f"{IN_GROUPS}::test_a_whole_gateway_burns_a_code_whatever_else_is_said",),
    ),
    Fault(
        name="a code is good that somebody known shows a group in a line that is understood",
        file="gateway/chat_handler.py",
        guard=" or inbound.chat.kind is not ChatKind.PRIVATE:\n        return True",
        without=":\n        return True",
        caught_by=(f"{IN_GROUPS}::test_a_whole_gateway_burns_a_code_whatever_else_is_said",),
    ),
    Fault(
        name="a secret is kept behind words that mean nothing",
        file="core/language/secrecy.py",
        guard="at = past_fillers(low, 0)",
        without="at = 0",
        caught_by=(f"{SECRECY}::test_whatever_is_read_as_a_secret_is_left_out",),
    ),
    Fault(
        name="a secret is kept where its command holds what cannot be seen",
        file="core/language/secrecy.py",
        guard="seen = clean(line).strip()",
        without="seen = line.strip()",
        caught_by=(f"{SECRECY}::test_whatever_is_read_as_a_secret_is_left_out",),
    ),
    Fault(
        name="I1 a line of a small group is done once for each bot that hears it",
        file="messengers/telegram/reading.py",
        guard="            inbound = self._alike.named(inbound, message.date, text)\n",
        without="            pass\n",
        caught_by=(f"{TWO_BOTS}::test_what_both_bots_hear_in_a_group_is_one_command",),
    ),
    Fault(
        name="I1 in a small group the same in another second is the same line",
        file="messengers/telegram/update_window.py",
        guard="inbound.sender.account, str(date_s), written)",
        without="inbound.sender.account, written)",
        caught_by=(
            f"{TWO_BOTS}::test_in_a_small_group_the_same_line_after_a_restart_is_another_command",
        ),
    ),
    Fault(
        name="I1 in a small group a line is another one to the bot that another line names",
        file="messengers/telegram/update_window.py",
        guard="str(date_s), written)",
        without="str(date_s), inbound.text)",
        caught_by=(f"{TWO_BOTS}::test_in_a_group_a_line_is_the_same_whichever_bot_is_named",),
    ),
    Fault(
        name="I1 a line has another place to the bot that another line names",
        file="gateway/requests.py",
        guard="    if inbound.written and number != FILE:",
        without="    if False:",
        caught_by=(f"{TWO_BOTS}::test_in_a_group_a_line_is_the_same_whichever_bot_is_named",),
    ),
    Fault(
        name="I1 in a small group the same once more in a second is the same line",
        file="messengers/telegram/update_window.py",
        guard="{numbers.index(inbound.message)}",
        without="0",
        caught_by=(
            f"{TWO_BOTS}::test_in_a_small_group_every_other_line_second_or_person_is_another_command",
        ),
    ),
)
