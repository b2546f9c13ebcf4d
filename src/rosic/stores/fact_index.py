"""Facts as they are handed over: those of a kind together, each in its place."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.records import Fact


def by_kind(facts: Iterable[Fact]) -> dict[str, tuple[Fact, ...]]:
    """Return facts under their kinds, in the order in which they come."""
    found: dict[str, list[Fact]] = {}
    for fact in facts:
        found.setdefault(fact.kind, []).append(fact)
    return {kind: tuple(those) for kind, those in found.items()}
