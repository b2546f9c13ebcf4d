"""Numbers as people write them in words: ``half a metre``, ``fünfundvierzig Grad``, ``一米五``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.language.lexicon import SenseKind

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.language.numbers import UnitTable
    from rosic.core.language.phrase_words import Item

_TENS: Final = range(20, 100, 10)
_SCORES: Final = (60.0, 80.0)
"""French counts on from them: ``soixante quinze``."""
_HUNDRED, _TEN = 100.0, 10.0
_NO_UNIT: Final = frozenset(
    {
        *(SenseKind.CHOICE, SenseKind.OWN_CHOICE, SenseKind.NOTHING, SenseKind.PARAMETER),
        SenseKind.OWN_PARAMETER,
    }
)
"""What a word says that is no unit although one is spelled so: ``in``."""
_BEGIN_NUMBER: Final = frozenset(
    {SenseKind.MINUS, SenseKind.UNIT, SenseKind.AMOUNT, SenseKind.ONE, SenseKind.NUMBER}
)


class SpokenNumber(NamedTuple):
    """A number in a line.

    Attributes:
        unit: Symbol or spelling of the unit that follows it; empty for none.
        after: Place of the words behind both.
    """

    value: float
    unit: str
    after: int


class SpokenNumbers:
    """Finds numbers among the words of a line, in words or digits, with their units.

    Args:
        items: The words.
        units: Those that are known in every language.
        positional: How numbers are put together: see `Numerals.positional`.
    """

    __slots__ = ("_items", "_positional", "_units")

    def __init__(self, items: Sequence[Item], units: UnitTable, *, positional: bool) -> None:
        self._items = items
        self._units = units
        self._positional = positional

    def at(self, at: int) -> SpokenNumber | None:
        """Return the number that begins at a place; None where none does."""
        item = self._items[at]
        if item.numeral is None and _BEGIN_NUMBER.isdisjoint(item.kinds):
            return None
        if item.means(SenseKind.MINUS) and at + 1 < len(self._items):
            found = self.at(at + 1)
            return None if found is None else found._replace(value=-found.value)
        if item.means(SenseKind.UNIT) and self._means(at + 1, SenseKind.HALF_MORE):
            return SpokenNumber(1.5, item.values(SenseKind.UNIT)[0], at + 2)
        for amount in item.values(SenseKind.AMOUNT):
            value, _, unit = amount.partition(" ")
            return SpokenNumber(float(value), unit, at + 1)
        number = self._one(at) or self._counted(at)
        if number is None:
            return None
        number = self._halved(number)
        in_words = item.numeral is None or self._positional
        return self._centimetres(number) if in_words else number  # 1 m once

    def _one(self, at: int) -> SpokenNumber | None:
        """Return 1 with its unit: ``a metre``."""
        unit = self._unit(at + 1) if self._means(at, SenseKind.ONE) else ""
        return SpokenNumber(1.0, unit, at + 2) if unit else None

    def _counted(self, at: int) -> SpokenNumber | None:
        found = self._value(at)
        if found is None:
            return None
        if not found.unit and (unit := self._unit(found.after)):
            return found._replace(unit=unit, after=found.after + 1)
        return found

    def _value(self, at: int) -> SpokenNumber | None:
        """Return a number, with the unit that stands in the same word."""
        numeral = self._items[at].numeral
        if numeral is None:
            found = self._in_words(at)
            if found is None:
                return None
            value, after = found
        elif numeral.readings or numeral.value != numeral.value:
            return None
        elif numeral.rest:
            return SpokenNumber(numeral.value, numeral.rest, at + 1)
        else:
            value, after = numeral.value, at + 1
        after += self._means(after, SenseKind.COUNTER)
        if self._means(after, SenseKind.HALF_MORE) and not self._counts(after):
            value, after = value + 0.5, after + 1
        return SpokenNumber(value, "", self._to_unit(value, after))

    def _to_unit(self, value: float, at: int) -> int:
        """Return where the unit of a part of one stands: ``half a metre``; else the same place."""
        between = SenseKind.ONE if self._means(at, SenseKind.ONE) else SenseKind.NOTHING
        parts = value < 1 and self._means(at, between)
        return at + 1 if parts and self._unit(at + 1) else at

    # ---- in words ----

    def _in_words(self, at: int) -> tuple[float, int] | None:
        """Return a number put together of as many words as there are, and where it ends."""
        first = self._numeral(at)
        if first is None:
            return None
        whole, part, at = 0.0, first, at + 1
        if first >= _HUNDRED:
            whole, part = first, 0.0
        while True:
            joined = self._means(at, SenseKind.JOINER) and not self._counts(at)
            after = at + joined
            number = self._numeral(after)
            if number is None and joined and self._means(after, SenseKind.ONE):
                number = 1.0
            added = None if number is None else self._added(whole, part, number)
            if added is None:
                break
            whole, part = added
            at = after + 1
        return self._decimals(whole + part, at)

    def _added(self, whole: float, part: float, number: float) -> tuple[float, float] | None:
        """Return what a number is with another behind it; None where that is one of its own."""
        if number >= _HUNDRED and 0 < part < _HUNDRED:
            return (whole + part) * number, 0.0
        if self._positional and number == _TEN and 0 < part < _TEN:
            return whole, part * number
        if number < _TEN and (part in _TENS or (self._positional and part == _TEN)):
            return whole, part + number
        if part in _SCORES and _TEN < number < 2 * _TEN:
            return whole, part + number
        # 一百二 is 120, and not 102.
        short = self._positional and number < _TEN
        return (whole, number) if whole and not part and number < _HUNDRED and not short else None

    def _decimals(self, value: float, at: int) -> tuple[float, int]:
        digits, after = "", at + 1
        while self._means(at, SenseKind.POINT) and (number := self._numeral(after)) is not None:
            if number not in range(10):
                break
            digits += f"{number:.0f}"
            after += 1
        return (float(f"{value:.0f}.{digits}"), after) if digits else (value, at)

    def _numeral(self, at: int) -> float | None:
        numbers = self._items[at].values(SenseKind.NUMBER) if at < len(self._items) else ()
        return float(numbers[0]) if numbers else None

    # ---- behind it ----

    def _halved(self, number: SpokenNumber) -> SpokenNumber:
        """Return a number with the half behind its unit: ``二米半``."""
        if number.value >= 1 and self._means(number.after, SenseKind.HALF_MORE):
            return number._replace(value=number.value + 0.5, after=number.after + 1)
        return number

    def _centimetres(self, number: SpokenNumber) -> SpokenNumber:
        """Return metres with the centimetres in words behind them: ``un mètre cinquante``."""
        at = number.after
        if number.unit != "m" or number.value < 0 or not float(number.value).is_integer():
            return number
        found = self._in_words(at) if at < len(self._items) else None
        if found is None or self._unit(found[1]) or not 0 < found[0] < _HUNDRED:
            return number
        if found[0] < _TEN and not self._positional:
            return number  # un mètre cinq
        part = found[0] / (_HUNDRED if found[0] >= _TEN else _TEN)
        return SpokenNumber(number.value + part, number.unit, found[1])

    def _counts(self, at: int) -> bool:
        """Whether what stands here counts the unit behind it."""
        number = self._numeral(at)
        return (
            bool(number) and bool(self._unit(at + 1)) and not self._means(at, SenseKind.HALF_MORE)
        )

    def _means(self, at: int, kind: SenseKind) -> bool:
        return at < len(self._items) and self._items[at].means(kind)

    def _unit(self, at: int) -> str:
        """Return the unit that stands here; empty: none does."""
        item = self._items[at] if at < len(self._items) else None
        if item is None or item.callee is not None or item.numeral is not None:
            return ""
        units = item.values(SenseKind.UNIT)
        if units:
            return units[0]
        known = self._units.find(item.raw or item.text)
        says_else = any(sense.kind in _NO_UNIT for sense in item.senses)
        return known.symbol if known is not None and not says_else else ""
