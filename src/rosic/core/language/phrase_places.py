"""Places in a line as people write it: ``this is the dock``; once it is kept, ``to the dock``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.language.lexicon import SenseKind

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.language.compiled import NameTarget
    from rosic.core.language.kept_places import KeptPlace
    from rosic.core.language.lexicon import LexiconTable
    from rosic.core.language.phrase_words import Item

PLACE: Final = "place"
KEEP: Final = "keep"
TO: Final = "to"
_ANY_WAY: Final = frozenset({"goto", "move"})
_ASIDE: Final = (SenseKind.NOTHING, SenseKind.REQUEST)
_ELSE: Final = (SenseKind.BLOCKED, SenseKind.MANNER, SenseKind.QUESTION, SenseKind.TIME)


def kept_name(items: Sequence[Item]) -> str:
    """Return how the place is called where a robot is: ``this is the dock``; empty: it is not said.

    Args:
        items: The line, without whom it is for.
    """
    said = [item for item in items if not _is_aside(item) or item.means(SenseKind.PLACE)]
    if len(said) < 2 or KEEP not in said[0].values(SenseKind.PLACE):  # noqa: PLR2004
        return ""
    named = said[1:]
    other = any(item.means(kind) for item in named for kind in _ELSE)
    if other or any(item.numeral is not None or item.callee is not None for item in named):
        return ""
    words = [word for item in named for word in item.text.split()]
    if all(len(word) == 1 and not word.isascii() for word in words):
        return "".join(words)
    return words[-1] if len(named) == 1 else ""


def keeping_line(callee: NameTarget, name: str) -> str:
    """Return the line that keeps the place where a robot is."""
    return f"/{PLACE} {callee.name} {name}"


def place_gone_to(
    items: Sequence[Item], places: dict[str, KeptPlace], table: LexiconTable
) -> tuple[KeptPlace | None, bool]:
    """Return the place that a line goes to, and whether it says so in so many words.

    ``go to the dock`` does; ``drive dock`` may say something else.

    Args:
        items: The line, without whom it is for.
        places: Of the robot.
        table: The language.
    """
    named = [at for at, item in enumerate(items) if item.means(SenseKind.OWN_PLACE)]
    if len(named) != 1:
        return None, False
    at = named[0]
    place = places.get(items[at].values(SenseKind.OWN_PLACE)[0])
    if place is None:
        return None, False
    others = [item for item in (*items[:at], *items[at + 1 :]) if not _is_aside(item)]
    going = {*_ANY_WAY, place.skill}
    if not others or any(going.isdisjoint(_motions(item)) for item in others):
        return None, False
    behind = max(item.at for item in others) < items[at].at
    surely = any(not {"goto", place.skill}.isdisjoint(_motions(item)) for item in others)
    words = [word for item in items[: at + 1] for word in item.text.split()]
    return place, behind and (surely or any(_says_to(word, table) for word in words))


def _is_aside(item: Item) -> bool:
    return any(item.means(kind) for kind in _ASIDE)


def _motions(item: Item) -> tuple[str, ...]:
    return (
        *item.values(SenseKind.VERB),
        *item.values(SenseKind.SKILL),
        *item.values(SenseKind.OWN_SKILL),
    )


def _says_to(word: str, table: LexiconTable) -> bool:
    senses = table.senses.get(word, ())
    return any(sense.kind is SenseKind.PLACE and sense.value == TO for sense in senses)
