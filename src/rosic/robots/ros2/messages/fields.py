"""Whole messages as nested fields and back, as programs speak of them in JSON and CBOR."""

from __future__ import annotations

from array import array
from base64 import b64decode
from binascii import Error as Base64Error
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias

from rosic.robots.ros2.errors import BadValue
from rosic.robots.ros2.messages.encode import nested_class, slots

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.robots.ros2.client.rclpy_import import RosObject

    Read: TypeAlias = Callable[[RosObject], Any]

_BYTES = frozenset({"uint8", "octet"})


@cache
def fields_of(cls: RosObject) -> Read:
    """Return what turns messages of a class into their fields; made once.

    Lists of numbers stay packed, as ``array.array``; bytes become ``bytes``.
    """
    readers = tuple((name, _reader(slot)) for name, slot in slots(cls).items())

    def read(message: RosObject) -> dict[str, Any]:
        return {
            name: getattr(message, name) if reader is None else reader(getattr(message, name))
            for name, reader in readers
        }

    return read


def _reader(slot: RosObject) -> Read | None:
    """Return what reads one field; None: it is taken as it is."""
    nested = nested_class(slot)
    if nested is not None:
        return fields_of(nested)
    item = getattr(slot, "value_type", None)
    if item is None:
        return _octet if getattr(slot, "typename", "") == "octet" else None
    inner = nested_class(item)
    if inner is not None:
        each = fields_of(inner)
        return lambda values: [each(value) for value in values]
    return _bytes if getattr(item, "typename", "") in _BYTES else _packed


def _octet(value: bytes) -> int:
    return value[0]


def _bytes(value: RosObject) -> bytes:
    if isinstance(value, list):  # octets are kept one by one
        return b"".join(value)
    return bytes(value.tobytes())


def _packed(value: RosObject) -> Any:  # noqa: ANN401 - what it is depends on the type
    if isinstance(value, array | list):
        return value
    if hasattr(value, "dtype"):  # a list of a fixed length
        return array(value.dtype.char, value.tobytes())
    return list(value)


@cache
def holds_bytes(cls: RosObject) -> Mapping[str, RosObject]:
    """Return the fields of a class that hold bytes, or messages that do: their classes, or None."""
    found: dict[str, RosObject] = {}
    for name, slot in slots(cls).items():
        item = getattr(slot, "value_type", None)
        nested = nested_class(slot) or (nested_class(item) if item is not None else None)
        if nested is not None:
            if holds_bytes(nested):
                found[name] = nested
        elif item is not None and getattr(item, "typename", "") in _BYTES:
            found[name] = None
    return found


def unpacked(cls: RosObject, values: Any) -> Any:  # noqa: ANN401 - what came from outside
    """Return values with base64 text in the place of bytes read.

    Raises:
        BadValue: It is none.
    """
    inside = holds_bytes(cls)
    if not inside or not isinstance(values, dict):
        return values
    read = dict(values)
    for name, nested in inside.items():
        value = values.get(name)
        if nested is None and isinstance(value, str):
            read[name] = _decoded(name, value)
        elif isinstance(value, list) and nested is not None:
            read[name] = [unpacked(nested, one) for one in value]
        elif nested is not None and value is not None:
            read[name] = unpacked(nested, value)
    return read


def _decoded(name: str, text: str) -> bytes:
    try:
        return b64decode(text, validate=True)
    except (Base64Error, ValueError):
        raise BadValue(f"{name} is no base64 text.") from None
