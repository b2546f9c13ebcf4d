"""Which robots can carry out what was said: as if it had been typed for each of them."""

from __future__ import annotations

from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, NamedTuple

from rosic.core.fleet.task import FleetMembership
from rosic.core.language import bind
from rosic.errors import NotUnderstood, Refusal
from rosic.features.fleet import messages as words
from rosic.features.fleet.alternatives import TaskAlternatives, read_step
from rosic.features.fleet.robot_messages import is_retired

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rosic.core.fleet.state import FleetState
    from rosic.core.identity import PrincipalId
    from rosic.core.language import Do
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.robot.skill import Argument
    from rosic.features.fleet.alternatives import MissingPart
    from rosic.gateway.components import Components

LOOKED_AT_MOST = 50  # robots, for what one of them could do instead
GO_TO_PARTS = 3  # of what a profile says: a skill, x and y


class Able(NamedTuple):
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
    rooms: Components, fleet: FleetState, who: PrincipalId, robots: Iterable[RobotId],
    lines: Sequence[str],
) -> Able:  # fmt: skip
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
        return Able((), None, (), _rather(why))
    skills = tuple(step_for(rooms, found[0], line).skills[0].id for line in lines)
    return Able(tuple(found), place, skills, None)


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
