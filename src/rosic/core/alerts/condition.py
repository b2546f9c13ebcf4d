"""What a rule asks of a robot, compiled: ``battery < 20 %`` becomes a comparison in its unit."""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import isfinite
from typing import TYPE_CHECKING

import msgspec

from rosic.core.alerts.state import AlertReading
from rosic.core.language.numbers import NONE, UnitTable
from rosic.core.robot.benchmark import DEVIATION, FINE

if TYPE_CHECKING:
    from rosic.core.language.numbers import Unit
    from rosic.core.robot.profile import Presence

LINK_AGE = "link_age"
OFFLINE = "offline"
SILENT = "silent"
DEVIATES = "deviates"
OWN = frozenset({LINK_AGE, OFFLINE, SILENT, DEVIATION, DEVIATES})
# A robot that reports says something every second at least.
SILENT_AFTER_S = 1.5
# How far beyond its threshold a value has to be for an alarm to be over, unless a rule says so.
BEYOND = 0.05

_NUMBER = r"[-+]?\d+(?:\.\d+)?"
_AMOUNT = re.compile(rf"(?P<number>{_NUMBER}) *(?P<unit>[^\d\s]\S*(?: \S+)*)?")
_COMPARED = re.compile(r"(?P<name>[a-z][a-z0-9_]*) *(?P<sign><=|>=|<|>) *(?P<amount>\S.*)")
_RANGE = re.compile(
    rf"(?P<name>[a-z][a-z0-9_]*) +(?P<word>outside|within) +(?P<low>{_NUMBER}) +to +(?P<high>\S.*)"
)
_WORD = re.compile(r"(?P<name>[a-z][a-z0-9_]*) +is +(?P<word>\S.{0,63})")
_ALONE = re.compile(r"(?P<name>[a-z][a-z0-9_]*)(?P<silent> +silent)?")


class ConditionBounds(msgspec.Struct, frozen=True):
    """Between which a value is as wanted, in the unit of the profile; open where it is None.

    Attributes:
        strict: A value at the bound itself is outside.
    """

    low: float | None = None
    high: float | None = None
    strict: bool = False

    def holds(self, value: float) -> bool:
        """Whether a value lies between."""
        low, high = self.low, self.high
        if self.strict:
            return (low is None or value > low) and (high is None or value < high)
        return (low is None or value >= low) and (high is None or value <= high)


class Condition(msgspec.Struct, frozen=True, kw_only=True):
    """When a rule is bad, and when it is good again.

    Attributes:
        name: The value that counts; empty for the robot as a whole.
        kind: ``bounds``, ``word``, ``silent``, ``offline`` or ``deviates``.
        fine: Outside it is bad.
        clear: Within it is good.
        word: What a text has to be to be bad.
        unit: In which the value is shown.
    """

    name: str
    kind: str = "bounds"
    fine: ConditionBounds = ConditionBounds()
    clear: ConditionBounds = ConditionBounds()
    word: str = ""
    unit: str = ""

    def reading(self, presence: Presence) -> AlertReading:
        """Say what a robot's newest report means."""
        if self.kind == OFFLINE:
            known = presence.online is not None
            return _bad(presence.online is False) if known else AlertReading.MISSING
        value = self.value(presence)
        if self.kind == SILENT:
            return _bad(value is None)
        if self.kind == DEVIATES:
            return _bad(value != FINE) if isinstance(value, str) else AlertReading.MISSING
        if self.kind == "word":
            known = isinstance(value, str)
            return _bad(str(value).casefold() == self.word) if known else AlertReading.MISSING
        return self._measured(value) if isinstance(value, (int, float)) else AlertReading.MISSING

    def _measured(self, value: float) -> AlertReading:
        if not self.fine.holds(value):
            return AlertReading.BAD
        return AlertReading.GOOD if self.clear.holds(value) else AlertReading.BETWEEN

    def value(self, presence: Presence) -> float | str | None:
        """Return what counts; None if it is not known: not reported, no number, or too old."""
        if self.name == LINK_AGE:
            return presence.age_s
        if self.kind == SILENT:
            late = presence.age_s is None or presence.age_s > SILENT_AFTER_S
            if late or not self.name:
                return None if late else presence.age_s
        elif presence.online is False:
            return None
        found = presence.values.get(self.name)
        return None if isinstance(found, float) and not isfinite(found) else found


def _bad(so: bool) -> AlertReading:
    return AlertReading.BAD if so else AlertReading.GOOD


class ConditionNames(msgspec.Struct, frozen=True):
    """What a rule may name: values of the profile with their units, and the units there are."""

    values: Mapping[str, str]
    table: UnitTable

    def unit(self, name: str) -> Unit:
        """Return the unit of a value.

        Raises:
            ValueError: There is no such value.
        """
        spelled = "s" if name == LINK_AGE else self.values.get(name)
        if spelled is None:
            known = ", ".join([*self.values, LINK_AGE])
            raise ValueError(f"{name!r} is not a value this robot reports: it reports {known}")
        return (self.table.find(spelled) if spelled else None) or NONE

    def amount(self, name: str, said: str) -> float:
        """Return an amount in the unit of a value.

        Raises:
            ValueError: It is none, or not of that kind.
        """
        own = self.unit(name)
        given = _amount(said)
        if given is None:
            raise ValueError(f"{said!r} is not a number with a unit")
        number, spelled = given
        if not spelled:
            if own.dimension and own.symbol:
                raise ValueError(f"{said!r} needs a unit, as {name} is in {own.symbol}")
            return number
        unit = self.table.find(spelled)
        if unit is None:
            raise ValueError(f"{spelled!r} is not a unit ROSIC knows")
        if unit.dimension != own.dimension:
            raise ValueError(
                f"{spelled!r} is no unit of {name}, which is in {own.symbol or 'none'}"
            )
        return float(f"{own.from_si(unit.to_si(number)):.12g}")


