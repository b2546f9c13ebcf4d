"""What each word of a line may mean in one language, with the words of one robot beside it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.core.language.compiled import NameTarget
from rosic.core.language.lexicon import (
    CONTENT,
    LexiconTable,
    Sense,
    SenseKind,
    longest_by_first_word,
)
from rosic.core.language.line_words import THEN, SpokenLine, phrase_key
from rosic.core.language.numbers import FIRST, Numeral, read_numeral

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from rosic.core.language.compiled import (
        CompiledParameter,
        CompiledRobot,
        CompiledSkill,
    )
    from rosic.core.language.numbers import UnitTable


_SAYS_TOO_LITTLE: Final = frozenset({"home", "open", "closed", "close", "on", "off", "in", "out"})
"""Choices that name no skill by themselves: ``omni home`` may mean its arm, or its dock."""

# ---- the words of a robot ----


class RobotWords(NamedTuple):
    """What is said of a robot's skills and their choices, as a line is looked up.

    Attributes:
        senses: In every language.
        spoken: By language, what the profile lets be said in it alone.
        longest: First word to the number of words in the longest phrase, in any language.
        chosen: What people say for a choice, to the skills that have it: ``left``.
        choices: What people say for a choice, to the choice.
        places: The names of the places that are kept for it.
    """

    senses: dict[str, tuple[Sense, ...]]
    spoken: dict[str, dict[str, tuple[Sense, ...]]]
    longest: dict[str, int]
    chosen: dict[str, tuple[str, ...]]
    choices: dict[str, str]
    places: frozenset[str] = frozenset()


NO_WORDS: Final = RobotWords({}, {}, {}, {}, {})


def robot_words(robot: CompiledRobot) -> RobotWords:
    """Return the words of a robot's profile, for reading what people write."""
    senses: dict[str, dict[Sense, None]] = {}
    spoken: dict[str, dict[str, dict[Sense, None]]] = {}
    chosen: dict[str, dict[str, None]] = {}
    for phrase, skill in robot.phrases.items():
        _add(senses, phrase, Sense(SenseKind.OWN_SKILL, skill.skill.id))
    for skill in robot.skills.values():
        for word, choice in _choices(skill):
            _add(senses, word, Sense(SenseKind.OWN_CHOICE, word))
            if choice not in _SAYS_TOO_LITTLE:
                chosen.setdefault(word, {})[skill.skill.id] = None
        for name in skill.by_name:
            _add(senses, name, Sense(SenseKind.OWN_PARAMETER, name))
        _add_said(skill, spoken)
    return RobotWords(
        _frozen(senses),
        {language: _frozen(table) for language, table in spoken.items()},
        longest_by_first_word(key for table in (senses, *spoken.values()) for key in table),
        {word: tuple(skills) for word, skills in chosen.items()},
        {word: choice for skill in robot.skills.values() for word, choice in _choices(skill)},
    )


def words_with_places(words: RobotWords, names: Iterable[str]) -> RobotWords:
    """Return a robot's words with the names of the places that are kept for it now."""
    places = {phrase_key(name): name for name in names}
    senses = {key: _without_places(found) for key, found in words.senses.items()}
    for key, name in places.items():
        senses[key] = (*senses.get(key, ()), Sense(SenseKind.OWN_PLACE, name))
    kept = {key: found for key, found in senses.items() if found}
    keys = (key for table in (kept, *words.spoken.values()) for key in table)
    longest = longest_by_first_word(keys)
    return words._replace(senses=kept, longest=longest, places=frozenset(places))


def _without_places(senses: tuple[Sense, ...]) -> tuple[Sense, ...]:
    return tuple([sense for sense in senses if sense.kind is not SenseKind.OWN_PLACE])


def _choices(skill: CompiledSkill) -> Iterator[tuple[str, str]]:
    """Yield each spelling of a choice, and the choice."""
    for parameter in skill.choices:
        yield from (parameter.words or {}).items()


