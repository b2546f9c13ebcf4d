"""Whom somebody means: by name, spaces and all, or by what a button says."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.language import clean_name
from rosic.core.language.suggestions import MOST_SUGGESTIONS, did_you_mean
from rosic.core.message import Button
from rosic.errors import NotUnderstood
from rosic.pipeline.desk import Reply
from rosic.pipeline.people import words

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.core.identity import Principal
    from rosic.pipeline.people.registry import Registry

CONFIRMED = "confirmed"
"""The last word of a command that a button says after the question was asked."""
MOST_OFFERED = 8


class Names:
    """Finds people in the directory."""

    def __init__(self, registry: Registry) -> None:
        self._directory = registry.authoriser.directory

    def find(
        self, said: str, verb: str, fits: Callable[[Principal], bool], *, private: bool
    ) -> Principal | Reply:
        """Return who is meant, or the question which of several.

        Args:
            said: A name, or an id that a button says.
            verb: What is to be done, for offers: ``lock``.
            fits: Whether it can be done with somebody; preferred where names are shared.
            private: Whether names may be offered: nobody else reads along.

        Raises:
            NotUnderstood: Nobody; offers who may have been meant.
        """
        by_id = self._directory.person(said)
        if by_id is not None:
            return by_id
        named = self._directory.named(clean_name(said))
        fitting = tuple(filter(fits, named)) or named
        if len(fitting) == 1:
            return fitting[0]
        if not fitting:
            raise NotUnderstood(
                words.nobody_called(said), offers=self._offers(said, verb) if private else ()
            )
        if not private:
            raise NotUnderstood(words.several_in_group(len(fitting), said))
        buttons = tuple(
            (Button(words.told_apart(p.name, p.roles), f"/{verb} {p.id}"),)
            for p in fitting[:MOST_OFFERED]
        )
        return Reply(words.several(len(fitting), said), buttons)

    def _offers(self, said: str, verb: str) -> tuple[str, ...]:
        wanted = clean_name(said).casefold()
        if not wanted:
            return ()
        everybody = sorted({person.name for person in self._directory.people()})
        parts = [n for n in everybody if any(w.startswith(wanted) for w in _words_of(n))]
        close = parts[:MOST_SUGGESTIONS] or did_you_mean(wanted, _first_alike(everybody, wanted))
        return tuple(f"/{verb} {name}" for name in close)


def _words_of(name: str) -> Iterable[str]:
    return name.casefold().split()


def _first_alike(names: Iterable[str], wanted: str) -> list[str]:
    """Put names with the same first letter first: only so many are looked at."""
    return sorted(names, key=lambda name: name[:1].casefold() != wanted[0])


def confirmed(rest: str) -> tuple[str, bool]:
    """Return whom a command means, and whether the question was asked before."""
    before, _, last = rest.rpartition(" ")
    return (before.strip(), True) if before.strip() and last == CONFIRMED else (rest.strip(), False)
