"""How a button reads that offers an order: in the reader's words and units, as they may type it."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined
from rosic.core.language import Do, LineContext, understand
from rosic.core.language.common_names import shown_command, shown_name
from rosic.core.language.compiled import fold
from rosic.core.units import measured
from rosic.gateway.command_menus import offered

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.language import Vocabulary
    from rosic.core.order import SpokenValue

TASK: Final = "/task "


def label_of(offer: str, vocabulary: Vocabulary) -> str:
    """Return how a button reads that says a command; what it says stays what it is."""
    if offer.startswith(TASK):
        task = offered(TASK.strip(), partial(_named, vocabulary), vocabulary.commands)
        return joined(" ", (task, label_of(offer[len(TASK) :], vocabulary)))
    everybody = LineContext("", frozenset(vocabulary.profiles))
    lines = understand(offer, vocabulary, everybody, mends=False)
    if offer.startswith("/") or len(lines) != 1 or not isinstance(lines[0], Do):
        return offered(offer, partial(_named, vocabulary), vocabulary.commands)
    label = joined(" ", _words(lines[0], vocabulary))
    # In English it reads as it is typed. What does not is somebody's own way of saying it.
    return label if label == offer else offer


def _named(vocabulary: Vocabulary, word: str) -> str:
    """Return how the robot or group that a word names is shown; empty if it names none."""
    callee = vocabulary.callees.get(fold(word))
    if callee is None:
        return ""
    profile = vocabulary.profiles.get(callee.name)
    return callee.name if callee.group or profile is None else profile.shown


def _words(line: Do, vocabulary: Vocabulary) -> Iterator[str]:
    robot, skill = line.robots[0], line.skills[0]
    yield line.group or robot
    compiled = vocabulary.compiled_skill(robot, skill.id)
    spoken = skill.id if compiled is None else compiled.spoken
    yield shown_command(skill.id, spoken, skill.titles)
    yield from map(_value, line.spoken)


def _value(value: SpokenValue) -> str:
    name = joined("", (shown_name(value.name), "=")) if value.name else ""
    if value.number is None:
        return joined("", (name, shown_name(value.word)))
    text = f"{value.number:.12g} {value.word}".rstrip()
    return joined("", (name, measured(text, value.number, value.word)))
