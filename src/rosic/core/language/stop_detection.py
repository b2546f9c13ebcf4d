"""Is this a stop? Asked of every message before anything else, and of its raw text.

A false stop is cheap, a missed one is not: whatever is a stop at second glance is one. It needs no
vocabulary, no grammar and no cap of theirs; what the names in it mean is settled afterwards, by
`Vocabulary.to_stop`.
"""

from __future__ import annotations

import re
import unicodedata
from string import punctuation
from typing import TYPE_CHECKING

from rosic.core.language.sanitise import is_plain, normalised
from rosic.core.language.stop_words import (
    ALONG,
    BEGINNING,
    DOUBTFUL,
    EVERYTHING,
    FAILS,
    FREE_TEXT,
    GOES_ON,
    HAD_TO,
    MISSPELT,
    MISSPELT_OF,
    NEGATED,
    NOT,
    PHRASES,
    SHOUTED,
    STOPPING,
    STRONG,
    THINGS,
    TOLD,
    UNSAID,
    UNSPACED,
    UNSTRETCHED,
    fold_stop,
    shorten,
)
from rosic.core.language.suggestions import distance

if TYPE_CHECKING:
    from collections.abc import Container


# So much of a text is looked at, whatever its length.
LOOKED_AT = 4096
# Of more lines these are: a person who stops begins or ends with it.
FIRST_LINES, LAST_LINES = 96, 32
# A longer line talks about something, unless it begins with a stop or consists of nothing else, as
# far as it is looked at.
LONGEST_LINE = 64
LONGEST_SHOUT = 256
LONGEST_WORD = 16
LONGEST_DECORATED = 8 * LONGEST_WORD  # with marks on its letters
# What ends a clause: whoever shouts stop at the end of a sentence means it.
ENDS = ",;:.!?"
KINDS_KEPT = 4096
RESEMBLED = (
    *("stop", "stoppen", "freeze", "anhalten", "arretez", "detente", "fermati"),
    *("zatrzymaj", "zastav", "zaustavi", "durdur", "berhenti", "остановись", "зупинись"),
)
"""What is looked for in a word that is not understood: two letters off, it is offered."""

_BLANKED = str.maketrans({mark: " " for mark in punctuation if mark not in "_@"})
_MENTION = re.compile(r"@(\w*)\S*")
_TRIPLE = re.compile(r"(\w)\1\1")
_SIGNS = re.compile("([🛑✋⛔⏹🤚🖐🚫])")
# Scripts without spaces, where they meet a robot's name.
_SEAM = re.compile(
    "(?<=[\u2e80-\u9fff\uac00-\ud7af])(?=[a-z0-9_])|(?<=[a-z0-9_])(?=[\u2e80-\u9fff\uac00-\ud7af])"
)


def is_stop_word(word: str) -> bool:
    """Whether a word means stop, so that nothing else may be called so."""
    return fold_stop(word) in STOPPING


def hears_stop(text: str, known: Container[str] = ()) -> tuple[str, ...] | None:
    """Return whom a text stops, or None if it is no stop.

    One line that is a stop makes the whole text one. Takes time linear in the first 4,096
    characters, of 256 in a line and of 128 lines, and none for the rest.

    Args:
        text: Raw, as received; any ``str``.
        known: Names of robots, groups, skills, verbs and choices in small letters
            (`Vocabulary.known`). None of them is taken for a misspelt stop.

    Returns:
        The words said beside the stop, in small letters; ``()`` stops everything.
    """
    head = text[:LOOKED_AT]
    if is_plain(head):
        return _heard_ascii(head.lower(), known)
    heard = [_heard(line, known) for line in lines_of(head)]
    stops = [names for names in heard if names is not None]
    if not stops:
        return None
    return () if () in stops else tuple(dict.fromkeys([name for names in stops for name in names]))