class ProfilePhrase(NamedTuple):
    """What a profile lets be said for a skill, or for a choice of it.

    Attributes:
        parameter: Of the choice; None: it is said for the skill.
        choice: Empty: it is said for the skill.
    """

    language: str
    phrase: str
    skill: CompiledSkill
    parameter: CompiledParameter | None = None
    choice: str = ""


def phrases_of(skill: CompiledSkill) -> Iterator[ProfilePhrase]:
    """Yield what a profile lets be said of a skill in one language or another."""
    for language, phrases in skill.skill.say.items():
        yield from (ProfilePhrase(language, phrase, skill) for phrase in phrases)
    for parameter in skill.choices:
        for choice, languages in skill.skill.parameters[parameter.name].say.items():
            for language, phrases in languages.items():
                for phrase in phrases:
                    yield ProfilePhrase(language, phrase, skill, parameter, choice)


def _add_said(skill: CompiledSkill, spoken: dict[str, dict[str, dict[Sense, None]]]) -> None:
    for said in phrases_of(skill):
        own = Sense(SenseKind.OWN_SKILL, skill.skill.id)
        sense = Sense(SenseKind.OWN_CHOICE, said.choice) if said.choice else own
        _add(spoken.setdefault(said.language, {}), said.phrase, sense)


def _add(table: dict[str, dict[Sense, None]], phrase: str, sense: Sense) -> None:
    key = phrase_key(phrase)
    if key:
        table.setdefault(key, {})[sense] = None


def _frozen(table: Mapping[str, dict[Sense, None]]) -> dict[str, tuple[Sense, ...]]:
    return {key: tuple(senses) for key, senses in table.items()}


# ---- the words of a line ----


class Item(msgspec.Struct, eq=False):
    """Some words of a line, and what they may mean.

    Attributes:
        text: The words, in small letters.
        raw: The same as typed.
        at, end: Their places.
        senses: Empty: they mean nothing in this language.
        callee: The robot or group that they name.
        numeral: The number that they begin with.
        follows_verb: They begin with a verb of any motion: ``go to``.
        by_kind: The senses by their sorts, once somebody has asked for them.
    """

    text: str
    at: int
    end: int
    senses: tuple[Sense, ...] = ()
    callee: NameTarget | None = None
    numeral: Numeral | None = None
    follows_verb: bool = False
    raw: str = ""
    by_kind: dict[SenseKind, tuple[str, ...]] | None = None

    @property
    def is_known(self) -> bool:
        """Whether they mean anything."""
        return bool(self.senses) or self.callee is not None or self.numeral is not None

    @property
    def kinds(self) -> Mapping[SenseKind, tuple[str, ...]]:
        """What they may mean, by its sort."""
        return self.by_kind or self._sorted()

    def means(self, kind: SenseKind) -> bool:
        """Whether they may mean something of a sort."""
        return kind in (self.by_kind or self._sorted())

    def values(self, kind: SenseKind) -> tuple[str, ...]:
        """Return what of a sort they may mean."""
        return (self.by_kind or self._sorted()).get(kind, ())

    def _sorted(self) -> dict[SenseKind, tuple[str, ...]]:
        """Sort the senses, of which a thousand questions a line are asked."""
        if not self.senses:
            return _NO_KINDS
        by_kind: dict[SenseKind, tuple[str, ...]] = {}
        for kind, value in self.senses:
            by_kind[kind] = (*by_kind.get(kind, ()), value)
        self.by_kind = by_kind
        return by_kind


_NO_KINDS: Final[dict[SenseKind, tuple[str, ...]]] = {}


class Places(NamedTuple):
    """Where robots and groups are named in a line.

    Attributes:
        named: Place of the first word, to who is named and where the name ends.
        owns: Something of theirs is spoken of: ``omni's``.
    """

    named: dict[int, tuple[NameTarget, int]]
    owns: bool = False

    @property
    def callees(self) -> tuple[NameTarget, ...]:
        """Who is named, in the order in which they are."""
        return tuple([callee for callee, _ in self.named.values()])


