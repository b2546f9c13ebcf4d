"""docs/language.md says what is true of the robots that ship."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rosic.app.features import command_table
from rosic.config.lexicons import known_phrases
from rosic.config.profiles import known_units, load_profile, shipped_profiles
from rosic.core.language import (
    Do,
    Help,
    Line,
    LineContext,
    Misunderstood,
    Resume,
    Robots,
    Status,
    Use,
    Vocabulary,
    bind,
    hears_cancel,
    hears_stop,
    show,
    understand,
)
from rosic.errors import Refusal

PAGE = Path(__file__).parents[3] / "docs" / "language.md"
OWN = "End everything of one's own"
BLOCKS = re.findall(r"```chat\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


class Conversation:
    """Understands one block, from top to bottom."""

    def __init__(self) -> None:
        files = shipped_profiles().values()
        self.vocabulary = Vocabulary.build(
            map(load_profile, files), known_units(), command_table(), known_phrases()
        )
        self.visible = frozenset(self.vocabulary.profiles)
        self.selected = ""

    def answer(self, text: str) -> str:
        names = hears_stop(text, self.vocabulary.known)
        if names is not None:
            robots, _ = self.vocabulary.to_stop(names, self.visible)
            everything = frozenset(robots) == self.visible
            return "Stop everything" if everything else f"Stop {', '.join(robots)}"
        if (names := hears_cancel(text, self.vocabulary.known)) is not None:
            robots, unknown = self.vocabulary.to_stop(names, self.visible)
            named = names and not unknown
            return f"End what {', '.join(robots)} does for one" if named else OWN
        (line,) = understand(text, self.vocabulary, LineContext(self.selected, self.visible))
        return self.said(line)

    def said(self, line: Line) -> str:
        if isinstance(line, Do):
            return self.done(line)
        if isinstance(line, Misunderstood):
            return with_offers(line.sentence, line.offers)
        if isinstance(line, Use):
            self.selected = line.name
            return f"From now on: {line.name or 'nobody'}"
        return question(line)

    def done(self, line: Do) -> str:
        robot, skill = line.robots[0], line.skills[0]
        shown = line.group or self.vocabulary.profiles[robot].shown
        try:
            arguments = bind(self.vocabulary, robot, skill, line.spoken, group=line.group)
        except Refusal as refusal:
            return with_offers(str(refusal), refusal.offers)
        return f"{shown}: {show(self.vocabulary, robot, skill, arguments)}"


def question(line: Line) -> str:
    match line:
        case Status(robots):
            return f"How are {', '.join(robots)}?" if robots else "How is everybody?"
        case Help(topic):
            return f"What can {topic} do?"
        case Robots():
            return "Which robots are there?"
        case Resume(robots):
            return f"Undo the stop of {', '.join(robots)}"
        case _:
            return f"{line}"


def with_offers(sentence: str, offers: tuple[str, ...]) -> str:
    return "\n".join([sentence, " ".join(f"[{offer}]" for offer in offers)]).strip()


def test_the_page_has_examples() -> None:
    assert len(BLOCKS) > 7


@pytest.mark.parametrize("block", BLOCKS)
def test_an_example_is_true(block: str) -> None:
    conversation = Conversation()
    for turn in block.split("> ")[1:]:
        text, _, answer = turn.strip().partition("\n")
        assert conversation.answer(text) == answer, text