def lines_of(head: str) -> list[str]:
    """Return the lines that are looked at, each once: empty ones and repetitions cost nothing."""
    lines = [line for line in dict.fromkeys(head.splitlines()) if line and not line.isspace()]
    if len(lines) <= FIRST_LINES + LAST_LINES:
        return lines
    return lines[:FIRST_LINES] + lines[-LAST_LINES:]


def _heard_ascii(line: str, known: Container[str]) -> tuple[str, ...] | None:
    """Answer for a line in small ASCII letters; almost every message ends at the first return."""
    if "stop" not in line and "halt" not in line:
        words = line.translate(_BLANKED).split()
        if (
            STOPPING.isdisjoint(words)
            and MISSPELT.isdisjoint(words)
            and BEGINNING.isdisjoint(words)
            and not _TRIPLE.search(line)
            and (len(words) > len("stop") or "".join(words) not in STRONG)
        ):
            return None
    return _heard(line, known)


def _heard(line: str, known: Container[str]) -> tuple[str, ...] | None:
    line = line.strip()
    words, folded = _read(line, known)
    found = _heard_whole(line, words, folded, known)
    if found is None and (last := _last_clause(line)):  # watch out, STOP
        found = _heard_whole(last, *_read(last, known), known)
        found = found if found is not None and _all_known(found, known) else None
    if found is None and (first := _first_clause(line)):  # para, atrás
        found = _heard_whole(first, *_read(first, known), known)
        found = found if found is not None and _all_known(found, known) else None
    if found is None and not STOPPING.isdisjoint(folded):
        return _heard_shouted(line, words, folded, known)
    return found


def _last_clause(line: str) -> str:
    """Return what is said after the last sign that parts sentences; empty: there is none."""
    parted = max(map(line.rstrip(ENDS).rfind, ENDS))
    return line[parted + 1 :] if parted >= 0 and len(line) - parted <= LONGEST_LINE else ""


def _first_clause(line: str) -> str:
    """Return what is said before the first comma of a short line; empty: there is none."""
    first, comma, rest = line.partition(",")
    return first if comma and rest.strip() and len(line) <= LONGEST_LINE else ""


def _read(line: str, known: Container[str]) -> tuple[list[str], list[str]]:
    """Return the words of a line, and how each is looked up."""
    words = _stop_words_of(_beginning(line), known)
    folded = [fold_stop(word) for word in words]
    folded = [w if w in STOPPING or not _TRIPLE.search(w) else _unstretched(w) for w in folded]
    if not BEGINNING.isdisjoint(folded):
        words, folded = _phrased(words, folded, known)
    return words, folded


def _heard_whole(
    line: str, words: list[str], folded: list[str], known: Container[str]
) -> tuple[str, ...] | None:
    if not words:
        return None
    if "".join(folded) in STRONG:  # s t o p
        return ()
    stops = [at for at, word in enumerate(folded) if word in STOPPING]
    if len(line) > LONGEST_LINE and not _is_shout(line, folded, known):
        return None
    if not stops:
        return _heard_misspelt(words, folded, known)
    return _heard_exact(words, folded, stops, known)


def _stop_words_of(line: str, known: Container[str]) -> list[str]:
    """Return the words of a line, those that are written as one parted where a stop is in them."""
    words = words_of(line, known)
    if not line.isascii():
        words = [part for word in words for part in _parted(word, known)]
    if "_" in line:  # /stop_omni
        parted = [[word] if word in known else word.split("_") for word in words]
        words = [word for part in parted for word in part if word]
    return words


def _phrased(
    words: list[str], folded: list[str], known: Container[str]
) -> tuple[list[str], list[str]]:
    """Return the words with what means stop in several of them made one: ``not aus``."""
    raw: list[str] = []
    one: list[str] = []
    at = 0
    while at < len(folded):
        doubted = folded[at] == DOUBTFUL and at > 0 and words[at - 1] not in known
        phrase, end = (folded[at], at + 1) if doubted else _phrase_at(folded, at)
        raw.append(words[at])
        one.append(phrase)
        at = end
    return raw, one


