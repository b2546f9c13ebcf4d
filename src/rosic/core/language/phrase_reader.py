"""A line as people write it, in any of the languages there is a lexicon of.

Read only where the grammar makes nothing of a line. It acts if every word of it is known in one
language, if they name a robot (or one is chosen), a skill and its values, and if every other
language that knows all of its words reads the same. What is questions is answered; for the rest up
to three lines of the grammar are proposed, which only a tap makes orders of.
"""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said
from rosic.core.language.ast import (
    Answered,
    CommandLine,
    Help,
    Line,
    Misunderstood,
    Proposed,
    Robots,
    Status,
)
from rosic.core.language.lexicon import SenseKind
from rosic.core.language.line_words import MOST_MENDED, SpokenLine, phrase_key, spoken_line
from rosic.core.language.phrase_meaning import (
    DOES,
    ROBOTS_LOOKED_AT,
    MeaningReader,
    Reading,
    answered,
    best_of,
    clauses_of,
    is_in_order,
    is_told,
    only_asks,
    own_words,
    speaks_of,
    without_callee,
)
from rosic.core.language.phrase_places import PLACE, keeping_line, kept_name
from rosic.core.language.phrase_times import UNSURE, without_time
from rosic.core.language.phrase_values import SKILLS_LOOKED_AT, SkillValueReader
from rosic.core.language.phrase_words import NO_WORDS, WordReader, find_callees
from rosic.core.language.proposals import (
    MOST_PROPOSED,
    STEP_OF_TASK,
    first_lines,
    following_lines,
    open_choices,
    said_before,
    vague_lines,
)
from rosic.core.language.robot_kinds import KindReader
from rosic.core.language.sanitise import quote
from rosic.core.language.suggestions import did_you_mean

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from rosic.core.language.ast import Do, LineContext
    from rosic.core.language.compiled import NameTarget
    from rosic.core.language.lexicon import LexiconTable
    from rosic.core.language.phrase_words import Places, RobotWords
    from rosic.core.language.vocabulary import Vocabulary

LONGEST_PHRASE: Final = 240
MOST_PHRASE_WORDS: Final = 14
"""Of a message: what reading costs grows with them. Of 1,622 phrases three have more."""
LANGUAGES_PROPOSED: Final = 2
"""Of so many languages a line is taken for, for what it proposes: those with most of its words."""
MOST_UNKNOWN: Final = 3
"""With more words that nobody knows, a line is not looked at for typing errors; nor a long one."""
NAMES_LOOKED_AT: Final = 128
LINES_TRIED: Final = 16
WORDS_TRIED: Final = 28
"""A long line is tried with fewer robots than a short one: each takes time for each word."""

GO_TO: Final = "goto"
SCHEDULED: Final = "/schedule "
NO_ORDER: Final = said("I read no order in that. Nothing was done.")
MEANT: Final = said("Is that what you mean? Nothing was done yet.")
GOES_ON: Final = said(
    "That goes on from something, and nothing was asked of a robot here before. Nothing was done."
)
WHERE: Final = said(
    "I do not know where that is. Is one of these what you mean? Nothing was done yet."
)
WHICH_ROBOT: Final = said("Which robot is that for? Nothing was done yet.")


