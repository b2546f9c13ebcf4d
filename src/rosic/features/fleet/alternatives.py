"""What would do instead of lines that a robot cannot carry out as they stand.

A line of a task is read as a command of its robot, and so are the commands that are offered with a
refusal: whoever tapped one of those would move a robot at once and by hand. Here they become lines
again, for the caller to say in its own words, and only those that would be accepted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.language import Do, LineContext, Misunderstood, understand
from rosic.core.language.arguments import place
from rosic.core.language.formatting import usual_values
from rosic.errors import NotPermitted, NotUnderstood, OutOfBounds, Refusal
from rosic.features.fleet import messages as words

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rosic.core.language.compiled import CompiledParameter
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.components import Components

ANYTHING: Final = "..."
LONGEST_OFFER: Final = 128
"""What is longer fits on no button; it is an example."""

Lines = tuple[str, ...]


def read_step(rooms: Components, robot: RobotId, line: str) -> Do:
    """Return one line as one robot understands it; its values are not looked at yet.

    Raises:
        NotUnderstood: It is no single command of this robot.
    """
    context = LineContext(robot, frozenset({robot}))
    lines = understand(f"{robot} {line}", rooms.vocabulary, context)
    if len(lines) != 1 or not isinstance(lines[0], Do) or lines[0].robots != (robot,):
        close = lines[0].offers if isinstance(lines[0], Misunderstood) else ()
        raise NotUnderstood(
            words.no_command(rooms.profiles[robot].shown, line),
            offers=tuple(offer for offer in close if offer.startswith(f"{robot} ")),
        )
    return lines[0]


class MissingPart(NamedTuple):
    """Why one robot cannot carry out some lines, and what it could.

    Attributes:
        why: The reason.
        instead: All lines again, as it could carry them out; each is one offer.
        like: An example of all lines, where nothing is left but to type; else empty.
        other: Commands that are no work of this robot and stay offered: ways to stop it.
    """

    why: Refusal
    instead: tuple[Lines, ...] = ()
    like: Lines = ()
    other: Lines = ()

    @property
    def helps(self) -> bool:
        """Whether there is anything that could be said instead."""
        return bool(self.instead or self.like)


class TaskAlternatives:
    """Looks for what one robot could carry out instead.

    Args:
        rooms: Where lines are read.
        robot: Whose lines.
        check: Raises why the robot cannot carry out all of some lines.
    """

    def __init__(self, rooms: Components, robot: RobotId, check: Callable[[Lines], object]) -> None:
        self._rooms = rooms
        self._robot = robot
        self._check = check

    def lacking(self, lines: Sequence[str], why: Refusal) -> MissingPart:
        """Return what would do instead of lines that were refused, as far as anything would."""
        at = next((at for at, line in enumerate(lines) if self._refused((line,))), 0)
        to_it = f"{self._robot} "
        other = tuple(offer for offer in why.offers if not offer.startswith(to_it))
        found = [
            (*lines[:at], offer.removeprefix(to_it), *lines[at + 1 :])
            for offer in why.offers
            if offer.startswith(to_it)
        ]
        instead = tuple(whole for whole in found if self._refused(whole) is None)
        if instead:
            return MissingPart(why, instead, other=other)
        like = tuple(self._filled(line) for line in lines)
        if like == tuple(lines):
            return MissingPart(why, other=other)
        refusal = self._refused(like)
        if isinstance(refusal, NotPermitted):  # so no value would help
            return MissingPart(refusal)
        return MissingPart(why, like=() if refusal else like, other=other)

    def _refused(self, lines: Lines) -> Refusal | None:
        try:
            self._check(lines)
        except Refusal as refusal:
            return refusal
        return None

    def _filled(self, line: str) -> str:
        """Return a line with some value wherever one is missing."""
        try:
            step = read_step(self._rooms, self._robot, line)
            [skill], vocabulary = step.skills, self._rooms.vocabulary
            compiled, given = place(vocabulary, self._robot, skill, step.spoken)
        except Refusal:
            return line
        missing = [p for p in compiled.parameters if p.name not in given and p.default is None]
        return " ".join([line, *map(_some_value, missing)])


def refused(lacking: MissingPart, sentence: str, typed: Callable[[Sequence[str]], str]) -> Refusal:
    """Return the refusal that says why, and what could be said instead.

    Args:
        lacking: What is wrong.
        sentence: Why, as it is told.
        typed: Puts lines into the words of whoever asks for them.
    """
    why = lacking.why
    kind = type(why) if isinstance(why, OutOfBounds | NotPermitted) else NotUnderstood
    found = [line for line in map(typed, lacking.instead) if len(line) <= LONGEST_OFFER]
    like = lacking.like or (() if found else next(iter(lacking.instead), ()))
    text = words.for_example(sentence, typed(like)) if like else sentence
    return kind(text, offers=(*found, *lacking.other), access_request=why.access_request)


def _some_value(parameter: CompiledParameter) -> str:
    if parameter.text:
        return ANYTHING
    if parameter.words is not None:
        return next(iter(parameter.words.values())).replace("_", " ")
    return f"{parameter.name}={usual_values(parameter)[0]} {parameter.unit.symbol}".rstrip()
