"""The places that are kept: durable, each of one robot, and part of what can be said."""

from __future__ import annotations

import logging
from collections import defaultdict
from hashlib import blake2b
from math import isfinite
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

import msgspec

from rosic.core.identity import DIGEST_BYTES, PrincipalId
from rosic.core.language import bind
from rosic.core.language.kept_places import KeptPlace
from rosic.core.order import SpokenValue
from rosic.core.records import Fact, Letter
from rosic.core.robot.profile import RobotId
from rosic.errors import NotUnderstood, Refusal
from rosic.features.places import messages as words

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.language import Vocabulary, VocabularyHolder
    from rosic.core.language.compiled import CompiledParameter, CompiledSkill
    from rosic.core.robot.profile import Presence, Profile

KIND: Final = "robot-place"
GO_TO: Final = "goto"
GO_TO_PARTS: Final = 3  # of what a profile says: a skill, x and y
HEADINGS: Final = frozenset({"yaw", "heading"})
FRESH_S: Final = 5.0
"""A value that is older does not say where a robot is now."""

PlaceNumbers: TypeAlias = tuple[float, float, float, float | None]
"""x, y and z in m, and yaw in rad; None where that is not known."""

log = logging.getLogger("rosic.places")


class PlaceEntry(msgspec.Struct, frozen=True):
    """Who keeps a place for which robot: in the open."""

    robot: RobotId
    by: PrincipalId
    at_ns: int


class PlacePose(msgspec.Struct, frozen=True):
    """Its name, and where it is, in SI: in the container of its robot."""

    name: str
    skill: str
    values: dict[str, float]


_encode = msgspec.msgpack.Encoder().encode
_entry = msgspec.msgpack.Decoder(PlaceEntry).decode
_description = msgspec.msgpack.Decoder(PlacePose).decode


class PlaceBook:
    """Every place; what can be said is told of each change."""

    def __init__(self, vocabularies: VocabularyHolder) -> None:
        self._vocabularies = vocabularies
        self._descriptions: defaultdict[RobotId, dict[str, PlacePose]] = defaultdict(dict)
        self._where: dict[str, tuple[RobotId, str]] = {}

    # ---- what is written ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so; one whose robot's container is erased is none."""
        robot, name = self._where.pop(fact.key, ("", ""))
        if robot:
            self._descriptions[robot].pop(name, None)
        if fact.body and fact.letter is not None:
            try:
                robot = _entry(fact.body).robot
                described = _description(fact.letter.content)
            except (msgspec.MsgspecError, ValueError):
                log.warning("a place cannot be read; it is left out")
                return
            self._where[fact.key] = robot, described.name
            self._descriptions[robot][described.name] = described
        if robot:
            self.say(robot)

    def say(self, robot: RobotId) -> None:
        """Let what is kept for a robot be said, as far as it can go there today."""
        vocabulary = self._vocabularies.current
        found: dict[str, KeptPlace] = {}
        for described in self._descriptions[robot].values():
            if described.name in vocabulary.known:
                log.warning("a place of %s is called like something that its profile says", robot)
                continue
            try:
                found[described.name] = kept_place(vocabulary, robot, described)
            except Refusal:
                log.warning("%s cannot be sent any more to a place that is kept", robot)
        self._vocabularies.keep_places(robot, found)

    def of(self, robot: RobotId) -> dict[str, PlacePose]:
        """Return what is kept for a robot, by name."""
        return self._descriptions.get(robot, {})

    def fact(self, entry: PlaceEntry, described: PlacePose) -> Fact:
        """Return what keeps a place."""
        letter = Letter(entry.robot, _encode(described))
        key = _key(entry.robot, described.name)
        return Fact(kind=KIND, key=key, body=_encode(entry), letter=letter)

    def end(self, robot: RobotId, name: str) -> Fact:
        """Return what forgets a place."""
        return Fact(kind=KIND, key=_key(robot, name), body=b"")


