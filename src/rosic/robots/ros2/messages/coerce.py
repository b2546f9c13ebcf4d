"""One value for one field: exact type, finite, in range, not too long. Nothing is guessed.

rclpy itself lets a whole number into a float field as 5e-324, wraps ``Int32(2**40)`` and takes
strings for numbers, all without a word. A robot would act on it.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Mapping
from math import isfinite
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject


# ---- text ----

# Words from a chat, made fit for a ROS string.

MAX_TEXT_BYTES = 4096

_REPLACEMENT = "\N{REPLACEMENT CHARACTER}"
# Marks that turn the reading direction: invisible, and able to make one text look like another.
_BIDI = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")


def clean_text(text: str, *, max_bytes: int = MAX_TEXT_BYTES) -> str:
    """Return ``text`` as a robot may receive it, at most ``max_bytes`` long in UTF-8.

    A lone surrogate, which rclpy cannot encode, becomes U+FFFD; control characters become spaces,
    except the newline; marks that turn the reading direction go. A cut falls between characters.
    """
    kept = "".join(map(_clean_character, text[:max_bytes]))
    return kept.encode("utf-8")[:max_bytes].decode("utf-8", "ignore")


def _clean_character(character: str) -> str:
    if character.isprintable() or character == "\n":
        return character
    if character in _BIDI:
        return ""
    category = unicodedata.category(character)
    if category == "Cs":
        return _REPLACEMENT
    return " " if category in {"Cc", "Zl", "Zp"} else character


# ---- coerce ----

MAX_ITEMS = 65_536
MAX_STRING_BYTES = 65_536

_MAX_FLOAT32 = 3.4028234663852886e38
_MAX_BYTE = 255

Coerce: TypeAlias = Callable[[object], object]


class CoercionError(Exception):
    """A value does not fit. Grows a path on its way out of nested messages.

    Attributes:
        reason: What is wrong, to follow the path: ``must be a number, not text``.
        path: Where, as far as is known.
    """

    def __init__(self, reason: str, path: str = "") -> None:
        super().__init__(reason)
        self.reason = reason
        self.path = path

    def under(self, name: str) -> CoercionError:
        """Return the same fault as seen from one level up."""
        return CoercionError(self.reason, f"{name}.{self.path}" if self.path else name)


def kind_of(value: object) -> str:
    """Say in a word what was given."""
    if isinstance(value, Mapping):
        return "a set of fields"
    names = {
        bool: "yes or no",
        int: "a whole number",
        float: "a number",
        str: "text",
        bytes: "bytes",
        type(None): "nothing",
    }
    return names.get(type(value), f"a {type(value).__name__}")


def to_float64(value: object) -> float:
    """Take a finite number; a whole number only where a float can hold it exactly."""
    if type(value) is int:
        value = _exact(value)
    if type(value) is not float:
        raise CoercionError(f"must be a number, not {kind_of(value)}")
    if not isfinite(value):
        raise CoercionError("must be a finite number")
    return value


def to_float32(value: object) -> float:
    """Take a finite number that is still finite in single precision."""
    number = to_float64(value)
    if not -_MAX_FLOAT32 <= number <= _MAX_FLOAT32:
        raise CoercionError("is too large for single precision")
    return number


def to_boolean(value: object) -> bool:
    """Take True or False; not 1, not "yes"."""
    if type(value) is not bool:
        raise CoercionError(f"must be yes or no, not {kind_of(value)}")
    return value


def to_octet(value: object) -> bytes:
    """Take one byte, as a number or as bytes of length 1. ROS keeps it as the latter."""
    if type(value) is bytes and len(value) == 1:
        return value
    if type(value) is int and 0 <= value <= _MAX_BYTE:
        return bytes([value])
    raise CoercionError("must be one byte")


def to_character(value: object) -> str:
    """Take one character of the first 256."""
    if type(value) is str and len(value) == 1 and ord(value) <= _MAX_BYTE:
        return value
    raise CoercionError("must be one character")


def integer(low: int, high: int) -> Coerce:
    """Make the check for a whole number in [low, high]."""

    def to_integer(value: object) -> int:
        if type(value) is not int:
            raise CoercionError(f"must be a whole number, not {kind_of(value)}")
        if not low <= value <= high:
            raise CoercionError(f"must be between {low} and {high}")
        return value

    return to_integer


def string(max_bytes: int | None) -> Coerce:
    """Make the check for a string of so many bytes in UTF-8, or of the house's limit."""
    limit = MAX_STRING_BYTES if max_bytes is None else min(max_bytes, MAX_STRING_BYTES)

    def to_string(value: object) -> str:
        if type(value) is not str:
            raise CoercionError(f"must be text, not {kind_of(value)}")
        if "\0" in value:  # C would end the string here
            raise CoercionError("holds a null character")
        try:
            length = len(value.encode("utf-8"))
        except UnicodeEncodeError:
            raise CoercionError("holds a lone surrogate") from None
        if length > limit:
            raise CoercionError(f"is longer than {limit} bytes")
        return value

    return to_string


def sequence(item: Coerce, shortest: int, longest: int) -> Coerce:
    """Make the check for a list whose entries pass ``item``; bytes count as a list of numbers."""
    most = min(longest, MAX_ITEMS)

    def to_list(value: object) -> list[object]:
        if not isinstance(value, (list, tuple, bytes, bytearray)):
            raise CoercionError(f"must be a list, not {kind_of(value)}")
        if not shortest <= len(value) <= most:
            wanted = f"{shortest}" if shortest == most else f"at most {most}"
            raise CoercionError(f"must have {wanted} entries, not {len(value)}")
        items: list[object] = []
        for index, entry in enumerate(value):
            try:
                items.append(item(entry))
            except CoercionError as misfit:
                raise misfit.under(str(index)) from None
        return items

    return to_list


def _exact(value: int) -> float:
    try:
        number = float(value)
    except OverflowError:
        raise CoercionError("is too large") from None
    if int(number) != value:
        raise CoercionError("is too large to be exact")
    return number


_BASIC: dict[str, Coerce] = {
    "float": to_float32,
    "double": to_float64,
    "long double": to_float64,
    "boolean": to_boolean,
    "octet": to_octet,
    "char": to_character,
    "wchar": to_character,
} | {
    f"{sign}int{bits}": integer(
        0 if sign else -(2 ** (bits - 1)), 2**bits - 1 if sign else 2 ** (bits - 1) - 1
    )
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
}


def basic(slot: RosObject) -> Coerce:
    """Return the check for a field that holds one plain value.

    Args:
        slot: Its entry in the message's ``SLOT_TYPES``.
    """
    name = getattr(slot, "typename", None)
    if name is not None:
        return _BASIC[name]
    return string(getattr(slot, "maximum_size", None))
