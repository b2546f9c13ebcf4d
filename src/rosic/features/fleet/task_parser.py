"""What is said after ``/task``: for whom, what, step by step, and under which conditions."""

from __future__ import annotations

from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.core.fleet.task import PRIORITIES, STEPS_AT_MOST, FleetMembership
from rosic.core.language import bind, clean
from rosic.core.language.time_parser import RequestedTime, read_when
from rosic.core.language.time_tokens import length_said
from rosic.errors import NotUnderstood, OutOfBounds, Refusal
from rosic.features.fleet import messages as words
from rosic.features.fleet.alternatives import TaskAlternatives, read_step
from rosic.features.fleet.robot_messages import is_retired

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from rosic.core.fleet.state import FleetState
    from rosic.core.fleet.task import Task
    from rosic.core.identity import PrincipalId
    from rosic.core.language import Do
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.robot.skill import Argument
    from rosic.features.fleet.alternatives import MissingPart
    from rosic.gateway.components import Components
    from rosic.organiser.timezones import Zone


# ---- the words of ``/task`` ----

LONGEST_LINE = 2_000
THEN = " then "
THENS: Final = frozenset({"then", "dann"})
FULL = 100.0
PRIORITY: Final = 1
ANYBODY: Final = "any"


class TaskWish(msgspec.Struct):
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
        if not _READ[key](wish, said, now_ns, zone):
            break
        wish.conditions = (*wish.words[at:], *wish.conditions)
        del wish.words[at:]
    return wish


def _last(said: list[str]) -> int | None:
    """Return where the last condition begins; the first words say whom and what."""
    return next((at for at in range(len(said) - 1, 1, -1) if said[at].casefold() in _READ), None)


def _priority(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> bool:
    if len(said) != 1 or not said[0].isdecimal():
        return False
    least, most = PRIORITIES
    if not least <= int(said[0]) <= most:
        raise OutOfBounds(words.no_priority(least, most))
    wish.priority = int(said[0])
    return True


def _battery(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> bool:
    number = "".join(said).removesuffix("%")
    if not number.isdecimal():
        return False
    if not 0 < int(number) <= FULL:
        raise OutOfBounds(words.no_battery())
    wish.battery = float(number)
    return True


def _localised(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> bool:
    wish.localised = not said
    return not said


def _once(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> bool:
    wish.once = not said
    return not said


def _within(wish: TaskWish, said: list[str], _now_ns: int, _zone: Zone) -> bool:
    seconds, used = length_said(said)
    if not used or used != len(said):
        return False
    if seconds <= 0:
        raise OutOfBounds(words.no_time())
    wish.expected_s = seconds
    return True


def _by(wish: TaskWish, said: list[str], now_ns: int, zone: Zone) -> bool:
    seconds, used = length_said(said[1:]) if said[:1] == ["in"] else (0.0, 0)
    if seconds > 0 and used == len(said) - 1:  # to the second: a minute may be all there is
        wish.until_ns = now_ns + int(seconds * 1e9)
        return True
    when = read_when(f"{' '.join(said)} 1 min", now_ns, zone.local) if said else None
    if not isinstance(when, RequestedTime) or when.rrule:
        return False
    at_ns = when.start_ns
    if at_ns is None:
        at_ns = zone.instant(when.start).start_ns
    if at_ns <= now_ns:
        raise OutOfBounds(words.TOO_LATE)
    wish.until_ns = at_ns
    return True


_READ: dict[str, Callable[[TaskWish, list[str], int, Zone], bool]] = {
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

LOOKED_AT_MOST = 50  # robots, for what one of them could do instead
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
    step = read_step(rooms, robot, line)
    bind(rooms.vocabulary, robot, step.skills[0], step.spoken)
    return step


def able(
    rooms: Components,
    fleet: FleetState,
    who: PrincipalId,
    robots: Iterable[RobotId],
    lines: Sequence[str],
) -> CapableRobots:
    """Return which of some robots can carry out all of the lines, by rights and by skills.

    One that is retired can do nothing: nobody waits for it.
    """
    found: list[RobotId] = []
    refused: list[tuple[RobotId, Refusal]] = []
    place: tuple[float, float] | None = None
    for robot in robots:
        try:
            if fleet.standing(robot) is FleetMembership.RETIRED:
                raise NotUnderstood(is_retired(rooms.profiles[robot].shown, robot))
            leads = _all(rooms, who, robot, lines)
        except Refusal as refusal:
            refused.append((robot, refusal))
        else:
            found.append(robot)
            place = place or leads
    if not found:
        why = (
            TaskAlternatives(rooms, robot, partial(_all, rooms, who, robot)).lacking(lines, refusal)
            for robot, refusal in refused
        )
        return CapableRobots((), None, (), _rather(why))
    skills = tuple(step_for(rooms, found[0], line).skills[0].id for line in lines)
    return CapableRobots(tuple(found), place, skills, None)


def _rather(found: Iterable[MissingPart]) -> MissingPart | None:
    """Return the first that helps, or else the first."""
    first: MissingPart | None = None
    for one in islice(found, LOOKED_AT_MOST):
        if one.helps:
            return one
        first = first or one
    return first


def _all(
    rooms: Components, who: PrincipalId, robot: RobotId, lines: Sequence[str]
) -> tuple[float, float] | None:
    """Return where the lines lead to first.

    Raises:
        Refusal: It cannot, or not for this person.
    """
    place: tuple[float, float] | None = None
    organiser, profile = rooms.organiser, rooms.profiles[robot]
    for line in lines:
        [skill] = (step := step_for(rooms, robot, line)).skills
        if not organiser.allows(who, robot, skill.id):
            raise words.not_permitted(profile.shown, skill)
        if organiser.rights.caution(robot, skill.id).needs:
            raise words.wants_a_person(profile.shown, skill)
        if place is None and profile.go_to.split()[:1] == [skill.id]:
            place = _place(profile, bind(rooms.vocabulary, robot, skill, step.spoken))
    return place


def _place(profile: Profile, arguments: Mapping[str, Argument]) -> tuple[float, float] | None:
    parts = profile.go_to.split()
    if len(parts) != GO_TO_PARTS:
        return None
    at = [arguments.get(name) for name in parts[1:]]
    x, y = at
    if isinstance(x, int | float) and isinstance(y, int | float):
        return float(x), float(y)
    return None
