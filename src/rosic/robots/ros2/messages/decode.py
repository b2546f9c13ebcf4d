"""Plain values out of a ROS message, at a path such as ``pose.pose.position.x``."""

from __future__ import annotations

import re
from array import array
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Literal, TypeAlias

from rosic.robots.ros2.errors import BadName, BadValue
from rosic.robots.ros2.messages.encode import nested_class, slots, type_of
from rosic.robots.ros2.messages.names import did_you_mean

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject

Plain: TypeAlias = "bool | int | float | str | bytes | list[Plain] | dict[str, Plain]"
Shape: TypeAlias = Literal["number", "truth", "text", "bytes", "list", "record"]

_MAX_STEPS = 16
_STEP = re.compile(r"[a-z][a-z0-9_]*|[0-9]{1,5}")
_INDEXED = re.compile(r"\[([0-9]{1,5})\]")


@dataclass(frozen=True)
class FieldReader:
    """Reads one place of one type of message.

    Attributes:
        path: As written.
        shape: What is there. A list of numbers is a list; ``velocity.0`` is a number.
    """

    path: str
    shape: Shape
    _steps: tuple[str | int, ...]

    def __call__(self, message: RosObject) -> Plain:
        """Return what is there. A number may be NaN: many robots say so what they do not measure.

        Raises:
            BadValue: The message is shorter than the path, or of another type.
        """
        found = message
        for step in self._steps:
            try:
                found = found[step] if isinstance(step, int) else getattr(found, step)
            except IndexError:
                raise BadValue(
                    f"{self.path} is not there: the list has {len(found)} entries."
                ) from None
            except (AttributeError, TypeError):
                raise BadValue(
                    f"{self.path} is not there: the message is of another type."
                ) from None
        return plain(found)


def compile_path(cls: RosObject, path: str) -> FieldReader:
    """Check a path against a type, once, before anything runs.

    Args:
        cls: A message class, a ``Response``, a ``Result`` or a ``Feedback``.
        path: Fields joined by dots; an entry of a list as ``.0`` or ``[0]``; empty for the whole.

    Raises:
        BadName: The type has no such place. The sentence offers the nearest field.
    """
    return _compile(cls, path)


@lru_cache(maxsize=4096)
def _compile(cls: RosObject, path: str) -> FieldReader:
    steps: list[str | int] = []
    here: RosObject = _Whole(cls)
    for step in _split(path):
        if isinstance(here, _Whole):
            here = _enter(here.cls, step, path)
            steps.append(step)
        else:
            steps.append(_index(here, step, path))
            here = here.value_type
        nested = nested_class(here)
        here = here if nested is None else _Whole(nested)
    return FieldReader(path, _shape(here), tuple(steps))


def plain(value: RosObject) -> Plain:
    """Turn whatever a message holds into plain values; a list of bytes becomes bytes."""
    if isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, bytes):  # an octet is kept as bytes of length 1
        return value[0]
    if isinstance(value, (array, list, tuple)) or hasattr(value, "tolist"):
        return _plain_list(value)
    return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}


class _Whole:
    """Stands for a message, where other steps stand for the description of a field."""

    def __init__(self, cls: RosObject) -> None:
        self.cls = cls


def _split(path: str) -> list[str]:
    if not path:
        return []
    steps = _INDEXED.sub(r".\1", path).split(".")
    if len(steps) > _MAX_STEPS or not all(map(_STEP.fullmatch, steps)):
        raise BadName(
            f"{path[:80]!r} is not a path to a field; one looks like pose.pose.position.x."
        )
    return steps


def _enter(cls: RosObject, step: str, path: str) -> RosObject:
    fields = slots(cls)
    if step not in fields:
        raise BadName(f"{path}: {type_of(cls)} has no {step}; {did_you_mean(step, fields)}")
    return fields[step]


def _index(slot: RosObject, step: str, path: str) -> int:
    if not hasattr(slot, "value_type"):
        raise BadName(f"{path}: nothing lies below a plain value, so {step} is too much.")
    if not step.isdigit():
        raise BadName(f"{path}: {step} stands below a list, which needs an entry first, such as 0.")
    size = getattr(slot, "size", getattr(slot, "maximum_size", None))
    if size is not None and int(step) >= size:
        raise BadName(f"{path}: the list has only {size} entries, counted from 0.")
    return int(step)


def _shape(here: RosObject) -> Shape:
    if isinstance(here, _Whole):
        return "record"
    item = getattr(here, "value_type", None)
    if item is not None:
        return "bytes" if getattr(item, "typename", "") in {"uint8", "octet"} else "list"
    name = getattr(here, "typename", None)
    if name == "boolean":
        return "truth"
    return "text" if name in {None, "char", "wchar"} else "number"


def _plain_list(value: RosObject) -> Plain:
    if hasattr(value, "tolist"):  # a list of numbers: an array, or a numpy array when it is fixed
        if (value.typecode if isinstance(value, array) else value.dtype.char) == "B":
            return bytes(value.tobytes())
        return list(value.tolist())
    if value and all(isinstance(item, bytes) for item in value):
        return b"".join(value)
    return [plain(item) for item in value]