def _phrase_at(folded: list[str], at: int) -> tuple[str, int]:
    """Return the phrase that begins here as one word, and its end; else the word that is here."""
    for phrase in PHRASES:
        end = at
        for word in phrase:
            while at < end < len(folded) and folded[end] != word and folded[end] in ALONG:
                end += 1
            if end == len(folded) or folded[end] != word:
                break
            end += 1
        else:
            return "".join(phrase), end
    return folded[at], at + 1


def _beginning(line: str) -> str:
    """Return what is looked at of a line: whole words, unless it is one."""
    if len(line) <= LONGEST_SHOUT:
        return line
    end = line.rfind(" ", 0, LONGEST_SHOUT + 1)
    return line[: end if end > 0 else LONGEST_SHOUT]


def words_of(line: str, known: Container[str]) -> list[str]:
    """Split a line into words in small letters, each sign a word of its own."""
    if "@" in line:  # /stop@account, or a mention of our account in a group
        line = _MENTION.sub(lambda m: f" {m[1]}" if m[1].lower() in known else " ", line)
    if is_plain(line):
        return line.lower().translate(_BLANKED).split()
    line = _SIGNS.sub(r" \1 ", normalised(line).casefold())
    return _SEAM.sub(" ", line.translate(_KEPT)).split()


class _Kept(dict[int, str]):
    """What each character is in a word: itself, nothing, or the end of the word."""

    def __missing__(self, code: int) -> str:
        if len(self) >= KINDS_KEPT:
            self.clear()
        self[code] = kept = _kept(chr(code))
        return kept


def _kept(character: str) -> str:
    kind = unicodedata.category(character)
    if kind[0] in "LNM" or character == "_" or _SIGNS.match(character):
        return character
    return "" if kind in {"Cc", "Cf", "Cs", "Sk"} and not character.isspace() else " "


_KEPT = _Kept()


def _parted(word: str, known: Container[str]) -> tuple[str, ...]:
    """Return a word of a script without blanks as what stops, and what is said beside it."""
    if word.isascii() or len(word) > LONGEST_WORD:
        return (word,)
    if not (word.endswith(UNSPACED) or word.startswith(UNSPACED)):
        return (word,)
    if word in known or fold_stop(word) in STOPPING:
        return (word,)
    for stop in UNSPACED:
        if word.endswith(stop):
            rest = word.removesuffix(stop)
            return (word,) if rest.endswith(NEGATED) else (rest, stop)
        if word.startswith(stop):
            rest = word.removeprefix(stop)
            return (word,) if rest.startswith(GOES_ON) else (stop, rest)
    return (word,)


def _unstretched(word: str) -> str:
    return UNSTRETCHED.get(shorten(word), word)


def _is_shout(line: str, folded: list[str], known: Container[str]) -> bool:
    """Whether a long line is a stop all the same."""
    meaning = [word for word in folded if word not in ALONG and word not in known]
    if not meaning:
        return False
    if meaning[0] in STRONG and len(line) <= LONGEST_SHOUT:
        return True
    return all(word in STOPPING or word in EVERYTHING for word in meaning)


def _is_aside(word: str) -> bool:
    return word in ALONG or word in EVERYTHING or word in STOPPING


def _heard_exact(
    words: list[str], folded: list[str], stops: list[int], known: Container[str]
) -> tuple[str, ...] | None:
    """Decide about a line that has a stop word at the places ``stops``."""
    first = stops[0]
    if first > 0 and folded[first - 1] in UNSAID:
        return None
    others = tuple([w for w, f in zip(words, folded, strict=True) if not _is_aside(f)])
    leads = folded[first] in STRONG and all(w in ALONG or w in known for w in folded[:first])
    if not others or (leads and not EVERYTHING.isdisjoint(folded)):
        return ()
    if leads or len(others) == 1 or _all_known(others, known):
        return others
    return None


