"""Text from outside, made harmless: for showing (`clean`), for naming, and for reading.

Everything here is total and linear: any ``str`` in, control characters, marks that reorder text
and lone surrogates included.
"""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

LONGEST_NAME = 64
LONGEST_QUOTE = 32
# Of a longer name no more is looked at: most of it is cut off in the end.
NAME_LOOKED_AT = 4 * LONGEST_NAME
LONGEST_KEPT, WORDS_KEPT = 32, 4_096
"""Words up to so long, and so many of them, are folded once: each is looked up for many things."""

# Explicit embeddings, overrides and isolates: with them a person can be shown another order of
# words than the one that is read here.
REORDERING = frozenset("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")

_COMMAND = re.compile(r"(?<![\w/])/(?=\w)|(?<=t\.me)/", re.IGNORECASE)

# What stands for a sign that people also type in ASCII.
_SIGNS = str.maketrans(
    {"\u2212": "-", "\u2013": "-", "\u2215": "/", "\u2044": "/", "\u066b": ".", "º": "°", "˚": "°"}
)

# NFKC writes each of these two as a whole sentence: 18 characters and 8. No other sign becomes more
# than six, so what is sent at its longest stays a few thousand characters.
_SENTENCES = str.maketrans({"\ufdfa": "\ufffd", "\ufdfb": "\ufffd"})


# To put marks in canonical order takes time with the square of how many stand on one letter. No
# language needs more than 30 (UAX 15, Stream-Safe Text). What is beyond is left out: that format
# would go on behind a joiner. To `re` no mark is a letter, but for the two of half-width katakana.
MOST_MARKS = 30
_MAY_BE_MARKS = re.compile(rf"(?:[^\w\s\x00-\x7f]|[\uff9e\uff9f]){{{MOST_MARKS + 1},}}")


def normalised(text: str) -> str:
    """Return the text in NFKC, at most six times as long: a sign for a sentence is one sign.

    Of the marks on one letter the first 30 are kept.
    """
    if text.isascii():
        return text
    return unicodedata.normalize("NFKC", _bounded_marks(text.translate(_SENTENCES)))


def _bounded_marks(text: str) -> str:
    """Return the text without what stands behind the first 30 marks of a letter."""
    return _MAY_BE_MARKS.sub(lambda found: _first_marks(found[0]), text)


def _first_marks(run: str) -> str:
    kept: list[str] = []
    marks = 0
    for character in run:
        marks = marks + 1 if _is_mark(character) else 0
        if marks <= MOST_MARKS:
            kept.append(character)
    return "".join(kept)


@lru_cache(maxsize=4_096)
def _is_mark(character: str) -> bool:
    """Whether a character is, or is decomposed into, what canonical order moves."""
    return unicodedata.combining(unicodedata.normalize("NFKD", character)[0]) != 0


# Letters of other scripts, and digits, that are drawn like a Latin letter.
_DRAWN_LIKE = str.maketrans(
    "АВЕЗІЈКМНОРСТУХЅԌԚԜавекмнорстухіјѕһԁԛԝӏѵΑΒΕΖΗΙΚΜΝΟΡΤΥΧαικνορτυχIl1|0",  # noqa: RUF001
    "ABE3lJKMHOPCTYXSGQWabekmhopctyxijshdqwlvABEZHlKMNOPTYXaikvoptuxllllo",
)
_NO_LETTERS = re.compile(r"[\W_]+")


def is_plain(text: str) -> bool:
    """Whether the text is one line of printable ASCII, which needs no cleaning at all."""
    return text.isascii() and text.isprintable()


def _is_kept(character: str) -> bool:
    return character == "\n" or unicodedata.category(character) not in {"Cc", "Cf", "Cs"}


def clean(text: str) -> str:
    r"""Return the text without what cannot be seen: for everything of a person or robot shown.

    Control and format characters (bidi and zero-width ones among them) and lone surrogates go;
    line breaks of every kind become ``\n``, tabs become spaces.
    """
    if is_plain(text):
        return text
    lines = "\n".join(text.splitlines()).replace("\t", " ")
    unseen = {ord(sign): None for sign in set(lines) if not _is_kept(sign)}
    return lines.translate(unseen) if unseen else lines


def inert_text(text: str) -> str:
    """Return somebody's words, or a robot's, so that no messenger makes a command of them.

    ``/resume`` in what a robot says would be a link that gives the command, and an address one that
    may bring a code; with another sign for the slash (U+2215) both read the same and do nothing.
    """
    return _COMMAND.sub("\u2215", clean(text)) if "/" in text else clean(text)


def clean_name(text: str) -> str:
    """Return a name as it is shown: NFKC, one line, single spaces, at most 64 characters.

    A name is its owner's to choose: whoever is called ``/unlock Eve`` gives others no command.
    """
    return inert_text(" ".join(normalised(clean(text[:NAME_LOOKED_AT])).split())[:LONGEST_NAME])


@lru_cache(maxsize=16_384)
def drawn(name: str) -> str:
    """Return what two names have in common that look alike, for telling them apart.

    Accents, spaces and signs are no difference, nor is the script of a letter that is drawn like a
    Latin one.
    """
    plain = name
    if not name.isascii():
        plain = unicodedata.normalize("NFKD", _bounded_marks(clean(name)))
    letters = _NO_LETTERS.sub("", plain.translate(_DRAWN_LIKE)).casefold()
    return letters.replace("rn", "m").replace("vv", "w")


def quote(text: str) -> str:
    """Return somebody's words inside a sentence: inert, in one line, cut at 32 characters."""
    return f'"{echo(text)}"'


def echo(text: str) -> str:
    """Return somebody's words as `quote` does, without the marks: for one name."""
    words = " ".join(inert_text(text[:NAME_LOOKED_AT]).split())
    return f"{words[:LONGEST_QUOTE]}…" if len(words) > LONGEST_QUOTE else words


def fold_word(word: str) -> str:
    """Return a word in the characters that the grammar reads; case is kept for units.

    Full-width and mathematical forms become plain, every script's digits become ASCII digits. A
    word with a superscript, a circled digit or a fraction is left alone: NFKC would turn 10² into
    102, which is not what was said.
    """
    if word.isascii():
        return word
    return _fold_again(word) if len(word) <= LONGEST_KEPT else _fold(word)


def _fold(word: str) -> str:
    if any(character.isnumeric() and not character.isdecimal() for character in word):
        return word
    word = normalised(word.translate(_SIGNS)).translate(_SIGNS)
    return "".join([str(unicodedata.decimal(c)) if c.isdecimal() else c for c in word])


_fold_again = lru_cache(maxsize=WORDS_KEPT)(_fold)