class PhraseReader:
    """Reads one line; used once.

    Args:
        text: The line.
        vocabulary: What can be said.
        context: Whom this person may see, and chose.
        chosen: Who is chosen, if anybody visible is.
        seen: What the person may see of a robot or group.
        reads: Reads a line of the grammar.
    """

    def __init__(
        self,
        text: str,
        vocabulary: Vocabulary,
        context: LineContext,
        chosen: NameTarget | None,
        seen: Callable[[NameTarget], NameTarget | None],
        reads: Callable[[str], Line],
    ) -> None:
        self._vocabulary = vocabulary
        self._context = context
        self._chosen = chosen
        self._seen = seen
        self._reads = reads
        self._names = self._whole = False
        self._kinds = KindReader(vocabulary, context.visible, seen)
        self._meanings = MeaningReader(vocabulary)
        self._line: SpokenLine = spoken_line(text)
        self._named: Places = find_callees(
            self._line, vocabulary.longest_spoken, vocabulary.spoken_names, seen
        )

    def read(self) -> Line | None:
        """Return what the line means; None where nothing can be made of it."""
        if not self._line.words or len(self._line.words) > MOST_PHRASE_WORDS:
            return None
        subject, readings = self._read_all()
        if not readings:
            return None
        full = [reading for reading in readings if not reading.unknown]
        best = best_of(readings)
        said_else = self._line.quotes or self._line.answers
        blocked = said_else or any(r.is_blocked for r in full or best)
        asks = self._line.asks and not any(r.has(SenseKind.REQUEST) for r in best)
        self._names = subject is not None
        denied = not self._vocabulary.phrases.denials.isdisjoint(self._line.words)
        sure = not (blocked or asks or denied or self._named.owns)
        if full and sure and self._is_begun_well(full):
            acts = self._act(full, subject)
            if acts:
                return self._reads(acts)
        return self._otherwise(best, subject, blocked=blocked)

    @property
    def named(self) -> bool:
        """Whether the line itself says whom it is for."""
        return self._names

    def following(self, last: Do) -> tuple[str, ...]:
        """Return the lines that this one may mean after another order, best first.

        Args:
            last: That order; its robot is the one that is meant.
        """
        compiled = self._vocabulary.compiled_skill(last.robots[0], last.skills[0].id)
        callee = self._vocabulary.spoken_names.get(phrase_key(last.name))
        if compiled is None or callee is None:
            return ()
        lines: dict[str, None] = {}
        units = self._vocabulary.units
        given = said_before(compiled, last, units)
        for reading in best_of(self._readings(callee, self._vocabulary.phrases.tables)):
            items = without_callee(reading.items, callee)
            positional = reading.table.positional
            if name := kept_name(items):
                return (keeping_line(callee, name),)
            values = SkillValueReader(items, compiled, units, positional=positional).read()
            vague = {value for item in items for value in item.values(SenseKind.VAGUE)}
            lines.update(dict.fromkeys(following_lines(callee, compiled, given, values, vague)))
        return self._readable(lines)

    # ---- who ----

    def _subject(self) -> NameTarget | None:
        """Return who is spoken to: the first that is named, or who is chosen."""
        callees = self._named.callees
        return callees[0] if callees else None

    def _read_all(self) -> tuple[NameTarget | None, list[Reading]]:
        """Return who is spoken to, and the line as each language reads it."""
        tables = self._vocabulary.phrases.tables
        subject = self._subject()
        readings = self._readings(subject, tables)
        if subject is None:
            named = (item.callee for reading in best_of(readings) for item in reading.items)
            subject = next((callee for callee in named if callee is not None), None)
            if subject is not None:
                readings = self._readings(subject, tables)
        return subject, readings

    def _words(self, callee: NameTarget | None) -> RobotWords:
        if callee is None:
            return NO_WORDS
        return self._vocabulary.words.get(callee.robots[0].id, NO_WORDS)

    def _readings(
        self, callee: NameTarget | None, tables: Sequence[LexiconTable], *, mends: bool = False
    ) -> list[Reading]:
        """Return the line as those languages read it in which the fewest words mean nothing."""
        words = self._words(callee or self._chosen)
        fewest = len(self._line.words)
        found: list[Reading] = []
        for table in tables:
            reader = WordReader(self._line, table, words, self._named, self._vocabulary.units)
            read = reader.items(fewest, mends=mends)
            if read is not None:
                found.append(Reading(table, *read))
                fewest = read[1]
        return [r._replace(items=self._kinds.named(r.items)) for r in best_of(found)]

    # ---- what acts ----

    def _act(self, full: Sequence[Reading], callee: NameTarget | None) -> str:
        """Return the order that all languages agree on which know every word of the line.

        Empty: they do not, or something is left out, or nobody is named and nobody chosen.
        """
        callee = callee or self._chosen
        if callee is None or not self._is_one_callee(callee):
            return ""
        lines = []
        for reading in full:
            meaning = self._meanings.read(reading, callee)
            if meaning is None or not meaning.whole or not is_in_order(reading.items, callee):
                return ""
            if self._line.asks and not meaning.values.numbers:
                return ""  # can you grab?
            vague = not meaning.goes and reading.has(SenseKind.VAGUE)
            if vague and meaning.values.missing(meaning.skill):
                return ""  # go back: after an order, what undoes it
            lines.append(meaning.line)
        agreed = len(set(lines)) == 1
        return lines[0] if agreed and not isinstance(self._reads(lines[0]), Misunderstood) else ""

    def _is_begun_well(self, full: Sequence[Reading]) -> bool:
        """Whether the line does not begin with a word by itself that could be of the order.

        Nor with an article before what is to be done, for then it speaks of that: ``the launch``.
        """
        if any(speaks_of(reading.items) or is_told(reading.items) for reading in full):
            return False
        first = [reading.items[0] for reading in full if reading.items]
        return not self._line.opens or not any(
            item.means(kind) for item in first for kind in DOES if item.callee is None
        )

    def _is_one_callee(self, callee: NameTarget) -> bool:
        """Whether nobody else is named, but as a value."""
        return all(other.name == callee.name or not other.group for other in self._named.callees)

    # ---- what does not ----

    def _otherwise(
        self,
        best: Sequence[Reading],
        callee: NameTarget | None,
        *,
        blocked: bool,
    ) -> Line | None:
        asked = self._question([r for r in best if only_asks(r)], callee)
        manner = self._manner(best) if asked is None else None
        if manner is not None:
            return manner
        asked = asked or self._question(best, callee)
        if asked is not None:
            return asked
        instead = any("instead" in item.values(SenseKind.VAGUE) for r in best for item in r.items)
        manner = self._at_least_manner(best)
        if manner is not None:
            return manner
        if blocked and not instead:
            return Misunderstood(NO_ORDER, ("help",))
        kept = self._kept(best, callee) or (self._renamed(best) if callee is None else None)
        return kept or self._proposed(best, callee)

    def _may_be_misspelt(self, best: Sequence[Reading]) -> bool:
        return 0 < best[0].unknown <= MOST_UNKNOWN and len(self._line.words) <= MOST_MENDED

    def _kept(self, best: Sequence[Reading], callee: NameTarget | None) -> Line | None:
        """Return what keeps the place where a robot is: this is the dock."""
        callee = callee or self._chosen
        if PLACE not in self._vocabulary.commands.words or (callee is not None and callee.group):
            return None
        items = [r.items if callee is None else without_callee(r.items, callee) for r in best]
        name = next(filter(None, map(kept_name, items)), "")
        if not name:
            return None
        if callee is not None:
            return Proposed(MEANT, (keeping_line(callee, name),))
        able = islice(self._having(GO_TO), MOST_PROPOSED)  # whoever was asked last is offered first
        offers = tuple([keeping_line(robot, name) for robot in able])
        return Proposed(WHICH_ROBOT, offers, follows=(PLACE,)) if offers else None

    def _renamed(self, best: Sequence[Reading]) -> Line | None:
        """Return what the line would be if a word that means nothing were a misspelt name."""
        if self._named.named or not self._may_be_misspelt(best):
            return None
        names = [
            name
            for robot in islice(self._context.visible, NAMES_LOOKED_AT)
            if robot in self._vocabulary.robots
            for name in self._vocabulary.robots[robot].names
        ]
        for item in islice((item for item in best[0].items if not item.is_known), 2):
            for name in did_you_mean(item.text, names)[:1]:
                words = (*self._line.words[: item.at], name, *self._line.words[item.end :])
                line = PhraseReader(
                    " ".join(words),
                    self._vocabulary,
                    self._context,
                    self._chosen,
                    self._seen,
                    self._reads,
                ).meant()
                if line:
                    return Proposed(MEANT, line, doubtful=True)
        return None

    def meant(self) -> tuple[str, ...]:
        """Return the lines of the grammar that this one may be; none where it is no order."""
        subject, readings = self._read_all()
        best = best_of(readings)
        if self._line.quotes or self._line.answers or any(r.is_blocked for r in best):
            return ()
        acts = "" if best[0].unknown else self._act(best, subject)
        proposed = None if acts else self._proposed(best, subject)
        return (acts,) if acts else proposed.offers if isinstance(proposed, Proposed) else ()

    def _manner(self, best: Sequence[Reading]) -> Line | None:
        """Return the answer to what is said out of politeness alone."""
        for reading in best:
            manners = [v for item in reading.items for v in item.values(SenseKind.MANNER)]
            alone = all(
                item.means(SenseKind.MANNER)
                or item.means(SenseKind.NOTHING)
                or item.callee is not None
                for item in reading.items
            )
            if manners and alone and not reading.unknown:
                return answered(manners[0])
        return None

    def _at_least_manner(self, best: Sequence[Reading]) -> Line | None:
        """Return the answer to a greeting with words beside it that nobody knows."""
        for reading in best:
            manners = [v for item in reading.items for v in item.values(SenseKind.MANNER)]
            speaks = any(item.means(kind) for item in reading.items for kind in DOES)
            if manners and not speaks and not self._named.named:
                return answered(manners[0])
        return None

    def _question(self, best: Sequence[Reading], callee: NameTarget | None) -> Line | None:
        """Return the answer to a question: of the longest phrase that asks one."""
        found: list[tuple[int, str]] = []
        for reading in best:
            for item in reading.items:
                found += [
                    (len(item.text.split()), asked) for asked in item.values(SenseKind.QUESTION)
                ]
        if not found:
            return None
        asked = max(found, key=lambda one: one[0])[1]
        if asked == "picture" and any(other == "map" for _, other in found):
            asked = "map"
        return self._answer(asked, callee or self._chosen)

    def _answer(self, asked: str, callee: NameTarget | None) -> Line | None:
        name = callee.name if callee is not None else ""
        if asked == "status":
            return Status(tuple([robot.id for robot in callee.robots]) if callee else ())
        if asked in {"help", "skills"}:
            return Help(name if asked == "skills" else "")
        if asked == "robots":
            return Robots()
        if asked == "rules":
            return Misunderstood(NO_ORDER, ("help",))
        if asked in self._vocabulary.commands.words:
            return CommandLine(asked, name)
        return Answered(asked)

    # ---- proposals ----

    def _proposed(self, best: Sequence[Reading], callee: NameTarget | None) -> Line | None:
        """Return up to three lines that may be meant."""
        likely = sorted(best, key=own_words)[:LANGUAGES_PROPOSED]
        tables = [reading.table for reading in likely]
        mends = self._may_be_misspelt(best)
        mended = self._readings(callee, tables, mends=True) if mends else likely
        callee = callee or self._chosen
        meant = best_of(mended)
        said_vaguely = (v for r in meant for item in r.items for v in item.values(SenseKind.VAGUE))
        vague = dict.fromkeys(said_vaguely)
        read, nowhere = self._offers(meant, callee), False
        if not read and callee is not None and vague:
            read = self._readable(first_lines(callee, vague))
            nowhere = set(vague) == {"place"}
        if not read:
            return Proposed(GOES_ON, ("help",), follows=tuple(vague)) if vague else None
        sentence = WHICH_ROBOT if callee is None else WHERE if nowhere else MEANT
        unknown = next((item for item in best[0].items if not item.is_known), None)
        if unknown is not None:
            sentence = said(
                "I do not know {word}. Is one of these what you mean? Nothing was done yet.",
                word=quote(unknown.text),
            )
        sure = self._whole or bool(vague.keys() - {"place"})
        doubtful = bool(best[0].unknown) or not sure
        return Proposed(sentence, read, follows=tuple(vague), doubtful=doubtful)

    def _readable(self, lines: Iterable[str]) -> tuple[str, ...]:
        """Return the first few lines that the grammar reads."""
        read: dict[str, None] = {}
        for line in islice(lines, LINES_TRIED):
            if line not in read and not isinstance(self._reads(line), Misunderstood):
                read[line] = None
                if len(read) == MOST_PROPOSED:
                    break
        return tuple(read)

    def _offers(self, meant: Sequence[Reading], callee: NameTarget | None) -> tuple[str, ...]:
        """Return the first few lines that may be meant; if a time is said, none without it."""
        timed = [(without_time(reading.items), reading) for reading in meant]
        read = [(when, reading._replace(items=items)) for (when, items), reading in timed]
        then = [one for one in read if one[0] and one[0] != UNSURE]
        planned = tuple(islice(self._lines(then, callee), LINES_TRIED))
        return self._readable(planned or self._lines([o for o in read if not o[0]], callee))

    def _lines(
        self, readings: Sequence[tuple[str, Reading]], callee: NameTarget | None
    ) -> Iterator[str]:
        """Yield what readings may ask of somebody, clause by clause, each at its time."""
        room = WORDS_TRIED
        for when, reading in readings:
            for target in (callee,) if callee is not None else self._some_candidates(reading):
                if room <= 0:
                    return
                room -= len(reading.items)
                for line in self._untimed(reading, target):
                    self._whole |= bool(when)  # a plan is shown whole before it stands
                    yield f"{SCHEDULED}{when} {line.removeprefix('/task ')}" if when else line

    def _untimed(self, reading: Reading, callee: NameTarget) -> Iterator[str]:
        """Yield the lines that a reading may be, whenever they are to be done."""
        meanings = []
        for clause in clauses_of(reading.items):
            meaning = self._meanings.read(reading._replace(items=clause), callee)
            if meaning is not None:
                meanings.append(meaning)
        self._whole = self._whole or (bool(meanings) and all(m.whole for m in meanings))
        once = list({meaning.line: meaning for meaning in meanings}.values())
        meanings = once if len(once) == 1 else meanings  # come down and land
        if len(meanings) > 1 and all(m.whole for m in meanings):
            steps = [meaning.line.split(" ", 1)[1] for meaning in meanings]
            yield f"/task {callee.name} {STEP_OF_TASK.join(steps)}"
        for meaning in meanings:
            if not meaning.goes and (meaning.evidence.surely or meaning.values.given):
                shown = open_choices(meaning.skill, meaning.values) if reading.unknown else ()
                for values in shown or (meaning.values,):
                    yield from vague_lines(callee.name, meaning.skill, values, reading.items)
            else:
                yield meaning.line

    def _some_candidates(self, reading: Reading) -> tuple[NameTarget, ...]:
        """Return the first few that may be meant, each once however often a word is said."""
        found: dict[str, NameTarget] = {}
        for target in self._candidates(reading):
            found.setdefault(target.name, target)
            if len(found) == ROBOTS_LOOKED_AT:
                break
        return tuple(found.values())

    def _candidates(self, reading: Reading) -> Iterator[NameTarget]:
        """Yield who may be meant where nobody is named: those that have the skill."""
        for item in reading.items:
            together = map(self._kinds.all_of, item.values(SenseKind.KIND))
            yield from (group for group in together if group is not None)
        for item in reading.items:
            for name in (*item.values(SenseKind.SKILL), *item.values(SenseKind.VERB)):
                yield from self._having(name)
        yield from self._choosing(reading)

    def _choosing(self, reading: Reading) -> Iterator[NameTarget]:
        """Yield some of the visible robots of whose skills a choice is said."""
        spoken = {word for item in reading.items for word in item.values(SenseKind.CHOICE)}
        for robot in sorted(islice(self._context.visible, SKILLS_LOOKED_AT)) if spoken else ():
            words = self._vocabulary.words.get(robot, NO_WORDS)
            if not spoken.isdisjoint(words.chosen):
                yield self._vocabulary.callees[robot]

    def _having(self, name: str) -> Iterator[NameTarget]:
        """Yield some of the visible robots that have a skill."""
        vocabulary = self._vocabulary
        having = vocabulary.having.get(name, frozenset()) & self._context.visible
        for robot in sorted(islice(having, ROBOTS_LOOKED_AT)):
            yield vocabulary.callees[robot]
