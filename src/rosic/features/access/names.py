"""Whom somebody means: by name, spaces and all, or by what a button says."""

from __future__ import annotations

from hashlib import blake2b
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined, said
from rosic.core.language import clean_name
from rosic.core.language.suggestions import MOST_SUGGESTIONS, did_you_mean
from rosic.core.message import Button
from rosic.errors import NotUnderstood
from rosic.features.access import messages
from rosic.gateway.builtin_commands import Reply

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.authoriser.directory import Directory
    from rosic.core.identity import Principal
    from rosic.features.access.context import AccessContext
    from rosic.gateway.office import CommandContext

BY_ID: Final = b"by its id"
"""What a button carries that means one person, whoever else may be called like that id."""
CHANGED: Final = said("Nothing was done yet: something has changed here since you were asked.")
SURE_BYTES: Final = 16
MOST_OFFERED = 8


class PersonNames:
    """Finds people in the directory."""

    def __init__(self, registry: AccessContext) -> None:
        self._directory = registry.authoriser.directory

    def find(
        self, asked: CommandContext, said: str, verb: str, fits: Callable[[Principal], bool]
    ) -> Principal | Reply:
        """Return who is meant, or the question which of several.

        All of what was said is the name: no word of it means anything else.

        Args:
            asked: By whom, where. Names are offered only where nobody else reads along.
            said: A name, or an id.
            verb: What is to be done, for offers: ``lock``.
            fits: Whether it can be done with somebody; preferred where names are shared.

        Raises:
            NotUnderstood: Nobody; offers who may have been meant.
        """
        by_id = self._directory.person(said)
        if by_id is not None and asked.act:
            return by_id
        private = asked.private
        named = self.called(said)
        fitting = tuple(filter(fits, named)) or named
        if len(fitting) == 1:
            return fitting[0]
        if not fitting:
            raise NotUnderstood(
                messages.nobody_called(said), offers=self._offers(said, verb) if private else ()
            )
        if not private:
            raise NotUnderstood(messages.several_in_group(len(fitting), said))
        buttons = tuple((by_id_button(p, f"/{verb} {p.id}"),) for p in fitting[:MOST_OFFERED])
        return Reply(messages.several(len(fitting), said), buttons)

    def called(self, said: str) -> tuple[Principal, ...]:
        """Return everybody who is called so, or has that id; each once."""
        return everybody_called(self._directory, said)

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


def everybody_called(directory: Directory, said: str) -> tuple[Principal, ...]:
    """Return everybody who is called so, or has that id; each once.

    An id is nobody's secret, and a name is its owner's to choose: one that is another's id must
    not decide who is meant.
    """
    name = clean_name(said)
    by_id = directory.person(said)
    found = (() if by_id is None else (by_id,), directory.named(name) if name else ())
    return tuple({person.id: person for some in found for person in some}.values())


def by_id_button(person: Principal, command: str, *more: str) -> Button:
    """Return the button that means one of several; what else it says stands in its label."""
    label = joined(", ", (messages.told_apart(person.name, person.roles), *more))
    return Button(label, command, act=BY_ID)


def asked_again(act: bytes, question: str) -> str:
    """Return a question, and why it is asked once more of somebody who has agreed to it."""
    return joined("\n", (CHANGED, question)) if act not in {b"", BY_ID} else question


def sure(*about: object) -> bytes:
    """Return what a button carries that confirms something: a digest of all that was shown.

    Nobody can type it: a word in a command would also be a word in somebody's name. Whatever is
    different by the time of the tap is asked again.
    """
    said = repr(about).encode("utf-8", "replace")
    return blake2b(said, digest_size=SURE_BYTES).digest()
