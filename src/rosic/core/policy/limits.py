"""Limits on arguments: ``speed <= 0.2 m/s``, ``force <= 20 N``, ``kuka1:grasp force <= 20 N``.

A limit is read once, fitted to every skill it touches when the rights are drawn up (units are
converted then), and is two comparisons in SI when an order comes.
"""

from __future__ import annotations

import re
from math import inf, isfinite
from typing import TYPE_CHECKING, TypeAlias

import msgspec

from rosic.core.i18n import figure, joined, said
from rosic.core.language.common_names import known_name
from rosic.core.language.numbers import NONE
from rosic.core.policy.scope import Scope
from rosic.core.units import bound_in_words, measured, shown_unit

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.core.language.numbers import UnitTable
    from rosic.core.robot.skill import Argument, Parameter, Skill

Convert: TypeAlias = "Callable[[float, str, Parameter], float]"
"""Number, unit as written (empty: the parameter's own), parameter; returns the number in SI.
Raises ValueError with a sentence if the unit does not fit."""

LONGEST_LIMIT = 120

_LIMIT = re.compile(
    r"(?:(?P<scope>[a-z0-9_*?-]+:[a-z0-9_*?-]+)\s+)?(?P<parameter>[a-z][a-z0-9_]*)\s*"
    r"(?P<sign><=|>=|≤|≥|=|<|>)\s*"
    r"(?P<number>[+-]?(?:\d{1,18}(?:\.\d{0,18})?|\.\d{1,18})(?:[eE][+-]?\d{1,3})?)(?P<unit>.*)\Z"
)
_WORDS = re.compile(r"(\s+|[<>]=?|[≤≥=])")
_QUANTITY = re.compile(
    r"(?P<number>[+-]?(?:\d{1,18}(?:\.\d{0,18})?|\.\d{1,18})(?:[eE][+-]?\d{1,3})?)\s*(?P<unit>\D*)"
)
_JOINT = said("and")
_AT_LEAST = frozenset({">=", "≥"})
_EXACT = "="
_HOW = said("write for example speed <= 0.2 m/s")
# 35 cm is 0.35000000000000003 m: whoever asks for exactly the bound gets it.
_SLACK = 1e-9


class LimitRule(msgspec.Struct, frozen=True, gc=False):
    """One limit as it was written.

    Attributes:
        scope: It touches only these skills; None: all that its role or grant gives.
        low, high: The number on the side that was limited, else None. In ``unit``.
        unit: As written; empty means the parameter's own.
        said: The text.
    """

    scope: Scope | None
    parameter: str
    low: float | None
    high: float | None
    unit: str
    said: str


class Limit(msgspec.Struct, frozen=True, gc=False):
    """Bounds of one parameter of one skill, inclusive, SI.

    Attributes:
        said: The text that made it.
    """

    parameter: str
    min: float
    max: float
    said: str


class LimitMismatch(ValueError):
    """A limit does not fit a skill; nobody may use the skill under it. Says why."""


def parse_limit(text: str) -> LimitRule:
    """Read a limit.

    Raises:
        ValueError: It is none; one clear sentence.
    """
    limit = " ".join(text.split())
    found = _LIMIT.match(limit) if len(limit) <= LONGEST_LIMIT else None
    if found is None:
        none = said("{limit!r} is not a limit: {how}", limit=limit[:LONGEST_LIMIT], how=_HOW)
        raise ValueError(none)
    sign = found["sign"]
    if sign in {"<", ">"}:
        raise ValueError(
            said(
                "{limit!r} leaves open whether the bound itself is allowed: {how}",
                limit=limit,
                how=_HOW,
            )
        )
    number = float(found["number"])
    if not isfinite(number):
        raise ValueError(said("{limit!r} has a number that is too large", limit=limit))
    return LimitRule(
        scope=Scope.parse(found["scope"]) if found["scope"] else None,
        parameter=found["parameter"],
        low=number if sign in _AT_LEAST or sign == _EXACT else None,
        high=number if sign not in _AT_LEAST else None,
        unit=found["unit"].strip(),
        said=limit,
    )


