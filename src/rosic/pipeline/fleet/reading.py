"""Which robots can carry out what was said: as if it had been typed for each of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosic.core.fleet.task import Standing
from rosic.core.language import Context, Do, bind, understand
from rosic.errors import NotUnderstood, Refusal
from rosic.pipeline.fleet import words_fleet as words
from rosic.pipeline.fleet.words_robots import is_retired

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rosic.core.fleet.state import FleetState
    from rosic.core.identity import PrincipalId
    from rosic.core.robot import Profile, RobotId
    from rosic.core.skill import Argument
    from rosic.pipeline.rooms import Rooms

GO_TO_PARTS = 3  # of what a profile says: a skill, x and y


class Able(NamedTuple):
    """Who can carry out some lines.

    Attributes:
        robots: Those who can, in the order in which they were asked about.
        place: Where the lines lead to first; None when they lead nowhere.
        skills: By id, of the first who can.
        why: Why the first who cannot, cannot.
    """

    robots: tuple[RobotId, ...]
    place: tuple[float, float] | None
    skills: tuple[str, ...]
    why: Refusal | None


def step_for(rooms: Rooms, robot: RobotId, line: str) -> Do:
    """Return one line as one robot understands it.

    Raises:
        Refusal: It is no single command of this robot, or a value is missing or out of bounds.
    """
    context = Context(robot, frozenset({robot}))
    lines = understand(f"{robot} {line}", rooms.vocabulary, context)
    if len(lines) != 1 or not isinstance(lines[0], Do) or lines[0].robots != (robot,):
        raise NotUnderstood(words.no_command(rooms.profiles[robot].shown, line))
    bind(rooms.vocabulary, robot, lines[0].skills[0], lines[0].spoken)
    return lines[0]


def able(
    rooms: Rooms, fleet: FleetState, who: PrincipalId, robots: Iterable[RobotId],
    lines: Sequence[str],
) -> Able:  # fmt: skip
    """Return which of some robots can carry out all of the lines, by rights and by skills.

    One that is retired can do nothing: nobody waits for it.
    """
    found: list[RobotId] = []
    why: Refusal | None = None
    place: tuple[float, float] | None = None
    for robot in robots:
        try:
            if fleet.standing(robot) is Standing.RETIRED:
                raise NotUnderstood(is_retired(rooms.profiles[robot].shown, robot))
            leads = _all(rooms, who, robot, lines)
        except Refusal as refusal:
            why = why or refusal
        else:
            found.append(robot)
            place = place or leads
    skills = [step_for(rooms, found[0], line).skills[0].id for line in lines] if found else []
    return Able(tuple(found), place, tuple(skills), why)


def _all(
    rooms: Rooms, who: PrincipalId, robot: RobotId, lines: Sequence[str]
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
