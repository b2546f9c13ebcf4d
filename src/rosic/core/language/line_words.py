"""The words of a line, as they are compared: what they mean is another question."""

from __future__ import annotations

import re
import unicodedata
from typing import Final, NamedTuple

from rosic.core.language.keywords import EXCEPTING, FILLERS
from rosic.core.language.sanitise import clean, fold_word, normalised

FOLDED_AT_MOST: Final = 1024

MOST_MENDED: Final = 8
"""A line of more words is not looked at for typing errors: what is asked in one is shorter."""

NEGATING: Final = frozenset({"minus", "nicht", "not"})
"""Of what leaves robots out, the words that also say something else in many a sentence."""

_ENDS: Final = ".,;:!?"


class LineWords(NamedTuple):
    """The words of a line.

    Attributes:
        raw: As typed.
        low: In small letters.
        slash: The line began with a slash, which is no part of the first word here.
    """

    raw: list[str]
    low: list[str]
    slash: bool


def words_of(line: str) -> LineWords:
    """Return the words of a line that is `clean`, has some, and begins and ends with one."""
    words = line
    if "=" in words:
        words = words.replace("=", " = ")
    raw = words.split()
    if line[-1] in _ENDS or ", " in line or ": " in line or "; " in line:
        raw = [word.rstrip(_ENDS) or word for word in raw]
    if not line.isascii():
        raw = _folded(raw)
    low = [word.casefold() for word in raw]
    slash = low[0][0] == "/"
    if slash:
        raw[0] = raw[0].partition("@")[0].lstrip("/") or "/"
        low[0] = low[0].partition("@")[0].lstrip("/") or "/"
    return LineWords(raw, low, slash)


def past_fillers(low: list[str], at: int) -> int:
    """Return where the next word stands that carries a meaning; the end, if none does."""
    while at < len(low) and low[at] in FILLERS:
        at += 1
    return at


def past_excepting(low: list[str], at: int) -> int:
    """Return where what leaves robots out ends that begins here; 0: nothing does."""
    for end in (at + 2, at + 1):
        if end <= len(low) and tuple(low[at:end]) in EXCEPTING:
            return end
    return 0


def leaves_out(text: str) -> bool:
    """Whether a text, which stops or ends everything, was perhaps to leave somebody out."""
    if len(text) > FOLDED_AT_MOST:
        return False
    low = clean(" ".join(text.split())).casefold().split()
    return any(past_excepting(low, at) and low[at] not in NEGATING for at in range(1, len(low)))


def _folded(raw: list[str]) -> list[str]:
    """Fold words as far as anything but free text can go: names, numbers and units stand there."""
    room, folded = FOLDED_AT_MOST, []
    for word in raw:
        room -= len(word)
        if room < 0:
            break
        folded.append(fold_word(word))
    return folded + raw[len(folded) :]


# ---- the words of a line, as a lexicon has them ----

THEN: Final = ";"
"""What a full stop or a semicolon between two clauses becomes."""

