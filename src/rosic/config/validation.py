"""Compares what a file says with a msgspec type, and collects every difference as a sentence.

msgspec itself stops at the first difference and knows no lines; so the structure is walked here,
and msgspec makes the objects only where nothing was found wrong.
"""

from __future__ import annotations

import re
from functools import cache
from math import isfinite
from typing import TYPE_CHECKING, Any, TypeVar, cast

import msgspec
from msgspec import inspect

from rosic.contracts.file_rules import Field, FieldForm, NumberBounds, Place, Rules, nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.config.source_map import Data, SourceMap
    from rosic.errors import ConfigurationError


Asked = TypeVar("Asked")

_KINDS: tuple[tuple[type, str], ...] = (
    (bool, "true or false"),
    (int, "a number"),
    (float, "a number"),
    (str, "a text"),
    (list, "a list"),
    (dict, "a table of keys"),
)
_WANTED: dict[type[inspect.Type], tuple[tuple[type, ...], str]] = {
    inspect.BoolType: ((bool,), "true or false"),
    inspect.IntType: ((int,), "a whole number"),
    inspect.FloatType: ((int, float), "a number"),
    inspect.StrType: ((str,), "a text"),
    inspect.EnumType: ((str,), "a word"),
    inspect.ListType: ((list,), "a list"),
    inspect.VarTupleType: ((list,), "a list"),
    inspect.DictType: ((dict,), "a table of keys"),
    inspect.StructType: ((dict,), "a table of keys"),
}


def kind_of(value: object) -> str:
    """Say in plain words what a value is."""
    return next((word for kind, word in _KINDS if isinstance(value, kind)), "a date or a time")


def label(place: Place) -> str:
    """Name a part of a file for a sentence: its key, or its key and number in a list."""
    if not place:
        return "The file"
    *above, last = place
    if isinstance(last, int) and above:
        return f"{last + 1} of '{above[-1]}'"
    return f"'{last}'"