CLOCK: Final = re.compile(r"(\d{1,2})[:h](\d\d)")
_CLOCK: Final = (Sense(SenseKind.TIME, "clock"),)
_THEN: Final = (Sense(SenseKind.THEN, ""),)
_EQUALS: Final = (Sense(SenseKind.NOTHING, ""),)


class WordReader:
    """Reads the words of one line in one language.

    Args:
        line: Its words.
        table: The language.
        words: Of the robot that is spoken of.
        places: Who is named where.
        units: Those that are known in every language.
    """

    __slots__ = (
        "_breaks",
        "_line",
        "_own",
        "_places",
        "_raw",
        "_said",
        "_table",
        "_units",
        "_words",
    )

    def __init__(
        self,
        line: SpokenLine,
        table: LexiconTable,
        words: RobotWords,
        places: Places,
        units: UnitTable,
    ) -> None:
        self._line = line.words
        self._breaks = line.breaks
        self._raw = line.raw
        self._table = table
        self._words = words
        self._own = words.senses
        self._said = words.spoken.get(table.language, {})
        self._places = places
        self._units = units

    def items(self, most: int, *, mends: bool = False) -> tuple[list[Item], int] | None:
        """Return the line's words, each in one item, and how many mean nothing.

        Args:
            most: None where more than so many do: what another language knows better is not read
                to its end.
            mends: Whether a word that means nothing is taken for the one it was to be.
        """
        line, found, unknown = self._line, list[Item](), 0
        gaps = self._gaps() if not self._table.gapped.keys().isdisjoint(line) else {}
        at = 0
        while at < len(line):
            whole = self._phrase(at, counted=False) if at in gaps else None
            if at in gaps and (whole is None or whole.end - at <= gaps[at][1]):
                senses, length = gaps[at]
                text = " ".join(line[at : at + length])
                found.append(Item(text, at, at + length, senses))
            elif (named := self._places.named.get(at)) is not None:
                callee, end = named
                key = " ".join(line[at:end])
                found.append(Item(key, at, end, self._own.get(key, ()), callee))
            else:
                counted = bool(found) and _is_counted(found[-1])
                item = self._phrase(at, counted=counted)
                item = item or self._word(at, counted=counted, mends=mends)
                unknown += not item.is_known
                if unknown > most:
                    return None
                found.append(item)
            at = found[-1].end
        return found, unknown

    def _phrase(self, at: int, *, counted: bool) -> Item | None:
        """Return the longest phrase that begins here.

        Args:
            at: Here.
            counted: A number stands before it: what is a unit as well is one.
        """
        line, table, own, said = self._line, self._table, self._own, self._said
        word = line[at]
        longest = max(table.longest.get(word, 0), self._words.longest.get(word, 0))
        for count in range(min(longest, len(line) - at), 0, -1):
            if self._breaks and not self._breaks.isdisjoint(range(at + 1, at + count)):
                continue
            key = word if count == 1 else " ".join(line[at : at + count])
            senses = table.senses.get(key, ())
            if key in own or key in said:
                senses = (*own.get(key, ()), *said.get(key, ()), *senses)
            if senses:
                if count > 1 and (last := line[at + count - 1]) in self._words.places:
                    senses = (*senses, Sense(SenseKind.OWN_PLACE, last))  # to the dock
                verb = count > 1 and any(
                    sense.kind is SenseKind.VERB for sense in table.senses.get(word, ())
                )
                raw = " ".join(self._raw[at : at + count])
                unit = self._units.exact.get(raw) if counted and raw != "in" else None
                if unit is not None:
                    senses = (Sense(SenseKind.UNIT, unit.symbol), *senses)
                return Item(key, at, at + count, senses, follows_verb=verb, raw=raw)
        return None

    def _word(self, at: int, *, counted: bool, mends: bool) -> Item:
        word = self._line[at]
        if word[0] in FIRST or word[0].isnumeric():
            numeral = read_numeral(self._raw[at])
            if numeral is not None:
                return Item(word, at, at + 1, numeral=numeral)
        if fixed := _fixed(word):
            return Item(word, at, at + 1, fixed)
        unit = self._unit(at) if counted else None
        if unit is not None:
            return unit
        if mends:
            close = self._table.misspelt(word)
            if close:
                senses = dict.fromkeys(s for one in close for s in self._table.senses[one])
                orders = tuple([sense for sense in senses if sense.kind in CONTENT])
                return Item(close[0], at, at + 1, orders)
        return Item(word, at, at + 1)

    def _unit(self, at: int) -> Item | None:
        """Return the unit that stands here, of up to three words: ``metres per second``."""
        for count in (3, 1):
            text = " ".join(self._raw[at : at + count])
            unit = self._units.find(text) if len(self._raw) >= at + count else None
            if unit is not None:
                return Item(text, at, at + count, (Sense(SenseKind.UNIT, unit.symbol),))
        return None

    def _gaps(self) -> dict[int, tuple[tuple[Sense, ...], int]]:
        """Return where phrases with other words between their parts stand.

        Their first part has the sense, and each other one none.
        """
        line, found = self._line, dict[int, tuple[tuple[Sense, ...], int]]()
        words = frozenset(line)
        for at, word in enumerate(line):
            if at in found:
                continue
            for phrase in self._table.gapped.get(word, ()):
                places = self._parts(phrase.parts, at) if phrase.parts[-1][0] in words else ()
                if places:
                    found[at] = (phrase.senses, len(phrase.parts[0]))
                    rest = zip(places[1:], phrase.parts[1:], strict=True)
                    found.update({place: (_EQUALS, len(part)) for place, part in rest})
                    break
        return found

    def _parts(self, parts: tuple[tuple[str, ...], ...], at: int) -> list[int]:
        """Return where the parts of a phrase stand, within one clause; empty: they do not."""
        line, places = self._line, list[int]()
        for part in parts:
            last = min(len(line) - len(part), at + (FARTHEST if places else 0))
            while at <= last and line[at : at + len(part)] != part and line[at] != THEN:
                at += 1
            if at > last or line[at : at + len(part)] != part:
                return []
            places.append(at)
            at += len(part)
        return places


