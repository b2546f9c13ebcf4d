"""``operator kuka1 for 2h code 10m as Cy Young``: what somebody is to be invited to.

Total and linear: each word is looked at by a fixed number of rules.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from rosic.authoriser.invitation import CODE_TTL_S, Given, Wanted
from rosic.core.language import clean, clean_name
from rosic.core.language.cleaning import fold_word
from rosic.core.language.suggestions import did_you_mean
from rosic.core.language.when_said import Said, Unclear
from rosic.core.reach import FLEET
from rosic.errors import NotUnderstood
from rosic.pipeline.people import words

if TYPE_CHECKING:
    from rosic.core.rights import Rights

LONGEST_LINE = 300
LENGTH_WORDS = 4
_FILLERS = frozenset({"a", "an", "and", "as", "at", "everywhere", "on", "the", "with", ",", "&"})
_LASTS, _CODE = "for", "code"
_AS = re.compile(r"\s+as\s+", re.IGNORECASE)


def read_invitation(text: str, rights: Rights) -> Wanted:
    """Read what an invitation shall give.

    Args:
        text: After ``/invite``.
        rights: Which roles and robots there are.

    Raises:
        NotUnderstood: Which word is none; offers the line that was meant.
    """
    said = clean(text).replace("\n", " ").strip()
    if len(said) > LONGEST_LINE:
        raise NotUnderstood(words.LINE_TOO_LONG)
    before, *after = _AS.split(said, maxsplit=1)
    reading = _Reading(before, rights)
    if after:
        reading.name(after[0])
    return reading.wanted()


class _Reading:
    """Reads the words one after another."""

    def __init__(self, before: str, rights: Rights) -> None:
        self._rights = rights
        self._roles = {name.casefold(): name for name in rights.rulebook.roles}
        self._lengths: dict[str, float] = {}
        self._given: list[str] = []
        self._where: list[str] = []
        self._name = ""
        self._said = before
        self._walk(_split(before))

    def _walk(self, low: list[str]) -> None:
        at = 0
        while at < len(low):
            word = low[at]
            if word in {_LASTS, _CODE}:
                at += 1 + self._length(word, low[at + 1 : at + 1 + LENGTH_WORDS])
                continue
            if word in self._roles:
                self._given.append(self._roles[word])
            elif word != FLEET and self._rights.fleet.robots(word):
                self._where.append(word)
            elif word not in _FILLERS:
                raise self._unknown(word)
            at += 1

    def _length(self, which: str, low: list[str]) -> int:
        """Read how long; return how many words that took."""
        if which in self._lengths:
            raise NotUnderstood(words.twice_how_long(which))
        seconds, used = _length(low)
        if not used:
            raise NotUnderstood(words.no_length(which, " ".join(low[:1])))
        self._lengths[which] = seconds
        return used

    def name(self, text: str) -> None:
        """Read a name; how long, and the code's time, may stand after it."""
        low = _split(text)
        raw = text.replace(",", " , ").split()
        ends = len(low)
        for at in range(1, len(low)):
            if low[at] in {_LASTS, _CODE} and _length(low[at + 1 : at + 1 + LENGTH_WORDS])[1]:
                ends = at
                break
        self._name = clean_name(" ".join(raw[:ends]))
        self._walk(low[ends:])

    def wanted(self) -> Wanted:
        """Return what was said."""
        if not self._given:
            raise NotUnderstood(words.no_role(tuple(self._roles.values())))
        given = Given(
            roles=tuple(dict.fromkeys(self._given)),
            robots=tuple(dict.fromkeys(self._where)),
            lasts_s=self._lengths.get(_LASTS),
        )
        return Wanted(given=given, code_ttl_s=self._lengths.get(_CODE, CODE_TTL_S), name=self._name)

    def _unknown(self, word: str) -> NotUnderstood:
        fleet = self._rights.fleet
        close = did_you_mean(word, (*self._roles, *fleet.skills, *fleet.groups))
        offers = tuple(f"/invite {_with(self._said, word, other)}" for other in close)
        return NotUnderstood(words.no_role_no_robot(word, close), offers=offers)


def _with(said: str, word: str, other: str) -> str:
    return " ".join(other if fold_word(w).casefold() == word else w for w in said.split())


def _split(text: str) -> list[str]:
    return [fold_word(word).casefold() for word in text.replace(",", " , ").split()]


def _length(low: list[str]) -> tuple[float, int]:
    """Return the length that the first words say, and how many words: as many as go."""
    ends = next((at for at, word in enumerate(low) if word in {_LASTS, _CODE}), len(low))
    for used in range(ends, 0, -1):
        try:
            said = Said(" ".join(low[:used]))
        except Unclear:
            continue
        other = (said.start, said.end, said.day, said.date, said.delay_s, said.count, said.until)
        if said.length_s is not None and not said.weekdays and all(o is None for o in other):
            return said.length_s, used
    return 0.0, 0