def unit_converter(units: UnitTable) -> Convert:
    """Return the conversion that a units table gives."""

    def convert(number: float, unit: str, parameter: Parameter) -> float:
        own = units.find(parameter.unit) if parameter.unit else NONE
        if own is None:
            raise ValueError(said("its unit {unit!r} is unknown", unit=parameter.unit))
        meant = units.find(unit) if unit else own
        if meant is None:
            raise ValueError(said("{unit!r} is no unit that ROSIC knows", unit=unit))
        if meant.dimension != own.dimension:
            raise ValueError(
                said("{unit!r} does not fit, it is given in {own}", unit=unit, own=parameter.unit)
                if parameter.unit
                else said("{unit!r} does not fit, it has no unit", unit=unit)
            )
        return meant.to_si(number)

    return convert


def fit_limits(
    rules: Iterable[LimitRule], name: str, skill: Skill, convert: Convert
) -> tuple[Limit, ...]:
    """Work out what limits mean for one skill: at most one for each of its parameters.

    A limit on a parameter that the skill does not have says nothing about the skill. An upper
    limit alone on a parameter that may be negative bounds it on both sides: ``speed <= 0.2 m/s``
    does not allow 1 m/s backwards.

    Raises:
        LimitMismatch: A unit does not fit, the parameter is a word, or nothing is left to ask for.
    """
    by_parameter: dict[str, list[LimitRule]] = {}
    for rule in rules:
        if rule.parameter in skill.parameters:
            by_parameter.setdefault(rule.parameter, []).append(rule)
    return tuple(
        _fit(name, parameter, skill.parameters[parameter], of_one, convert)
        for parameter, of_one in by_parameter.items()
    )


def _fit(
    skill: str, name: str, parameter: Parameter, rules: list[LimitRule], convert: Convert
) -> Limit:
    limits = " and ".join(rule.said for rule in rules)
    own_min, own_max = parameter.min, parameter.max
    if own_min is None or own_max is None:
        raise LimitMismatch(
            said(
                "{name} of {skill} is a word, so {limits!r} cannot limit it",
                name=name,
                skill=skill,
                limits=limits,
            )
        )
    low, high = -inf, inf
    try:
        for rule in rules:
            if rule.low is not None:
                low = max(low, convert(rule.low, rule.unit, parameter))
            if rule.high is not None:
                high = min(high, convert(rule.high, rule.unit, parameter))
        floor, ceiling = convert(own_min, "", parameter), convert(own_max, "", parameter)
    except ValueError as fault:
        why = fault.args[0]
        raise LimitMismatch(
            said(
                "{limits!r} does not fit {name} of {skill}: {why}",
                limits=limits,
                name=name,
                skill=skill,
                why=why,
            )
        ) from None
    if low == -inf and floor < 0 <= high:
        low = -high
    low, high = _with_slack(low, -1), _with_slack(high, 1)
    if max(low, floor) > min(high, ceiling):
        raise LimitMismatch(
            said(
                "{limits!r} leaves nothing of {name} of {skill}, which goes from {least} to {most}",
                limits=limits,
                name=name,
                skill=skill,
                least=bound_in_words(own_min, parameter.unit, upper=False, with_unit=False),
                most=bound_in_words(own_max, parameter.unit, upper=True),
            )
        )
    return Limit(name, low, high, limits)


def _with_slack(bound: float, side: int) -> float:
    return bound + side * abs(bound) * _SLACK if isfinite(bound) else bound


def limit_in_words(said_limit: str) -> str:
    """Return a limit as people read it: ``speed <= 0.2 m/s``, in their language and units."""
    words = _WORDS.split(said_limit)
    shown: list[str] = []
    while words:
        word = words.pop(0)
        if not word.lstrip("+-.")[:1].isdigit():
            shown.append(_word(word))
        elif len(words) > 1 and words[0].isspace() and words[1] != "and":
            shown.append(quantity_in_words(f"{word} {words[1]}"))
            del words[:2]
        else:
            shown.append(quantity_in_words(word))
    return joined("", shown)


def quantity_in_words(text: str) -> str:
    """Return a number and its unit, as they were written, as people read them: ``0.2 m/s``."""
    found = _QUANTITY.fullmatch(text.strip())
    if found is None:
        return figure(text)
    return measured(text.strip(), float(found["number"]), found["unit"])


def _word(word: str) -> str:
    return _JOINT if word == "and" else known_name(shown_unit(word))


def broken_limit(limits: tuple[Limit, ...], arguments: Mapping[str, Argument]) -> Limit | None:
    """Return the first limit that the arguments break, or None.

    A limited parameter that is missing, is no number or is not finite breaks its limit.
    """
    for limit in limits:
        value = arguments.get(limit.parameter)
        if not isinstance(value, int | float) or not limit.min <= value <= limit.max:
            return limit
    return None
