"""Guards between an interpreter and people, each taken out by one small change."""

from __future__ import annotations

from tests.planted.faults import Fault

ANSWERS = "tests/features/interpreter/test_hostile_answers.py"
PROPOSED = "tests/features/interpreter/test_interpreter.py"
SHOWN = "tests/features/interpreter/test_shown_text.py"
WIRE = "tests/interpreters/test_chat_completions.py"
PROPOSALS, CLIENT = "features/interpreter/proposals.py", "features/interpreter/client.py"

OF_INTERPRETING = (
    Fault(
        name="an interpreter proposes what somebody may not do, and more than they may",
        file=PROPOSALS,
        guard="return self._clamping.may(caller.principal, part.robot, part.skill, part.arguments)",
        without="return True",
        caught_by=(
            f"{ANSWERS}::test_what_it_says_is_proposed_only_if_this_person_could_have_said_it",
            f"{PROPOSED}::test_what_somebody_may_not_do_is_not_proposed_to_them",
        ),
    ),
    Fault(
        name="an interpreter has a robot told a text of its own",
        file=PROPOSALS,
        guard="or (compiled.text and compiled.text.name in part.arguments)",
        without="",
        caught_by=(f"{PROPOSED}::test_words_to_robots_are_not_proposed_nor_what_no_button_shows",),
    ),
    Fault(
        name="nobody is told of the interpreter before their words are shown to it",
        file=CLIENT,
        guard="        elif state:\n",
        without="        elif True:\n",
        caught_by=(f"{SHOWN}::test_somebody_is_told_once_before_anything_of_theirs_is_shown",),
    ),
    Fault(
        name="a no to the interpreter counts for nothing",
        file=CLIENT,
        guard="if state == OFF or who in parts.preferences.damaged():",
        without="if who in parts.preferences.damaged():",
        caught_by=(f"{SHOWN}::test_whoever_says_no_is_never_shown_to_it",),
    ),
    Fault(
        name="the names of people leave the house",
        file=CLIENT,
        guard="line = without_names(message.text, vocabulary, rooms.authoriser.directory.named)",
        without="line = message.text",
        caught_by=(f"{SHOWN}::test_what_leaves_the_house_is_the_line_and_what_may_be_said",),
    ),
    Fault(
        name="what may be a secret leaves the house",
        file="features/interpreter/prompt.py",
        guard="return any(_looks_secret(word, vocabulary) for word in read.split())",
        without="return False",
        caught_by=(f"{SHOWN}::test_what_may_be_a_secret_is_shown_to_nobody",),
    ),
    Fault(
        name="an answer of any length is taken from an interpreter",
        file="interpreters/http_answer.py",
        guard="elif self._filled - self._head_ends > ANSWER_BYTES or",
        without="elif",
        caught_by=(f"{WIRE}::test_what_came_instead_has_a_kind",),
    ),
    Fault(
        name="what an interpreter sends away with is read as an answer",
        file="interpreters/http_answer.py",
        guard="if found[1] != OK:",
        without="if not found[1]:",
        caught_by=(f"{WIRE}::test_nothing_over_the_wire_is_an_answer_that_is_none",),
    ),
)
