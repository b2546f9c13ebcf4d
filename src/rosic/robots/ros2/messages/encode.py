"""Plain values into a ROS message, every field checked."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping
from functools import cache
from typing import TYPE_CHECKING, TypeAlias

from rosic.robots.ros2.errors import BadValue
from rosic.robots.ros2.messages.coerce import (
    MAX_ITEMS,
    Coerce,
    CoercionError,
    basic,
    kind_of,
    sequence,
)
from rosic.robots.ros2.messages.names import did_you_mean

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject

# Names of fields, dotted where they lie deeper: {"linear.x": 0.2}, or the same nested.
Values: TypeAlias = Mapping[str, object]

_SHOWN = 40


def to_message(cls: RosObject, values: Values) -> RosObject:
    """Build a message of class ``cls``; what is not named keeps the type's own default.

    Args:
        cls: A message class, or the ``Request`` of a service, or the ``Goal`` of an action.
        values: Numbers, text, lists and mappings. A whole number may stand where a float can hold
            it exactly; nothing else is converted.

    Raises:
        BadValue: A field is unknown or a value does not fit. The sentence names the field.
    """
    try:
        return record(cls).build(values)
    except CoercionError as misfit:
        sentence = f"{type_of(cls)}: {misfit.path or 'it'} {misfit.reason}"
        raise BadValue(sentence if sentence[-1] in ".?" else f"{sentence}.") from None


def type_of(cls: RosObject) -> str:
    """Return the name that ROS gives to a message class: ``geometry_msgs/msg/Twist``."""
    package, kind, *_ = cls.__module__.split(".")
    return f"{package}/{kind}/{cls.__name__}"


def slots(cls: RosObject) -> dict[str, RosObject]:
    """Return the fields of a message class with the description of their types, in order."""
    return dict(zip(cls.get_fields_and_field_types(), cls.SLOT_TYPES, strict=True))


def nested_class(slot: RosObject) -> RosObject | None:
    """Return the class of a field that holds a message; None for any other field."""
    if not hasattr(slot, "namespaces"):
        return None
    return getattr(importlib.import_module(".".join(slot.namespaces)), slot.name)


class MessageEncoder:
    """The checks for a whole message, by field.

    Messages inside it are filled in place: to make them anew costs more than all the checks.
    """

    def __init__(self, cls: RosObject) -> None:
        self._cls = cls
        self._plain: dict[str, Coerce] = {}
        self._inner: dict[str, MessageEncoder] = {}
        for name, slot in slots(cls).items():
            nested = nested_class(slot)
            if nested is None:
                self._plain[name] = _check(slot)
            else:
                self._inner[name] = record(nested)

    def build(self, values: object) -> RosObject:
        """Return a new message that holds ``values``.

        Raises:
            CoercionError: They do not fit.
        """
        message = self._cls()
        self.fill(message, values)
        return message

    def fill(self, message: RosObject, values: object) -> None:
        """Put ``values`` into a message of this class; what is not named stays as it is.

        Raises:
            CoercionError: They do not fit.
        """
        if not isinstance(values, Mapping):
            raise CoercionError(f"must be a set of fields, not {kind_of(values)}")
        for name, value in _nest(values).items():
            check, inner = self._plain.get(name), self._inner.get(name)
            if check is None and inner is None:
                raise _unknown(name, (*self._plain, *self._inner))
            try:
                if check is not None:
                    setattr(message, name, check(value))
                elif inner is not None:
                    inner.fill(getattr(message, name), value)
            except CoercionError as misfit:
                raise misfit.under(name) from None


@cache
def record(cls: RosObject) -> MessageEncoder:
    """Return the checks for a message class, made once."""
    return MessageEncoder(cls)


def _unknown(name: str, known: Iterable[str]) -> CoercionError:
    shown = name[:_SHOWN]
    return CoercionError(f"has no field {shown!r}; {did_you_mean(shown, known)}")


def _check(slot: RosObject) -> Coerce:
    """Return the check for one field that is no message itself, by the description of its type."""
    item = getattr(slot, "value_type", None)
    if item is None:
        return basic(slot)
    nested = nested_class(item)
    each = _check(item) if nested is None else record(nested).build
    if hasattr(slot, "size"):
        return sequence(each, slot.size, slot.size)
    return sequence(each, 0, getattr(slot, "maximum_size", MAX_ITEMS))


def _nest(values: Values) -> dict[str, object]:
    """Turn dotted names into nested ones. Naming a field twice is an error, not a race."""
    nested: dict[str, object] = {}
    for name, value in values.items():
        if type(name) is not str:
            raise CoercionError(f"has {kind_of(name)} where the name of a field belongs")
        head, dot, rest = name.partition(".")
        if not dot:
            if head in nested:
                raise CoercionError("is given twice", head)
            nested[head] = value
            continue
        inner = nested.setdefault(head, _Dotted())
        if type(inner) is not _Dotted or rest in inner:
            raise CoercionError("is given twice", head if type(inner) is not _Dotted else name)
        inner[rest] = value
    return nested


class _Dotted(dict[str, object]):
    """Fields gathered from dotted names, told apart from a mapping that was given whole."""
