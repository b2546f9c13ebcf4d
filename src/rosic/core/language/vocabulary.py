"""Everything that can be said, compiled from the profiles; changed whole or not at all."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.core.language.cancel_detection import is_cancel_word
from rosic.core.language.command import VERBS, CommandTable
from rosic.core.language.common_names import TYPED
from rosic.core.language.compiled import (
    CompiledRobot,
    CompiledSkill,
    NameTarget,
    compile_skill,
    fold,
    skills_of,
    spellings,
)
from rosic.core.language.kept_places import KeptPlace
from rosic.core.language.keywords import EVERYTHING, FILLERS, NOT_FINITE, NOTHING, NUMBERS
from rosic.core.language.lexicon import (
    NO_PHRASES,
    Phrasebook,
    longest_by_first_word,
)
from rosic.core.language.line_words import phrase_key
from rosic.core.language.numbers import UnitTable, read_numeral
from rosic.core.language.phrase_words import RobotWords, robot_words, words_with_places
from rosic.core.language.profile_phrases import check_phrases
from rosic.core.language.sanitise import clean_name, quote
from rosic.core.language.stop_detection import is_stop_word
from rosic.core.robot.profile import Profile, RobotId
from rosic.core.signal import Signal

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rosic.core.robot.skill import Argument, Skill

_RESERVED = VERBS | FILLERS | EVERYTHING | NOTHING | frozenset(NUMBERS) | frozenset(NOT_FINITE)


class Vocabulary(msgspec.Struct, frozen=True, kw_only=True):
    """A snapshot of robots, groups, skills and units. `VocabularyHolder` holds the newest.

    Attributes:
        commands: What can be asked of ROSIC itself.
        profiles: By robot id, in the order in which they were given.
        callees: Every name, title and other word for a robot or a group.
        longest_callee: First word of a name to the number of words in the longest such name.
        having: What people say for a skill to the robots that have it.
        longest_skill: As ``longest_callee``, for skills.
        phrases: What people write in other words than these, by language.
        words: By robot, what its profile lets be said, for reading such phrases.
        spoken_names: As ``callees``, by the words of a name as phrases have them.
        longest_spoken: As ``longest_callee``, for ``spoken_names``.
        groups: Each group once.
        known: Every name, verb, skill, parameter and choice: none of them is a misspelt word,
            whatever it resembles.
        places: What people have kept for each robot, by name.
    """

    units: UnitTable
    commands: CommandTable
    profiles: dict[RobotId, Profile]
    robots: dict[RobotId, CompiledRobot]
    callees: dict[str, NameTarget]
    longest_callee: dict[str, int]
    having: dict[str, frozenset[RobotId]]
    longest_skill: dict[str, int]
    known: frozenset[str]
    places: dict[RobotId, dict[str, KeptPlace]] = {}
    phrases: Phrasebook = NO_PHRASES
    words: dict[RobotId, RobotWords] = {}
    spoken_names: dict[str, NameTarget] = {}
    longest_spoken: dict[str, int] = {}
    groups: tuple[NameTarget, ...] = ()

    @classmethod
    def build(
        cls,
        profiles: Iterable[Profile],
        units: UnitTable,
        commands: CommandTable,
        phrases: Phrasebook = NO_PHRASES,
    ) -> Vocabulary:
        """Compile profiles, and keep what commands and phrases there are beside them.

        Raises:
            ValueError: Two things would have one name, or a unit is unknown. The sentence names
                the robot, and what is wrong.
        """
        by_id: dict[RobotId, Profile] = {}
        for profile in profiles:
            if by_id.setdefault(profile.id, profile) is not profile:
                raise ValueError(f"two robots are called {quote(profile.id)}")
        shared: dict[str, CompiledSkill] = {}
        names = _chosen_names(by_id.values())
        robots = {n: _compile_robot(p, units, shared, names) for n, p in by_id.items()}
        callees = _callees(robots)
        having = _having(robots)
        for phrase in having:
            if phrase in callees:
                raise ValueError(
                    f"{quote(phrase)} is both a skill of {min(having[phrase])} and a name "
                    f"for {callees[phrase].name}"
                )
        _add_loose_names(robots, callees, frozenset(having))
        skills = [c for robot in robots.values() for c in robot.skills.values()]
        said = [*(c.words for c in skills), *(c.by_name for c in skills)]
        if phrases.tables:
            for robot in robots.values():
                check_phrases(robot, phrases)
        spoken_names = {phrase_key(name): callee for name, callee in callees.items()}
        return cls(
            units=units,
            commands=commands,
            profiles=by_id,
            robots=robots,
            callees=callees,
            longest_callee=longest_by_first_word(iter(callees)),
            having=having,
            longest_skill=longest_by_first_word(iter(having)),
            known=frozenset(VERBS).union(NUMBERS, callees, having, *said),
            phrases=phrases,
            words=_words(robots) if phrases.tables else {},
            spoken_names=spoken_names,
            longest_spoken=longest_by_first_word(iter(spoken_names)),
            groups=tuple([callee for callee in _distinct(callees) if callee.group]),
        )

    @property
    def names(self) -> tuple[str, ...]:
        """The ids of robots, then the names of groups."""
        groups = dict.fromkeys(c.name for c in self.callees.values() if c.group)
        return (*self.profiles, *groups)

    def robot(self, name: str) -> Profile | None:
        """Return the robot that a name, a title or another word calls."""
        callee = self.callees.get(fold(name))
        return callee.robots[0].profile if callee is not None and not callee.group else None

    def members(self, group: str) -> tuple[RobotId, ...]:
        """Return the robots of a group; none for an unknown one."""
        callee = self.callees.get(fold(group))
        return tuple(r.id for r in callee.robots) if callee is not None and callee.group else ()

    def skill(self, robot: RobotId, spoken: str) -> Skill | None:
        """Return the skill of a robot that a person calls so."""
        compiled = self.compiled_skill(robot, fold(spoken))
        return compiled.skill if compiled is not None else None

    def compiled_skill(self, robot: RobotId, name: str) -> CompiledSkill | None:
        """Return a skill by its id, or by what is said for it."""
        known = self.robots.get(robot)
        if known is None:
            return None
        return known.skills.get(name) or known.phrases.get(name)

    def declared(
        self, robot: RobotId, skill: str, arguments: Mapping[str, Argument]
    ) -> dict[str, Argument]:
        """Return arguments in SI as programs give them: numbers in their declared units.

        Of a skill that there is not any more there are none.
        """
        known = self.robots.get(robot)
        compiled = None if known is None else known.skills.get(skill)
        return {} if compiled is None else compiled.declared(arguments)

    def to_stop(
        self, names: tuple[str, ...], visible: frozenset[RobotId]
    ) -> tuple[tuple[RobotId, ...], tuple[str, ...]]:
        """Return whom a stop means, and which of its words say nothing to this person.

        Whatever is not understood in a stop makes it a stop of everything visible.

        Args:
            names: As `hears_stop` returned them.
            visible: The robots this person may see.
        """
        meant: dict[RobotId, None] = {}
        unknown: list[str] = []
        at = 0
        while at < len(names):
            found, at = self._visible_from(names, at, visible)
            if not found:
                unknown.append(names[at - 1])
            meant.update(dict.fromkeys(found))
        if unknown or not meant:
            return tuple(r for r in self.profiles if r in visible), tuple(unknown)
        return tuple(meant), ()

    def _visible_from(
        self, names: tuple[str, ...], at: int, visible: frozenset[RobotId]
    ) -> tuple[tuple[RobotId, ...], int]:
        for count in range(self.longest_callee.get(names[at], 0), 0, -1):
            callee = self.callees.get(" ".join(names[at : at + count]))
            if callee is not None:
                found = tuple(r.id for r in callee.robots if r.id in visible)
                if found:
                    return found, at + count
        return (), at + 1


class VocabularyHolder:
    """Which vocabulary counts now.

    Attributes:
        current: The newest. Ask for it each time: whoever keeps it goes on with an old one.
        replaced: Tells whoever remembers what was read with the one before.
    """

    __slots__ = ("current", "replaced")

    def __init__(self, current: Vocabulary) -> None:
        self.current = current
        self.replaced: Signal[[]] = Signal()

    def replace(self, newer: Vocabulary) -> None:
        """Let another snapshot count from now on, for everybody at once.

        Between two turns of the event loop: whoever reads a line reads it with one of them. The
        places that are kept go on.
        """
        places = self.current.places
        words = {
            robot: words_with_places(newer.words[robot], kept)
            for robot, kept in places.items()
            if robot in newer.words
        }
        self.current = msgspec.structs.replace(newer, places=places, words={**newer.words, **words})
        self.replaced.emit()

    def keep_places(self, robot: RobotId, places: dict[str, KeptPlace]) -> None:
        """Let these be the places of a robot from now on, for everybody at once."""
        everybody = {**self.current.places, robot: places}
        if not places:
            del everybody[robot]
        words = self.current.words
        if robot in words:
            words = {**words, robot: words_with_places(words[robot], places)}
        self.current = msgspec.structs.replace(self.current, places=everybody, words=words)
        self.replaced.emit()


def means_else(name: str) -> bool:
    """Whether a name says something else: a verb, a stop, or that somebody ends what they do."""
    return name in _RESERVED or is_stop_word(name.split(maxsplit=1)[0]) or is_cancel_word(name)


def _refuse_reserved(name: str, what: str) -> None:
    words = name.split()
    if not words:
        raise ValueError(f"{what} has an empty name")
    if means_else(name) or read_numeral(name) is not None:
        raise ValueError(f"{what} cannot be called {quote(name)}: that word means something else")


def _compile_robot(
    profile: Profile, units: UnitTable, shared: dict[str, CompiledSkill], names: frozenset[str]
) -> CompiledRobot:
    skills: dict[str, CompiledSkill] = {}
    for name, skill in skills_of(profile).items():
        same = repr(skill)
        try:
            skills[name] = shared.get(same) or compile_skill(skill, units)
        except ValueError as error:
            raise ValueError(f"robot {profile.id}, skill {name!r}: {error}") from error
        shared[same] = skills[name]
    phrases = _phrases(profile.id, skills)
    for name in TYPED:
        if name in skills:
            for word in TYPED[name]:
                if word not in names and not means_else(word):
                    phrases.setdefault(word, skills[name])
    return CompiledRobot(
        id=profile.id,
        profile=profile,
        shown=clean_name(profile.shown) or profile.id,
        names=tuple(
            dict.fromkeys((profile.id, *map(fold, profile.words), *profile.groups)),
        ),
        skills=skills,
        phrases=phrases,
        longest=longest_by_first_word(phrases),
    )


def _chosen_names(profiles: Iterable[Profile]) -> frozenset[str]:
    """Return what robots and groups are called by whoever wrote their profiles."""
    return frozenset(fold(name) for p in profiles for name in (p.id, p.shown, *p.words, *p.groups))


def _phrases(robot: RobotId, skills: dict[str, CompiledSkill]) -> dict[str, CompiledSkill]:
    """Return what can be said for each skill. A clash of chosen names is refused, of titles not."""
    phrases: dict[str, CompiledSkill] = {}
    for compiled in skills.values():
        skill = compiled.skill
        for phrase in (fold(skill.id), compiled.spoken, *map(fold, skill.words)):
            _refuse_reserved(phrase, f"robot {robot}: skill {skill.id!r}")
            other = phrases.setdefault(phrase, compiled)
            if other is not compiled:
                raise ValueError(
                    f"robot {robot}: {quote(phrase)} means both {other.skill.id} and {skill.id}"
                )
    for compiled in skills.values():
        skill = compiled.skill
        titles = (skill.title, *skill.titles.values())
        for phrase in (*spellings(skill.id), *(fold(clean_name(title)) for title in titles)):
            if phrase and not means_else(phrase):
                phrases.setdefault(phrase, compiled)
    return phrases


def _callees(robots: dict[RobotId, CompiledRobot]) -> dict[str, NameTarget]:
    callees: dict[str, NameTarget] = {}
    for robot in robots.values():
        callee = NameTarget(robot.id, (robot,))
        for name in dict.fromkeys((robot.id, *map(fold, robot.profile.words))):
            _refuse_reserved(name, f"robot {robot.id}")
            if name in callees:
                raise ValueError(f"{quote(name)} means both {callees[name].name} and {robot.id}")
            callees[name] = callee
    groups: dict[str, list[CompiledRobot]] = {}
    for robot in robots.values():
        for group in dict.fromkeys(robot.profile.groups):
            groups.setdefault(group, []).append(robot)
    for group, members in groups.items():
        _refuse_reserved(group, f"a group of {members[0].id}")
        if group in callees:
            raise ValueError(f"{quote(group)} is both a group and a name for {callees[group].name}")
        callees[group] = NameTarget(group, tuple(members), group=True)
    return callees


def _add_loose_names(
    robots: dict[RobotId, CompiledRobot], callees: dict[str, NameTarget], taken: frozenset[str]
) -> None:
    """Let titles and looser spellings be said too, where they leave no doubt."""
    loose: dict[str, list[NameTarget]] = {}
    for callee in _distinct(callees):
        titles = () if callee.group else (fold(robots[callee.name].shown),)
        for name in dict.fromkeys((*titles, *spellings(callee.name))):
            loose.setdefault(name, []).append(callee)
    for name, meant in loose.items():
        if len(meant) == 1 and name not in taken and not means_else(name):
            callees.setdefault(name, meant[0])


def _distinct(callees: dict[str, NameTarget]) -> Iterator[NameTarget]:
    seen: set[str] = set()
    for callee in tuple(callees.values()):
        if callee.name not in seen:
            seen.add(callee.name)
            yield callee


def _words(robots: dict[RobotId, CompiledRobot]) -> dict[RobotId, RobotWords]:
    """Return the words of each robot; robots whose profiles say the same share them."""
    shared: dict[tuple[int, ...], RobotWords] = {}
    found: dict[RobotId, RobotWords] = {}
    for robot in robots.values():
        same = (*map(id, robot.skills.values()), hash(tuple(robot.phrases)))
        words = shared.get(same)
        if words is None:
            words = shared[same] = robot_words(robot)
        found[robot.id] = words
    return found


def _having(robots: dict[RobotId, CompiledRobot]) -> dict[str, frozenset[RobotId]]:
    having: dict[str, list[RobotId]] = {}
    for robot in robots.values():
        for phrase in robot.phrases:
            having.setdefault(phrase, []).append(robot.id)
    return {phrase: frozenset(ids) for phrase, ids in having.items()}