def _heard_shouted(
    line: str, words: list[str], folded: list[str], known: Container[str]
) -> tuple[str, ...] | None:
    """Decide about a short line in whose midst somebody shouts: ``guys stop omni``."""
    if len(line) > LONGEST_LINE or line.startswith("/") or _hands_on(words, folded, known):
        return None
    shouts = [at for at in range(len(folded)) if _is_shouted(folded, at)]
    if not shouts:
        return None
    others = [
        (at, word)
        for at, (word, f) in enumerate(zip(words, folded, strict=True))
        if not _is_aside(f) and f not in UNSAID and f not in FAILS
    ]
    behind = tuple([word for at, word in others if at > shouts[-1]])
    if behind and _all_known(behind, known):
        return behind
    return tuple([word for _, word in others])


def _hands_on(words: list[str], folded: list[str], known: Container[str]) -> bool:
    """Whether a line is a text for somebody else, after the names that it begins with."""
    for word, f in zip(words, folded, strict=True):
        if f in FREE_TEXT or (word not in known and f not in ALONG):
            return f in FREE_TEXT
    return False


def _is_shouted(folded: list[str], at: int) -> bool:
    if folded[at] not in SHOUTED or (at + 1 < len(folded) and folded[at + 1] in THINGS):
        return False
    before = folded[at - 1] if at else ""
    if before in UNSAID:
        return before in FAILS or (before in NOT and not FAILS.isdisjoint(folded[:at]))
    return before not in TOLD and folded[max(0, at - 2) : at] != HAD_TO


def resembles_stop(word: str) -> bool:
    """Whether a word that nothing is called by may be a stop that was hurried: ``stahp``, ``stio``.

    Asked of lines of one word that are not understood alone. Short words have to begin alike: many
    words of every day lie two letters away from them.
    """
    folded = fold_stop(word) if len(word) <= LONGEST_DECORATED else word
    if len(folded) > LONGEST_WORD:
        return False
    return any(folded[:1] == stop[0] and distance(folded, stop, 2) < 3 for stop in RESEMBLED)  # noqa: PLR2004


def speaks_of_stop(text: str, known: Container[str] = ()) -> bool:
    """Whether a text that is no stop holds a word that stops, and does not say the opposite.

    Asked of what is not understood alone: whoever wrote it may have meant it.
    """
    for line in lines_of(text[:LOOKED_AT]):
        folded = [fold_stop(word) for word in words_of(_beginning(line.strip()), known)]
        for at, word in enumerate(folded):
            if word in SHOUTED and (at == 0 or folded[at - 1] not in UNSAID):
                return True
    return False


def _heard_misspelt(
    words: list[str], folded: list[str], known: Container[str]
) -> tuple[str, ...] | None:
    """Decide about a line without any stop word, where one may be misspelt."""
    meaning = [(w, f) for w, f in zip(words, folded, strict=True) if not _is_aside(f)]
    slips = [w for w, f in meaning if _is_slip(f) and w not in known]
    others = tuple([w for w, _ in meaning if w not in slips])
    if slips and (not others or _all_known(others, known)):
        return others
    if len(meaning) == 1:  # stopomni
        word = meaning[0][1]
        rest = next((word[len(stop) :] for stop in MISSPELT_OF if word.startswith(stop)), "")
        if word in known or not rest:
            return None
        return (rest,) if rest in known else () if _is_aside(rest) else None
    return None


def _is_slip(word: str) -> bool:
    if word.isascii():
        return word in MISSPELT
    return len(word) <= 5 and any(distance(word, stop, 1) <= 1 for stop in MISSPELT_OF)  # noqa: PLR2004


def _all_known(words: tuple[str, ...], known: Container[str]) -> bool:
    return " ".join(words) in known or all(word in known for word in words)
