"""What would do instead of lines that a robot cannot carry out as they stand.

A line of a task is read as a command of its robot, and so are the commands that are offered with a
refusal: whoever tapped one of those would move a robot at once and by hand. Here they become lines
again, for the caller to say in its own words, and only those that would be accepted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.language import Do, Line, LineContext, Misunderstood, understand
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


class StepReader:
    """Reads lines as commands of one robot each; every line once for each robot.

    Lines are only tried here, against many robots: what may have been meant by one is looked for
    where it is asked for, and not before.
    """

    def __init__(self, rooms: Components) -> None:
        self.rooms = rooms
        self._read: dict[tuple[RobotId, str], Do | None] = {}

    def read(self, robot: RobotId, line: str) -> Do:
        """Return one line as one robot understands it; its values are not looked at yet.

        Raises:
            NotUnderstood: It is no single command of this robot.
        """
        try:
            step = self._read[robot, line]
        except KeyError:
            lines = self._lines(robot, line, mends=False)
            single = len(lines) == 1 and isinstance(lines[0], Do) and lines[0].robots == (robot,)
            step = self._read[robot, line] = lines[0] if single else None  # type: ignore[assignment]
        if step is None:
            raise NotUnderstood(words.no_command(self.rooms.profiles[robot].shown, line))
        return step

    def close(self, robot: RobotId, line: str) -> Lines:
        """Return lines that may have been meant by one that is no command of a robot."""
        try:
            self.read(robot, line)
        except NotUnderstood:
            [first, *_] = self._lines(robot, line, mends=True)
            offers = first.offers if isinstance(first, Misunderstood) else ()
            to_it = f"{robot} "
            return tuple(offer.removeprefix(to_it) for offer in offers if offer.startswith(to_it))
        return ()

    def _lines(self, robot: RobotId, line: str, *, mends: bool) -> Sequence[Line]:
        context = LineContext(robot, frozenset({robot}))
        return understand(f"{robot} {line}", self.rooms.vocabulary, context, mends=mends)


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
        steps: Reads lines.
        robot: Whose lines.
        check: Raises why the robot cannot carry out all of some lines.
    """

    def __init__(self, steps: StepReader, robot: RobotId, check: Callable[[Lines], object]) -> None:
        self._steps = steps
        self._robot = robot
        self._check = check

    def lacking(self, lines: Sequence[str], why: Refusal) -> MissingPart:
        """Return what would do instead of lines that were refused, as far as anything would."""
        at = next((at for at, line in enumerate(lines) if self._refused((line,))), 0)
        to_it = f"{self._robot} "
        other = tuple(offer for offer in why.offers if not offer.startswith(to_it))
        offered = [o.removeprefix(to_it) for o in why.offers if o.startswith(to_it)]
        offered += self._steps.close(self._robot, lines[at])
        found = [(*lines[:at], offer, *lines[at + 1 :]) for offer in offered]
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
            step = self._steps.read(self._robot, line)
            [skill], vocabulary = step.skills, self._steps.rooms.vocabulary
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
