"""Guards of what people say to each other in a group, each taken out by one small change."""

from __future__ import annotations

from tests.planted.faults import Fault

MEANT = "tests/gateway/test_meant_in_groups.py"
TALK = f"{MEANT}::test_nothing_moves_by_what_may_be_said_to_others"

OF_GROUPS = (
    Fault(
        name="what people say to each other in a group moves a robot",
        file="gateway/pipeline.py",
        guard="            self._chat.check_meant(message, line, cid)\n",
        without="            pass\n",
        caught_by=(TALK,),
    ),
    Fault(
        name="an order among words to others in a group moves a robot",
        file="gateway/chat_handler.py",
        guard="            message.read_as(lines, self._reader.vocabulary)\n",
        without="            pass\n",
        caught_by=(TALK,),
    ),
    Fault(
        name="a conversation with a robot in a group goes on for ever",
        file="gateway/reply_context.py",
        guard="self._clock.monotonic_ns() - named_ns < GOES_ON_NS",
        without="True",
        caught_by=(
            f"{MEANT}::test_whoever_has_just_spoken_to_a_robot_goes_on_without_its_name",
            TALK,
        ),
    ),
    Fault(
        name="a reply to what a person wrote in a group moves the robot that was chosen",
        file="gateway/chat_handler.py",
        guard="        if inbound.answers or inbound.answers_us:\n            return False\n",
        without="",
        caught_by=(
            f"{MEANT}::test_in_reply_to_what_a_person_wrote_it_is_asked_even_in_a_conversation",
        ),
    ),
    Fault(
        name="the only robot that can do it counts as named in a group",
        file="core/language/line_parser.py",
        guard="(robot.phrases[phrase],), after)",
        without="(robot.phrases[phrase],), after, named=True)",
        caught_by=(f"{MEANT}::test_the_only_robot_that_can_do_it_was_not_named_by_it",),
    ),
    Fault(
        name="what was asked about in a group is done because it comes again later",
        file="gateway/chat_handler.py",
        guard="        if repeated:\n            raise Repeated(DONE_ALREADY)\n",
        without="",
        caught_by=(f"{MEANT}::test_what_comes_twice_is_asked_once_and_not_done_later",),
    ),
)