def _amount(said: str) -> tuple[float, str] | None:
    found = _AMOUNT.fullmatch(said.strip())
    return None if found is None else (float(found["number"]), found["unit"] or "")


def seconds(said: str, table: UnitTable) -> float:
    """Return a length of time.

    Raises:
        ValueError: It is none.
    """
    given = _amount(said)
    unit = None if given is None else table.find(given[1])
    if given is None or unit is None or unit.dimension != "time":
        raise ValueError(f"{said!r} is not a length of time, such as 10 s or 2 min")
    return given[0] * unit.factor


def compile_condition(when: str, clear: str, names: ConditionNames) -> Condition:
    """Read when a rule is bad, and when it is over.

    Raises:
        ValueError: What is wrong with it, as a sentence without its stop.
    """
    bad = _read(when.strip(), names)
    if bad.kind != "bounds":
        if clear:
            raise ValueError(f"clear has no place beside {when!r}: it is over when it is not so")
        return bad
    if not clear:
        return msgspec.structs.replace(bad, clear=_beyond(bad))
    over = _read(clear.strip(), names, wanted=True)
    if over.kind != "bounds" or over.name != bad.name:
        raise ValueError(f"clear must compare {bad.name}, as when does")
    _check_apart(bad.fine, over.fine)
    return msgspec.structs.replace(bad, clear=over.fine)


def _read(said: str, names: ConditionNames, *, wanted: bool = False) -> Condition:
    """Read one condition; ``wanted`` says that it describes what is good."""
    if (found := _COMPARED.fullmatch(said)) is not None:
        name, sign = found["name"], found["sign"]
        limit = names.amount(name, found["amount"])
        below, strict = sign.startswith("<"), sign in {"<", ">"}
        # What is bad below a limit is fine from there on; what is good below it ends there.
        low, high = (None, limit) if below is wanted else (limit, None)
        fine = ConditionBounds(low, high, strict if wanted else not strict)
        return Condition(name=name, fine=fine, unit=_shown(names, name))
    if (found := _RANGE.fullmatch(said)) is not None:
        if (found["word"] == "within") is not wanted:
            raise ValueError("when says outside, clear says within")
        name = found["name"]
        given = _amount(found["high"])
        spelled = given[1] if given is not None else ""
        low = names.amount(name, f"{found['low']} {spelled}".strip())
        high = names.amount(name, found["high"])
        if low >= high:
            raise ValueError(f"{said!r} is no range: the first number must be the smaller")
        return Condition(name=name, fine=ConditionBounds(low, high), unit=_shown(names, name))
    if (found := _WORD.fullmatch(said)) is not None:
        names.unit(found["name"])
        return Condition(name=found["name"], kind="word", word=found["word"].strip().casefold())
    return _alone(said, names)


def _alone(said: str, names: ConditionNames) -> Condition:
    if said in {OFFLINE, SILENT}:
        return Condition(name="", kind=said)
    if said == DEVIATES:
        names.unit(DEVIATION)
        return Condition(name=DEVIATION, kind=DEVIATES)
    found = _ALONE.fullmatch(said)
    if found is not None and found["silent"]:
        names.unit(found["name"])
        return Condition(name=found["name"], kind=SILENT, unit=_shown(names, found["name"]))
    raise ValueError(
        f"{said!r} is no condition: write battery < 20 %, x outside 1 to 2 m, mode is manual, "
        "link_age > 5 s, deviates, offline or silent"
    )


def _shown(names: ConditionNames, name: str) -> str:
    return "s" if name == LINK_AGE else names.values[name]


def _beyond(bad: Condition) -> ConditionBounds:
    """Return where an alarm is over if its rule does not say.

    Raises:
        ValueError: A share of nothing is nothing: the rule has to say it.
    """
    low, high = bad.fine.low, bad.fine.high
    if low is not None and high is not None:
        margin = (high - low) * BEYOND
        return ConditionBounds(low + margin, high - margin)
    margin = abs(low if low is not None else high or 0.0) * BEYOND
    if not margin:
        raise ValueError(f"a threshold of 0 needs a clear: when is {bad.name} good again")
    if low is not None:
        return ConditionBounds(low=low + margin)
    return ConditionBounds(high=(high or 0.0) - margin)


def _check_apart(fine: ConditionBounds, clear: ConditionBounds) -> None:
    """See that whatever clears is fine: else an alarm would be over while it is so.

    Raises:
        ValueError: It is not.
    """
    lower = fine.low is not None and (clear.low is None or clear.low < fine.low)
    upper = fine.high is not None and (clear.high is None or clear.high > fine.high)
    if lower or upper:
        raise ValueError("clear must lie on the good side of when, or an alarm would flap")
