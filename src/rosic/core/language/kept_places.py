"""Places that people have kept under a name, each of one robot: ``omni goto dock``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from rosic.core.order import SpokenValue
from rosic.core.robot.skill import Argument

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.language.ast import Do
    from rosic.core.robot.profile import RobotId


class KeptPlace(msgspec.Struct, frozen=True):
    """What a name of a place stands for.

    Attributes:
        name: In small letters, one word.
        skill: Which goes there, by id.
        values: What is said to it instead of the name.
        arguments: What that comes to, SI; whoever is shown the same is shown the name, too.
    """

    name: str
    skill: str
    values: tuple[SpokenValue, ...]
    arguments: dict[str, Argument]


def with_places(line: Do, places: Mapping[RobotId, Mapping[str, KeptPlace]]) -> Do:
    """Return a line with the values of a place instead of its name, if it says one.

    Several robots have one place each by a name, so what is asked of a group says none.
    """
    known = places.get(line.robots[0])
    if not known or len(line.robots) > 1:
        return line
    for at, value in enumerate(line.spoken):
        place = known.get(value.word) if value.number is None and not value.name else None
        if place is not None and place.skill == line.skills[0].id:
            return replace(line, spoken=(*line.spoken[:at], *place.values, *line.spoken[at + 1 :]))
    return line


def place_at(places: Mapping[str, KeptPlace], skill: str, arguments: Mapping[str, Argument]) -> str:
    """Return how the place is called to which a skill goes with some arguments; else nothing."""
    for place in places.values():
        if place.skill == skill and place.arguments == arguments:
            return place.name
    return ""
