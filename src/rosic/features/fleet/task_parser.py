"""What is said after ``/task``: for whom, what, step by step, and under which conditions."""

from __future__ import annotations

import asyncio
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec
from msgspec.structs import replace

from rosic.core.fleet.task import PRIORITIES, STEPS_AT_MOST, FleetMembership
from rosic.core.i18n import ImperialCatalogue
from rosic.core.language import bind, clean
from rosic.core.language.arguments import unit_needed
from rosic.core.language.time_parser import RequestedTime, read_when
from rosic.core.language.time_tokens import length_said
from rosic.errors import NotUnderstood, OutOfBounds, Refusal
from rosic.features.fleet import messages as words
from rosic.features.fleet.alternatives import MissingPart, StepReader, TaskAlternatives
from rosic.features.fleet.robot_messages import is_retired

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

    from rosic.core.fleet.state import FleetState
    from rosic.core.fleet.task import Task
    from rosic.core.i18n import Catalogue
    from rosic.core.identity import PrincipalId
    from rosic.core.language import Do
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.robot.skill import Argument
    from rosic.gateway.components import Components
    from rosic.organiser.timezones import Zone


# ---- the words of ``/task`` ----

LONGEST_LINE = 2_000
THEN = " then "
THENS: Final = frozenset({"then", "dann"})
FULL = 100.0
PRIORITY: Final = 1
ANYBODY: Final = "any"


class TaskWish(msgspec.Struct, frozen=True):
    """A task as somebody asked for it.

    Attributes:
        words: Whom and what, before the conditions.
        conditions: As they were typed, all of them.
        until_ns: Wall clock; 0 never passes.
    """

    words: list[str]
    conditions: tuple[str, ...] = ()
    priority: int = PRIORITY
    until_ns: int = 0
    expected_s: float = 0.0
    battery: float = 0.0
    localised: bool = False
    once: bool = False

    def lines(self, after: int) -> tuple[str, ...]:
        """Return the steps that follow so many words.

        Raises:
            NotUnderstood, OutOfBounds: There are none, or too many.
        """
        said: list[list[str]] = [[]]
        for word in self.words[after:]:
            bare = word.rstrip(";")
            if bare and bare.casefold() not in THENS:
                said[-1].append(bare)
            if bare != word or word.casefold() in THENS:
                said.append([])
        lines = tuple(" ".join(step) for step in said if step)
        if not lines:
            raise NotUnderstood(words.NO_STEPS)
        if len(lines) > STEPS_AT_MOST:
            raise OutOfBounds(words.too_many_steps(STEPS_AT_MOST))
        return lines

    def typed(self, after: int, lines: Sequence[str]) -> str:
        """Return the whole line for other steps, under the same conditions.

        Args:
            after: How many words say for whom.
            lines: The steps.
        """
        return " ".join(["/task", *self.words[:after], THEN.join(lines), *self.conditions])


def given_again(task: Task, lines: Sequence[str]) -> str:
    """Return the line that gives a task anew, as somebody types it; without when it was to be."""
    conditions = [
        f"priority {task.priority}" if task.priority != PRIORITY else "",
        f"battery {task.need.battery:g}" if task.need.battery else "",
        "localised" if task.need.localised else "",
        "once" if task.once else "",
        f"within {task.expected_ns / 1e9:g} s" if task.expected_ns else "",
    ]
    said = ["/task", task.wanted or ANYBODY, THEN.join(lines), *conditions]
    return " ".join(filter(None, said))


def read_wish(text: str, now_ns: int, zone: Zone) -> TaskWish:
    """Read the conditions off the end of a line, as many as there are.

    Args:
        text: As typed after the verb.
        now_ns: Wall clock.
        zone: In which a time of day is meant.

    Raises:
        OutOfBounds: A number or a time that makes no sense.
    """
    line = clean(text).replace("\n", " ")
    if len(line) > LONGEST_LINE:  # what is cut off may be what makes it safe
        raise OutOfBounds(words.too_long(LONGEST_LINE))
    wish = TaskWish(line.split())
    while (at := _last(wish.words)) is not None:
        key, said = wish.words[at].casefold(), [word.casefold() for word in wish.words[at + 1 :]]
        read = _READ[key](wish, said, now_ns, zone)
        if read is None:
            break
        conditions = (*wish.words[at:], *wish.conditions)
        wish = replace(read, words=wish.words[:at], conditions=conditions)
    return wish


def _last(said: list[str]) -> int | None:
    """Return where the last condition begins; the first words say whom and what."""
    return next((at for at in range(len(said) - 1, 1, -1) if said[at].casefold() in _READ), None)


