"""What a robot's side answers: whether it means success, in which words, with which facts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.robots.ros2.errors import BadName
from rosic.robots.ros2.messages.decode import FieldReader, compile_path
from rosic.robots.ros2.messages.text import clean_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.robots.ros2.client.rclpy_import import RosObject

NOTE_BYTES = 240
_MOST_FACTS = 64
# What robots' own words are called: by most, by Nav2, by ros2_control.
MESSAGES = ("message", "error_msg", "error_string")


def check_fields(cls: RosObject, fields: Mapping[str, object]) -> None:
    """Make sure that a message has the fields that a profile names.

    Raises:
        BadName: It has not.
    """
    for field in fields:
        compile_path(cls, field)


class BindingAnswer:
    """What a result or a response says of success, and in which words, if it has such fields."""

    def __init__(self, cls: RosObject, success: str = "", message: str = "") -> None:
        self._success = _reader(cls, success, "success")
        self._message = _reader(cls, message, *MESSAGES)
        self._facts = _reader(cls, "", "fact_names"), _reader(cls, "", "fact_values")

    def succeeded(self, answer: RosObject) -> bool:
        """Tell whether it says success; one that does not speak of it means it."""
        return self._success is None or self._success(answer) is True

    def words(self, answer: RosObject) -> str:
        """Return the robot's words; inert, may be empty."""
        return "" if self._message is None else note(self._message(answer))

    def facts(self, answer: RosObject) -> dict[str, float]:
        """Return what was measured, by name."""
        names, values = self._facts
        if names is None or values is None:
            return {}
        pairs = zip(_listed(names(answer)), _listed(values(answer)), strict=False)
        return {
            note(name): float(value)
            for name, value in list(pairs)[:_MOST_FACTS]
            if isinstance(value, (int, float))
        }


def note(words: object) -> str:
    """Return a robot's words as a person may read them, on one line."""
    return " ".join(clean_text(str(words), max_bytes=NOTE_BYTES).split())


def _listed(value: object) -> list[object]:
    return value if isinstance(value, list) else []


def _reader(cls: RosObject, path: str, *usual: str) -> FieldReader | None:
    """Return the reader of a field; None when the profile does not insist and it is not there."""
    for wanted in (path,) if path not in {"", *usual} else usual:
        try:
            return compile_path(cls, wanted)
        except BadName:
            if wanted not in usual:
                raise
    return None
