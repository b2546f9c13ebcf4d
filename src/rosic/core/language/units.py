"""Units as factors. Whoever starts ROSIC compiles them; this module only looks them up."""

from __future__ import annotations

import msgspec


class Unit(msgspec.Struct, frozen=True):
    """How a spelled unit becomes SI: ``value * factor + offset``.

    Attributes:
        symbol: How it is shown.
        dimension: What it measures, in a word a person may read: ``length``, ``turning speed``.
        factor: Greater than 0.
        offset: 0 but for temperatures.
    """

    symbol: str
    dimension: str
    factor: float
    offset: float = 0.0

    def to_si(self, value: float) -> float:
        """Return a value of this unit in SI."""
        return value * self.factor + self.offset

    def from_si(self, value: float) -> float:
        """Return a value in SI in this unit."""
        return (value - self.offset) / self.factor


# A plain number: a count, the index of a joint.
NONE = Unit("", "", 1.0)


class UnitTable(msgspec.Struct, frozen=True):
    """Every spelling of every unit.

    Attributes:
        exact: Spelling, in the right case, to unit.
        forgiving: Lower-case spelling to unit, where the case decides nothing: ``CM`` is cm, but
            ``Mm`` is not mm.
    """

    exact: dict[str, Unit]
    forgiving: dict[str, Unit]

    def find(self, spelled: str) -> Unit | None:
        """Return the unit of a spelling, or None."""
        return self.exact.get(spelled) or self.forgiving.get(spelled.casefold())

    def of(self, dimension: str) -> tuple[str, ...]:
        """Return the spellings of a dimension; for suggestions, it looks at all of them."""
        return tuple(s for s, unit in self.exact.items() if unit.dimension == dimension)