def _priority(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> TaskWish | None:
    if len(said) != 1 or not said[0].isdecimal():
        return None
    least, most = PRIORITIES
    if not least <= int(said[0]) <= most:
        raise OutOfBounds(words.no_priority(least, most))
    return replace(wish, priority=int(said[0]))


def _battery(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> TaskWish | None:
    number = "".join(said).removesuffix("%")
    if not number.isdecimal():
        return None
    if not 0 < int(number) <= FULL:
        raise OutOfBounds(words.no_battery())
    return replace(wish, battery=float(number))


def _localised(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> TaskWish | None:
    return None if said else replace(wish, localised=True)


def _once(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> TaskWish | None:
    return None if said else replace(wish, once=True)


def _within(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> TaskWish | None:
    seconds, used = length_said(said)
    if not used or used != len(said):
        return None
    if seconds <= 0:
        raise OutOfBounds(words.no_time())
    return replace(wish, expected_s=seconds)


def _by(wish: TaskWish, said: list[str], now_ns: int, zone: Zone) -> TaskWish | None:
    seconds, used = length_said(said[1:]) if said[:1] == ["in"] else (0.0, 0)
    if seconds > 0 and used == len(said) - 1:  # to the second: a minute may be all there is
        return replace(wish, until_ns=now_ns + int(seconds * 1e9))
    when = read_when(f"{' '.join(said)} 1 min", now_ns, zone.local) if said else None
    if not isinstance(when, RequestedTime) or when.rrule:
        return None
    at_ns = when.start_ns
    if at_ns is None:
        at_ns = zone.instant(when.start).start_ns
    if at_ns <= now_ns:
        raise OutOfBounds(words.TOO_LATE)
    return replace(wish, until_ns=at_ns)


_READ: dict[str, Callable[[TaskWish, list[str], int, Zone], TaskWish | None]] = {
    "priority": _priority,
    "battery": _battery,
    "localised": _localised,
    "localized": _localised,
    "once": _once,
    "within": _within,
    "by": _by,
    # In German.
    "priorität": _priority,
    "akku": _battery,
    "verortet": _localised,
    "einmal": _once,
    "binnen": _within,
    "bis": _by,
}


# ---- which robots can do it ----

READ_AT_MOST: Final = 2_000
"""So many different steps are read for one task, of all robots it may be for together."""
READ_IN_A_ROW: Final = 16
"""After so many the others of the gateway have their turn: a stop is not to wait for a task."""
LOOKED_AT_MOST = 20  # robots, for what one of them could do instead
GO_TO_PARTS = 3  # of what a profile says: a skill, x and y


class CapableRobots(NamedTuple):
    """Who can carry out some lines.

    Attributes:
        robots: Those who can, in the order in which they were asked about.
        place: Where the lines lead to first; None when they lead nowhere.
        skills: By id, of the first who can.
        lacking: Why the first who cannot, cannot; rather of one who could with other values.
    """

    robots: tuple[RobotId, ...]
    place: tuple[float, float] | None
    skills: tuple[str, ...]
    lacking: MissingPart | None


def step_for(rooms: Components, robot: RobotId, line: str) -> Do:
    """Return one line as one robot understands it.

    Raises:
        Refusal: It is no single command of this robot, or a value is missing or out of bounds.
    """
    step = StepReader(rooms).read(robot, line)
    bind(rooms.vocabulary, robot, step.skills[0], step.spoken)
    return step


def check_units(
    rooms: Components,
    words_of: Catalogue | None,
    robot: RobotId,
    lines: Iterable[str],
    typed: Callable[[Sequence[str]], str],
) -> None:
    """Refuse numbers without a unit, typed by somebody who reads feet, with both readings.

    The same is asked of a line that is followed at once, see `ChatHandler.check_units`.

    Args:
        rooms: With the vocabulary.
        words_of: What its author reads.
        robot: Whose lines; they were understood.
        lines: What it is to do.
        typed: Says the whole command anew, with other lines.

    Raises:
        NotUnderstood: There is one.
    """
    if not isinstance(words_of, ImperialCatalogue):
        return
    reader, question = StepReader(rooms), None
    in_feet: list[str] = []
    in_metres: list[str] = []
    for line in lines:
        asked = unit_needed(rooms.vocabulary, reader.read(robot, line))
        feet, metres = (line, line) if asked is None else asked.offers
        in_feet.append(feet.removeprefix(f"{robot} "))
        in_metres.append(metres.removeprefix(f"{robot} "))
        question = question or asked
    if question is not None:
        raise NotUnderstood(question.sentence, offers=(typed(in_feet), typed(in_metres)))


class ReadStep(NamedTuple):
    """One line that a robot can carry out.

    Attributes:
        skill: By id.
        place: Where it leads to; None when it leads nowhere.
    """

    skill: str
    place: tuple[float, float] | None


class RobotSteps(NamedTuple):
    """What is asked of each of some robots, step by step, before anybody looks who can do it."""

    robots: tuple[RobotId, ...]
    lines: tuple[str, ...]


class PermittedSteps:
    """What robots can carry out for one person; each line is looked at once for each robot.

    Attributes:
        reader: Reads lines, whoever asks.
    """

    def __init__(self, rooms: Components, who: PrincipalId) -> None:
        self._rooms = rooms
        self._who = who
        self.reader = StepReader(rooms)
        self._seen: dict[tuple[RobotId, str], ReadStep | Refusal] = {}
        self._in_a_row = 0

    async def look(self, robot: RobotId, lines: Iterable[str], *, to_the_end: bool) -> None:
        """Read lines ahead of `all`, and give way to others meanwhile.

        Args:
            robot: Whose lines.
            lines: What it is to do.
            to_the_end: Also those behind one that it cannot carry out.
        """
        for line in dict.fromkeys(lines):
            if (robot, line) not in self._seen:
                self._in_a_row += 1
                if self._in_a_row >= READ_IN_A_ROW:
                    self._in_a_row = 0
                    await asyncio.sleep(0)
            if isinstance(self._one(robot, line), Refusal) and not to_the_end:
                return

    def all(self, robot: RobotId, lines: Iterable[str]) -> list[ReadStep]:
        """Return lines as one robot can carry them out.

        Raises:
            Refusal: It cannot, or not for this person.
        """
        found: list[ReadStep] = []
        for line in lines:
            step = self._one(robot, line)
            if isinstance(step, Refusal):
                raise step.with_traceback(None)
            found.append(step)
        return found

    def _one(self, robot: RobotId, line: str) -> ReadStep | Refusal:
        seen = self._seen.get((robot, line))
        if seen is None:
            try:
                seen = self._read(robot, line)
            except Refusal as refusal:
                seen = refusal
            self._seen[robot, line] = seen
        return seen

    def _read(self, robot: RobotId, line: str) -> ReadStep:
        organiser, profile = self._rooms.organiser, self._rooms.profiles[robot]
        [skill] = (step := self.reader.read(robot, line)).skills
        arguments = bind(self._rooms.vocabulary, robot, skill, step.spoken)
        if not organiser.allows(self._who, robot, skill.id):
            raise words.not_permitted(profile.shown, skill)
        if organiser.rights.caution(robot, skill.id).needs:
            raise words.wants_a_person(profile.shown, skill)
        leads = profile.go_to.split()[:1] == [skill.id]
        return ReadStep(skill.id, _place(profile, arguments) if leads else None)


def readings(robots: Collection[RobotId], lines: Iterable[str]) -> int:
    """Return how many lines are read to find out who can carry out all of them.

    Raises:
        OutOfBounds: More than are read for one task.
    """
    different = len(set(lines))
    if different * len(robots) > READ_AT_MOST:
        raise OutOfBounds(words.too_much_to_read(different, len(robots), READ_AT_MOST))
    return different * len(robots)


async def able(
    steps: PermittedSteps,
    rooms: Components,
    fleet: FleetState,
    robots: Iterable[RobotId],
    lines: Sequence[str],
) -> CapableRobots:
    """Return which of some robots can carry out all of the lines, by rights and by skills.

    One that is retired can do nothing: nobody waits for it. Others have their turn meanwhile, and
    a robot may be gone afterwards.
    """
    found: list[RobotId] = []
    refused: list[tuple[RobotId, Refusal]] = []
    place: tuple[float, float] | None = None
    skills: tuple[str, ...] = ()
    for robot in robots:
        if robot in rooms.profiles and fleet.standing(robot) is not FleetMembership.RETIRED:
            await steps.look(robot, lines, to_the_end=False)
        if (profile := rooms.profiles.get(robot)) is None:
            continue
        try:
            if fleet.standing(robot) is FleetMembership.RETIRED:
                raise NotUnderstood(is_retired(profile.shown, robot))
            does = steps.all(robot, lines)
        except Refusal as refusal:
            refused.append((robot, refusal))
        else:
            skills = skills or tuple(step.skill for step in does)
            found.append(robot)
            place = place or next((step.place for step in does if step.place), None)
    if not found:
        return CapableRobots((), None, (), await _rather(steps, rooms, refused, lines))
    return CapableRobots(tuple(found), place, skills, None)


async def _rather(
    steps: PermittedSteps,
    rooms: Components,
    refused: Iterable[tuple[RobotId, Refusal]],
    lines: Sequence[str],
) -> MissingPart | None:
    """Return what is lacking to the first that something would help, or else to the first."""
    first: MissingPart | None = None
    for robot, refusal in islice(refused, LOOKED_AT_MOST):
        await asyncio.sleep(0)  # for each it takes as long as for a line that was mistyped
        await steps.look(robot, lines, to_the_end=True)
        if robot not in rooms.profiles:
            continue
        instead = TaskAlternatives(steps.reader, robot, partial(steps.all, robot))
        lacking = instead.lacking(lines, refusal)
        if lacking.helps:
            return lacking
        first = first or lacking
    return first


def _place(profile: Profile, arguments: Mapping[str, Argument]) -> tuple[float, float] | None:
    parts = profile.go_to.split()
    if len(parts) != GO_TO_PARTS:
        return None
    at = [arguments.get(name) for name in parts[1:]]
    x, y = at
    if isinstance(x, int | float) and isinstance(y, int | float):
        return float(x), float(y)
    return None