def _fixed(word: str) -> tuple[Sense, ...]:
    """Return what a sign or a clock means in every language; nothing for any other word."""
    if word == THEN:
        return _THEN
    if word == "=":
        return _EQUALS
    return _CLOCK if CLOCK.fullmatch(word) else ()


FARTHEST: Final = 8
"""So many words may stand in a gap."""


_COUNTS: Final = frozenset(
    {SenseKind.NUMBER, SenseKind.ONE, SenseKind.COUNTER, SenseKind.HALF_MORE}
)


def _is_counted(item: Item) -> bool:
    if item.numeral is not None:
        return True
    for sense in item.senses:  # noqa: SIM110 - asked of every word in every language
        if sense.kind in _COUNTS:
            return True
    return False


def find_callees(
    line: SpokenLine,
    longest: Mapping[str, int],
    names: Mapping[str, NameTarget],
    seen: Callable[[NameTarget], NameTarget | None],
) -> Places:
    """Return where somebody whom this person may see is named in a line."""
    found: dict[int, tuple[NameTarget, int]] = {}
    at, words = 0, tuple([_owner(word, names) for word in line.words])
    while at < len(words):
        end = at + 1
        for count in range(min(longest.get(words[at], 0), len(words) - at), 0, -1):
            callee = names.get(" ".join(words[at : at + count]))
            visible = None if callee is None else seen(callee)
            if visible is not None:
                found[at] = (visible, at + count)
                end = at + count
                break
        at = end
    return Places(found, owns=words != line.words)


def _owner(word: str, names: Mapping[str, NameTarget]) -> str:
    """Return the name in ``omni's`` and ``omnis``; any other word as it is."""
    if word in names or not word.endswith("s"):
        return word
    bare = word[:-1].rstrip("'")
    return bare if bare in names else word