_LOOSE: Final = '¿¡"\u201c\u201d\u201e\u201a\u2018\u2019«»「」『』…'
_TRAILING: Final = ",.;:!?،。、"
# Pictures that only say how somebody feels, and what joins and colours them. Any other may say
# something of the line: an arrow, a cross, a thinking face.
_PICTURE: Final = re.compile(
    "[\u2600\u2615\u263a\u2728\u2764\ufe0f\u200d\U0001f308\U0001f31e\U0001f44b\U0001f44d\U0001f493-\U0001f49f"
    "\U0001f389\U0001f3fb-\U0001f3ff\U0001f600-\U0001f60e\U0001f642\U0001f44f\U0001f4aa\U0001f64f\U0001f916\U0001f970]"
)
_QUESTIONS: Final = frozenset("?\uff1f\u061f")
_QUOTES: Final = frozenset('"“”„«»「」『』')
# A script without blanks between its words: each of its signs is a word.
_HAN: Final = "\u2e80-\u2fdf\u3005\u3007\u3040-\u30ff\u3400-\u9fff\uf900-\ufaff"
_WORDS: Final = re.compile(rf"[{_HAN}]|[=;]|[^\s=;{_HAN}]+")
_ELIDED: Final = re.compile(r"(?<![\w'])(jusqu|qu|[cdjlmnst])'(?=\w)", re.IGNORECASE)
_ELISION: Final = re.compile(r"(jusqu|qu|[cdjlmnst])'", re.IGNORECASE)
_OPENING: Final = re.compile(r"\s*[^\W\d_]+\s*[,!.]\s")
# ``x=3,y=0`` and ``x0 y2``, as people type them.
_COMMA: Final = re.compile(r"(?<=\d),(?=[^\W\d_])")
_AXIS: Final = re.compile(r"(?<![^\W_])([xyz])(?=-?\d)", re.IGNORECASE)
_HYPHEN: Final = re.compile(r"(?<=[^\W\d_])-(?=[^\W\d_])")
_APOSTROPHES: Final = str.maketrans(
    {"\u2019": "'", "\u2018": "'", "`": "'", "\u00b4": "'", "\u2212": "-"}
)


class SpokenLine(NamedTuple):
    """The words of a line, as a lexicon has them.

    Attributes:
        words: In small letters, without what parts sentences; each sign of a script that has no
            blanks is one.
        raw: The same as typed: of a unit the case may matter.
        asks: It ends with a question mark.
        answers: Words follow a question in it: ``1 m? no``.
        quotes: It repeats what somebody said, or holds a sign that numbers do not have in words.
        opens: Its first word stands by itself before a comma: ``right, move 1 m``.
        breaks: Places of the words that a comma stands before: ``right, now``.
    """

    words: tuple[str, ...]
    raw: tuple[str, ...]
    asks: bool
    answers: bool
    quotes: bool
    opens: bool
    breaks: frozenset[int] = frozenset()


def spoken_line(text: str) -> SpokenLine:
    """Return the words of a line. Takes time linear in it."""
    asked = max(map(text.rfind, _QUESTIONS))
    answers = any(letter.isalnum() for letter in text[asked + 1 :]) if asked >= 0 else False
    quotes = not _QUOTES.isdisjoint(text) or any(
        sign.isnumeric()
        and not sign.isdecimal()
        and unicodedata.category(sign) == "No"
        and unicodedata.numeric(sign) >= 1
        for sign in text
    )
    text = normalised(text).translate(_APOSTROPHES).replace("_", " ")
    text = _AXIS.sub(r"\1 ", _COMMA.sub(" ", _ELIDED.sub(r"\1' ", text)))
    text = _HYPHEN.sub(" ", text)
    if not text.isascii():
        text = _PICTURE.sub(" ", text)
    words: list[str] = []
    breaks: set[int] = set()
    for word in _WORDS.findall(text):
        whole = word == THEN or _ELISION.fullmatch(word)
        bare = word if whole else word.lstrip(_LOOSE).rstrip(_LOOSE + _TRAILING)
        if bare:
            words.append(bare)
        if word[-1] == ",":
            breaks.add(len(words))
        if word[-1] in ".。" and words and words[-1] != THEN:
            words.append(THEN)
    while words and words[-1] == THEN:
        words.pop()
    low = tuple([word.casefold() for word in words])
    opens = bool(_OPENING.match(text))
    asks = asked >= 0
    return SpokenLine(low, tuple(words), asks, answers, quotes, opens, frozenset(breaks))


def phrase_key(text: str) -> str:
    """Return a phrase as it is looked up: its words, with single blanks."""
    return " ".join(spoken_line(text).words)


def without_accents(text: str) -> str:
    """Return a phrase as people type it who leave accents out."""
    if text.isascii():
        return text
    parts = unicodedata.normalize("NFD", text)
    return unicodedata.normalize("NFC", "".join([c for c in parts if not unicodedata.combining(c)]))