def _key(robot: RobotId, name: str) -> str:
    """Return a digest: names stand in the container alone."""
    return blake2b(f"{robot}/{name}".encode(), digest_size=DIGEST_BYTES).hexdigest()


# ---- where a robot is ----


class PlaceSkill(NamedTuple):
    """The skill of a robot that goes to a place, and its parameters in the order x, y."""

    compiled: CompiledSkill
    x: str
    y: str


def skill_of(vocabulary: Vocabulary, profile: Profile) -> PlaceSkill:
    """Return how a robot goes to a place.

    Raises:
        NotUnderstood: It does not.
    """
    said_parts = profile.go_to.split()
    name, x, y = said_parts if len(said_parts) == GO_TO_PARTS else (GO_TO, "x", "y")
    compiled = vocabulary.compiled_skill(profile.id, name)
    lengths = {} if compiled is None else {p.name for p in compiled.numbers if _is_length(p)}
    if compiled is None or not {x, y} <= set(lengths):
        raise NotUnderstood(words.goes_nowhere(profile.shown))
    return PlaceSkill(compiled, x, y)


def _is_length(parameter: CompiledParameter) -> bool:
    return parameter.unit.dimension == "length"


def here(vocabulary: Vocabulary, profile: Profile, seen: Presence) -> PlacePose:
    """Return where a robot is now, as its skill is told so; without a name.

    Raises:
        NotUnderstood: It moves, does not say where it is, or goes nowhere.
        OutOfBounds: It could not be sent to where it is.
    """
    going = skill_of(vocabulary, profile)
    if seen.moves:
        raise NotUnderstood(words.moves(profile.shown))
    at = _at(seen)
    if at is None:
        raise NotUnderstood(words.not_known(profile.shown))
    said_of = {going.x: at[0], going.y: at[1]}
    values: dict[str, float] = {}
    for parameter in going.compiled.parameters:
        value = said_of.get(parameter.name)
        if value is None:
            value = _beside(parameter, at)
        if value is not None:
            values[parameter.name] = value
        elif parameter.default is None:
            raise NotUnderstood(words.says_not(profile.shown, parameter.shown))
    return PlacePose("", going.compiled.skill.id, values)


def _beside(parameter: CompiledParameter, at: PlaceNumbers) -> float | None:
    """Return what a pose says of another parameter than x and y; None: nothing."""
    if parameter.name == "z" and _is_length(parameter):
        return at[2]
    return at[3] if parameter.name in HEADINGS else None


def _at(seen: Presence) -> PlaceNumbers | None:
    """Return x, y, z and yaw of a robot, as far as it has said so just now."""
    pose = seen.pose
    if pose is not None and seen.online is not False:
        found = pose.x_m, pose.y_m, pose.z_m, pose.yaw_rad
        return found if all(isfinite(value) for value in found if value is not None) else None
    fresh = {
        name: value
        for name, value in seen.values.items()
        if isinstance(value, int | float) and seen.ages_s.get(name, 0.0) <= FRESH_S
    }
    if seen.online is False or not {"x", "y"} <= fresh.keys():
        return None
    return float(fresh["x"]), float(fresh["y"]), float(fresh.get("z", 0.0)), None


def kept_place(vocabulary: Vocabulary, robot: RobotId, described: PlacePose) -> KeptPlace:
    """Return what a place stands for when it is said.

    Raises:
        NotUnderstood, OutOfBounds: The robot cannot be sent there.
    """
    compiled = vocabulary.compiled_skill(robot, described.skill)
    if compiled is None:
        raise NotUnderstood(words.goes_nowhere(robot))
    spoken = tuple(
        SpokenValue(name, round(unit.from_si(value), 4), unit.symbol)
        for name, value in described.values.items()
        if name in compiled.by_name
        for unit in (compiled.by_name[name].unit,)
    )
    arguments = bind(vocabulary, robot, compiled.skill, spoken)
    return KeptPlace(described.name, compiled.skill.id, spoken, arguments)
