"""What does a message ask? One line, one meaning; look-ups only, each word looked at once.

    line    = [name] verb [names] | [name] skill values | skill [name] values | name
    values  = { [parameter ["="]] number [unit] | [parameter ["="]] word }

A leading slash changes nothing. Total: any ``str`` gives lines, and nothing is raised.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.i18n import said
from rosic.core.language.ast import (
    Cancel,
    CommandLine,
    Do,
    Halt,
    Line,
    LineContext,
    Misunderstood,
    Proposed,
)
from rosic.core.language.cancel_detection import hears_cancel
from rosic.core.language.kept_places import with_places
from rosic.core.language.keywords import FILLERS
from rosic.core.language.lexicon import NO_PHRASES, SenseKind
from rosic.core.language.line_parser import LineReader
from rosic.core.language.line_words import phrase_key, spoken_line, words_of
from rosic.core.language.phrase_reader import (
    LONGEST_PHRASE,
    MEANT,
    MOST_PHRASE_WORDS,
    NO_ORDER,
    WHICH_ROBOT,
    PhraseReader,
)
from rosic.core.language.sanitise import REORDERING, clean, is_plain
from rosic.core.language.stop_detection import hears_stop

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.language.vocabulary import Vocabulary, VocabularyHolder
    from rosic.core.robot.profile import RobotId


# ---- what a message asks ----

LONGEST_TEXT = 4096
MOST_LINES = 20
MOST_PHRASES = 2
"""A message of so many lines, with `MOST_PHRASE_WORDS` in all, is read as people write it and
looked at for typing errors; the lines of a longer one are of the grammar."""


def understand(
    text: str, vocabulary: Vocabulary, context: LineContext, *, mends: bool = True
) -> tuple[Line, ...]:
    """Return what each line of a message means, in order; at least one.

    Takes time linear in the text, whatever the number of robots, skills and people: only for what
    is not understood, and for what is asked of several robots, more is looked at.

    Args:
        text: As received; any ``str``. A stop was looked for before, by `hears_stop`.
        vocabulary: What can be said.
        context: Whom this person may see, and chose.
        mends: Whether to look for what may have been meant. Not in a line that is only tried.
    """
    if len(text) > LONGEST_TEXT:
        return (Misunderstood(_too_long(len(text))),)
    if is_plain(text):
        return (_line(text.strip(), vocabulary, context, mends=mends),)
    lines = _with_words(text)
    if len(lines) > MOST_LINES:
        return (
            Misunderstood(
                said(
                    "That message has {lines} lines; I read at most {most}. Nothing was done.",
                    lines=len(lines),
                    most=MOST_LINES,
                )
            ),
        )
    strictly = len(lines) > 1 and _are_many(lines)
    strict = replace(vocabulary, phrases=NO_PHRASES) if strictly else vocabulary
    read = [_cleaned(line, strict, context, mends=mends and not strictly) for line in lines]
    return tuple(read) or (_EMPTY,)


def _are_many(lines: Sequence[str]) -> bool:
    """Whether a message has more lines, or words, than are read as people write them."""
    words = (len(spoken_line(line[:LONGEST_PHRASE]).words) for line in lines[:MOST_PHRASES])
    return len(lines) > MOST_PHRASES or sum(words) > MOST_PHRASE_WORDS


def places(text: str, written: str) -> tuple[int, ...]:
    """Return which lines of what was written the lines of a text are, without empty ones.

    Args:
        text: As it is understood: of some lines the beginning was taken out, or all.
        written: The same before that.
    """
    found: list[int] = []
    before = 0
    for left, line in zip(text.split("\n"), written.split("\n"), strict=True):
        whole = len(_with_words(line))
        found += range(before + whole - len(_with_words(left)), before + whole)
        before += whole
    return tuple(found)


def _with_words(text: str) -> list[str]:
    return [line for line in text.splitlines() if _has_words(line)]


def _has_words(line: str) -> bool:
    return any(clean(line[at : at + 64]).strip() for at in range(0, len(line), 64))


_EMPTY = Misunderstood(said("There was nothing to read. Say help for what can be said."), ("help",))
WHOAMI, SCHEDULE, AGAIN = "me", "schedule", "again"
"""Commands whose names begin many a sentence: ``ich hätte gern``, ``um pouco``."""

_REORDERED = Misunderstood(
    said(
        "That line has invisible marks that show its words in another order. Please "
        "type it anew. Nothing was done."
    )
)


def _too_long(length: int) -> str:
    return said(
        "That message has {length:,} characters; I read at most {most:,}. Nothing was done.",
        length=length,
        most=LONGEST_TEXT,
    )


def _cleaned(line: str, vocabulary: Vocabulary, context: LineContext, *, mends: bool) -> Line:
    if not REORDERING.isdisjoint(line):
        return _REORDERED
    return _line(clean(line).strip(), vocabulary, context, mends=mends)


def _line(line: str, vocabulary: Vocabulary, context: LineContext, *, mends: bool) -> Line:
    if not line:
        return _EMPTY
    raw, low, slash = words_of(line)
    if slash and low[0] in FILLERS and low[0] in vocabulary.commands.aliases:
        return CommandLine(vocabulary.commands.aliases[low[0]], line.partition(" ")[2].strip())
    phrases = mends and not (slash or context.overheard) and bool(vocabulary.phrases.tables)
    reader = LineReader(line, (raw, low), vocabulary, context, mends=mends and not phrases)
    read = reader.read(slash=slash)
    if vocabulary.places and isinstance(read, Do):
        before, read = read, with_places(read, vocabulary.places)
        phrases = phrases and (read is before or reader.unsure)
    kind = type(read)
    asked = kind is Do and line[-1] in "?\uff1f"
    sure = kind is not Misunderstood and kind is not CommandLine and not (reader.unsure or asked)
    if sure or not phrases:
        return read
    found = _loosely(line, read, reader, vocabulary, context)
    if asked and found is read:  # an order is no question
        return Proposed(MEANT, (line.rstrip(" ?\uff1f"),))
    return found


def _loosely(
    line: str, read: Line, reader: LineReader, vocabulary: Vocabulary, context: LineContext
) -> Line:
    """Return what a line means that the grammar does not read to its end."""
    found = _phrase(line, read, reader, vocabulary, context)
    if found is not None and not (isinstance(found, Proposed) and _is_asked_better(found, read)):
        return found
    if isinstance(read, Misunderstood):
        raw, low, slash = words_of(line)
        read = LineReader(line, (raw, low), vocabulary, context, mends=True).read(slash=slash)
    helps = isinstance(read, Misunderstood) and all(o.startswith("help") for o in read.offers)
    return found if found is not None and helps else read


def _is_asked_better(found: Proposed, read: Line) -> bool:
    """Whether the grammar may say more about a line than what is proposed: the word, the robots."""
    return found.doubtful or (isinstance(read, Misunderstood) and found.sentence == WHICH_ROBOT)


def _phrase(
    line: str, read: Line, reader: LineReader, vocabulary: Vocabulary, context: LineContext
) -> Line | None:
    """Return what a line means as people write it; None: nothing but what the grammar made."""
    about_stop = isinstance(read, Misunderstood) and read.about_stop
    if about_stop or len(line) > LONGEST_PHRASE:
        return None
    if type(read) is CommandLine and not (_begins_sentence(read) or _is_phrase(line, vocabulary)):
        return read
    phrases = _phrase_reader(line, reader, vocabulary, context)
    found = phrases.read()
    if found is None and type(read) is CommandLine and read.verb == WHOAMI:
        return Misunderstood(NO_ORDER, ("help",))  # ich hätt gern ...
    return replace(found, text=line, named=phrases.named) if isinstance(found, Do) else found


def _phrase_reader(
    line: str, reader: LineReader, vocabulary: Vocabulary, context: LineContext
) -> PhraseReader:
    strictly = partial(_strictly, vocabulary=vocabulary, context=context)
    return PhraseReader(line, vocabulary, context, reader.chosen(), reader.seen, strictly)


def _begins_sentence(read: CommandLine) -> bool:
    """Whether a command may be the beginning of a sentence: nothing that it takes follows it."""
    if read.verb == AGAIN:
        return any(letter.isnumeric() for letter in read.rest)
    if read.verb == SCHEDULE:
        return not any(letter.isnumeric() for letter in read.rest)
    return read.verb == WHOAMI and bool(read.rest)


def _is_phrase(line: str, vocabulary: Vocabulary) -> bool:
    """Whether all of a line is what people say in one of the languages, of several words."""
    key = phrase_key(line)
    return " " in key and any(
        sense.kind is SenseKind.QUESTION or sense.kind is SenseKind.MANNER
        for table in vocabulary.phrases.tables
        for sense in table.senses.get(key, ())
    )


def _strictly(line: str, *, vocabulary: Vocabulary, context: LineContext) -> Line:
    """Return what the grammar alone makes of a line."""
    raw, low, slash = words_of(line)
    read = LineReader(line, (raw, low), vocabulary, context, mends=False).read(slash=slash)
    return with_places(read, vocabulary.places) if isinstance(read, Do) else read


# ---- reading with a memory ----

REMEMBERED = 8_192
LONGEST_REMEMBERED = 200


class LanguageReader:
    """`hears_stop`, `hears_cancel` and `understand` over the newest vocabulary."""

    __slots__ = ("_lines", "_urgent", "_vocabularies")

    def __init__(self, vocabularies: VocabularyHolder) -> None:
        self._vocabularies = vocabularies
        vocabularies.replaced.connect(self._forget)
        self._urgent: dict[str, Halt | Cancel | None] = {}
        self._lines: dict[tuple[str, str, frozenset[RobotId], bool], tuple[Line, ...]] = {}

    def urgent(self, text: str) -> Halt | Cancel | None:
        """Return what a text stops or ends before anything else is read; None for nothing."""
        known = self._urgent
        if text in known:
            return known[text]
        heard = self._heard(text)
        if len(text) <= LONGEST_REMEMBERED:
            if len(known) >= REMEMBERED:
                known.clear()
            known[text] = heard
        return heard

    def _heard(self, text: str) -> Halt | Cancel | None:
        known = self._vocabularies.current.known
        names = hears_stop(text, known)
        if names is not None:
            return Halt(names)
        names = hears_cancel(text, known)
        return None if names is None else Cancel(names)

    @property
    def vocabulary(self) -> Vocabulary:
        """What is read with."""
        return self._vocabularies.current

    def _forget(self) -> None:
        """Read everything anew from now on: the vocabulary has changed."""
        self._urgent.clear()
        self._lines.clear()

    def lines(
        self,
        text: str,
        selected: str,
        visible: frozenset[RobotId],
        overheard: bool = False,
    ) -> tuple[Line, ...]:
        """Return what `understand` does for somebody who sees and chose this."""
        key = (text, selected, visible, overheard)
        read = self._lines.get(key)
        if read is None:
            context = LineContext(selected, visible, overheard)
            read = understand(text, self._vocabularies.current, context)
            if len(text) <= LONGEST_REMEMBERED:
                if len(self._lines) >= REMEMBERED:
                    self._lines.clear()
                self._lines[key] = read
        return read

    def following(self, text: str, last: Do, visible: frozenset[RobotId]) -> tuple[str, ...]:
        """Return the lines that a vague one may mean after the order that was given before it.

        Args:
            text: One line: ``again``, ``no, left``, ``the same but 1 m``.
            last: The order.
            visible: The robots that this person may see.
        """
        vocabulary, context = self._vocabularies.current, LineContext(last.name, visible)
        reader = LineReader(text, ([], []), vocabulary, context, mends=False)
        return _phrase_reader(text, reader, vocabulary, context).following(last)