class SourceValidator:
    """Walks through one source and collects what is wrong.

    Attributes:
        errors: In the order of the walk.
    """

    def __init__(self, source: SourceMap, rules: Rules) -> None:
        self.errors: list[ConfigurationError] = []
        self._source = source
        self._rules = rules
        self._visits: dict[type[inspect.Type], Callable[[Any, Any, Place], None]] = {
            inspect.StructType: self._struct,
            inspect.DictType: self._table,
            inspect.ListType: self._list,
            inspect.VarTupleType: self._list,
            inspect.EnumType: self._enum,
            inspect.FloatType: self._number,
        }

    def report(self, place: Place, sentence: str, hint: str = "") -> None:
        """Note one thing that is wrong."""
        self.errors.append(self._source.error(place, sentence, hint))

    def check(self, value: object, kind: inspect.Type, place: Place) -> None:
        """Compare a value with a type."""
        if isinstance(kind, inspect.AnyType):
            return
        kinds = kind.types if isinstance(kind, inspect.UnionType) else (kind,)
        # None stands for "nothing was written"; leaving the key out says that more clearly.
        fitting = [one for one in kinds if value is not None and _fits(value, one)]
        if not fitting:
            self._misfit(value, kinds, place)
            return
        visit = self._visits.get(type(fitting[0]))
        if visit is not None:
            visit(value, fitting[0], place)

    def _misfit(self, value: object, kinds: tuple[inspect.Type, ...], place: Place) -> None:
        wanted = [_WANTED[type(one)][1] for one in kinds if type(one) in _WANTED]
        # "a whole number, a number" says nothing more than "a number".
        wanted = [word for word in wanted if word != "a whole number" or "a number" not in wanted]
        if value is None:
            self.report(place, f"{label(place)} is empty.", "Give a value, or leave the key out.")
        else:
            said = " or ".join(wanted)
            hint = ""
            if isinstance(value, dict) and said == "a list":
                hint = self._source.list_hint.format(place[-1])
            self.report(place, f"{label(place)} must be {said}, not {kind_of(value)}.", hint)

    def _number(self, value: float, _: inspect.Type, place: Place) -> None:
        if not isfinite(value):
            self.report(place, f"{label(place)} must be a finite number.")

    def _enum(self, value: str, kind: inspect.EnumType, place: Place) -> None:
        words = [str(member.value) for member in kind.cls]
        if value not in words:
            self.report(
                place, f"{label(place)} must be one of {', '.join(words)}.", nearest(value, words)
            )

    def _list(
        self, value: list[Data], kind: inspect.ListType | inspect.VarTupleType, place: Place
    ) -> None:
        for index, item in enumerate(value):
            self.check(item, kind.item_type, (*place, index))

    def _table(self, value: dict[str, Data], kind: inspect.DictType, place: Place) -> None:
        for key, item in value.items():
            self.check(item, kind.value_type, (*place, key))

    def _struct(self, value: dict[str, Data], kind: inspect.StructType, place: Place) -> None:
        before = len(self.errors)
        hidden = {name for cls in kind.cls.__mro__ for c, name in self._rules.hidden if c is cls}
        hidden |= opaque_fields(kind.cls)
        fields = {f.encode_name: f for f in kind.fields if f.name not in hidden}
        for key, item in value.items():
            field = fields.get(key)
            if field is None:
                sentence = f"'{key}' is not known here."
                self.report((*place, key), sentence, nearest(key, fields))
            else:
                self._field(item, kind.cls, field, (*place, key))
        for key, field in fields.items():
            if field.required and key not in value:
                part = f"in {label(place)}" if place else "in this file"
                self.report(place, f"'{key}' is missing {part}.")
        if len(self.errors) == before:
            self._make(value, kind.cls, place)

    def _field(self, value: object, owner: type, field: inspect.Field, place: Place) -> None:
        before = len(self.errors)
        self.check(value, field.type, place)
        if len(self.errors) > before:
            return
        bounds = asked_of(owner, field.name, self._rules.bounds)
        if bounds and isinstance(value, (int, float)) and not in_bounds(value, bounds):
            self.report(
                place, f"{label(place)} must be between {bounds.least:g} and {bounds.most:g}."
            )
        form = asked_of(owner, field.name, self._rules.forms)
        if form is not None:
            self._form(cast("str | list[str] | dict[str, Data]", value), form, place)

    def _form(
        self, value: str | list[str] | dict[str, Data], form: FieldForm, place: Place
    ) -> None:
        parts: list[tuple[Place, str]]
        if isinstance(value, str):
            parts = [(place, value)]
        elif isinstance(value, list):
            parts = [((*place, index), item) for index, item in enumerate(value)]
        else:
            parts = [((*place, key), key) for key in value]
        for here, text in parts:
            if not (re.fullmatch(form.pattern, text) or (form.empty and not text)):
                self.report(here, f"{text!r} is not {form.meaning}.", form.hint)

    def _make(self, value: dict[str, Data], cls: type, place: Place) -> None:
        try:
            made: object = msgspec.convert(value, cls)
        except msgspec.ValidationError as fault:
            sentence = str(fault.__cause__ or fault)
            here = (*place, *_mentioned(sentence, value))
            self.report(here, sentence[:1].upper() + sentence[1:] + ".")
            return
        for one in reversed(cls.__mro__):  # first what is asked of every robot
            for rule in self._rules.checks.get(one, ()):
                for finding in rule(made):
                    self.report((*place, *finding.place), finding.sentence, finding.hint)


@cache
def opaque_fields(cls: type) -> frozenset[str]:
    """Return the fields of which an adapter could say what stands there, and none does."""
    return frozenset(field.name for field in msgspec.structs.fields(cls) if field.type is object)


def asked_of(owner: type, field: str, rules: Mapping[Field, Asked]) -> Asked | None:
    """Return what is asked of a field, of a class or of one that it is derived from."""
    return next((rules[one, field] for one in owner.__mro__ if (one, field) in rules), None)


def in_bounds(value: float, bounds: NumberBounds) -> bool:
    """Whether a number keeps its bounds."""
    return bounds.least <= value <= bounds.most


def _fits(value: object, kind: inspect.Type) -> bool:
    wanted, _ = _WANTED.get(type(kind), ((), ""))
    # True is an int to Python, not to a person.
    return isinstance(value, wanted) and (not isinstance(value, bool) or bool in wanted)


def _mentioned(sentence: str, table: Mapping[str, Data]) -> Place:
    """Find the part of a table that a sentence quotes, or else names."""
    for key, value in table.items():
        parts = value if isinstance(value, (list, dict)) else [value]
        if any(isinstance(part, str) and repr(part) in sentence for part in parts):
            return (key, *(p for p in parts if isinstance(value, dict) and repr(p) in sentence))
    found = {key: re.search(rf"\b{re.escape(key)}\b", sentence) for key in table}
    named = [(match.start(), key) for key, match in found.items() if match]
    return (min(named)[1],) if named else ()
