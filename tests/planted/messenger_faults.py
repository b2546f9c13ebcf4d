"""Guards between Telegram and the rooms."""

from __future__ import annotations

from tests.planted.faults import Fault

STEPS = "tests/rooms/pipeline/test_steps.py"

MESSENGER_FAULTS = (
    Fault(
        name="I17 an edited message counts as fresh",
        file="messengers/telegram/mapping.py",
        guard='if message.chat.type == "channel" else Standing.EDITED',
        without='if message.chat.type == "channel" else Standing.FRESH',
        caught_by=("tests/real/telegram/test_generated.py",),
    ),
    Fault(
        name="I15 a sign that stands for a sentence is written out wherever it is read",
        file="core/language/cleaning.py",
        guard='unicodedata.normalize("NFKC", text.translate(_SENTENCES))',
        without='unicodedata.normalize("NFKC", text)',
        caught_by=(f"{STEPS}::test_what_once_made_a_step_long_does_so_no_more",),
    ),
    Fault(
        name="I15 a chat's messages are one step",
        file="messengers/telegram/window.py",
        guard="            await asyncio.sleep(0)  # a message is a step",
        without="            # a message is a step",
        caught_by=(f"{STEPS}::test_no_batch_makes_a_step_long",),
    ),
    Fault(
        name="L2 a stop waits for what strangers sent before it",
        file="messengers/telegram/listener.py",
        guard="by_rank = sorted(ranked, key=itemgetter(0, 1))",
        without="by_rank = sorted(ranked, key=itemgetter(1))",
        caught_by=(f"{STEPS}::test_what_strangers_sent_is_read_last",),
    ),
    Fault(
        name="L2 what came is followed before all of it is searched for a stop",
        file="messengers/telegram/window.py",
        guard="            self._admitted.append((one.update_id, one.inbound))\n",
        without="            self._queue(one.update_id, one.inbound)\n",
        caught_by=(f"{STEPS}::test_a_stop_is_found_before_anything_that_came_with_it_is_followed",),
    ),
    Fault(
        name="a chat that we were put out of is written to all the same",
        file="messengers/telegram/speaker.py",
        guard="if self._chats.gone(chat):",
        without="if False:",
        caught_by=("tests/real/telegram/test_groups.py",),
    ),
    Fault(
        name="what is said to another bot is taken for ours",
        file="messengers/telegram/mapping.py",
        guard="if replied not in",
        without="if False and replied not in",
        caught_by=("tests/real/telegram/test_groups.py",),
    ),
    Fault(
        name="a reply means whatever was chosen, not the robot it replies to",
        file="pipeline/subjects.py",
        guard="if about and visible.intersection(members(about)):",
        without="if False:",
        caught_by=("tests/rooms/pipeline/test_spoken_of.py",),
    ),
    Fault(
        name="what stayed behind in a group is sought where the group is now",
        file="messengers/telegram/chats.py",
        guard="return chat in self._moved and (chat, message) not in self._since",
        without="return False",
        caught_by=("tests/real/telegram/test_receiving.py",),
    ),
    Fault(
        name="everything in a topic is an answer to whoever created it",
        file="messengers/telegram/mapping.py",
        guard="if first is not None and message.is_topic_message:",
        without="if False:",
        caught_by=("tests/real/telegram/test_groups.py",),
    ),
    Fault(
        name="a bank card's number can be tapped",
        file="messengers/telegram/entities.py",
        guard="if _DIGITS.search(text) is not None:",
        without="if False:",
        caught_by=("tests/real/telegram/test_inert_text.py",),
    ),
)
