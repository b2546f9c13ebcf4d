"""Which fields of an answer look as if they told success, or the reason for a failure.

ROS has no rule for either: what is not called ``success`` is judged by nobody until a profile names
it. Pure, but for looking a type up where it is installed.
"""

from __future__ import annotations

import re
from importlib import import_module
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.robots.ros2.profile import AnswerFields

SUCCESS: Final = "success"
# What robots' own words are called: by most, by Nav2, by ros2_control.
MESSAGES: Final = ("message", "error_msg", "error_string")
REASONS: Final = (
    *("reason", "remark", "status_message", "text", "error_message", "error_text"),
    *("error_description", "description", "details", "detail", "info", "note", "comment"),
)
ABORTS: Final = frozenset({"control_msgs", "nav2_msgs"})
"""Whose action servers abort a goal that fails, whatever their result says besides."""
_INTEGER: Final = re.compile(r"u?int(?:8|16|32|64)\Z")
_CODE: Final = re.compile(
    r"(?:.*_)?(?:code|status|state|result|outcome|verdict|error|errno|reason|retval)\Z"
)
_YES: Final = re.compile(
    r"(?:is_|was_|has_)?"
    r"(?:ok|okay|succeeded|successful|done|reached|completed|finished|accepted|result|outcome)\Z"
)
_WORD: Final = re.compile(r"(?:.*_)?(?:code|status|state|result|outcome|verdict)\Z")
_TEXT: Final = re.compile(r"w?string(?:<\d+>)?\Z")


class CodeField(NamedTuple):
    """A field that looks as if it told success, and what a profile has to say of it."""

    name: str
    kind: str

    @property
    def told(self) -> str:
        """How a profile names it, as a person reads it."""
        if self.kind == "boolean":
            return f"success: {self.name}"
        meaning = "the word" if _TEXT.match(self.kind) else "the number"
        return f"success: {self.name} and good: {meaning} that means success"


def code_fields(fields: Mapping[str, str]) -> tuple[CodeField, ...]:
    """Return what looks as if it told success; nothing where ``success`` does.

    Args:
        fields: Names to types, as rclpy says them.
    """
    if fields.get(SUCCESS) == "boolean":
        return ()
    return tuple(CodeField(name, kind) for name, kind in fields.items() if _is_code(name, kind))


def _is_code(name: str, kind: str) -> bool:
    if kind == "boolean":
        return bool(_YES.match(name))
    if _INTEGER.match(kind):
        return name == SUCCESS or bool(_CODE.match(name))
    return bool(_TEXT.match(kind) and _WORD.match(name))


def reason_field(fields: Mapping[str, str]) -> str:
    """Return the field with the robot's own words that a profile has to name; else empty."""
    texts = [name for name, kind in fields.items() if _TEXT.match(kind)]
    if any(name in MESSAGES for name in texts):
        return ""
    return next((name for name in REASONS if name in texts), "")


def unjudged(binding: AnswerFields, kind: str, fields: Mapping[str, str]) -> tuple[CodeField, ...]:
    """Return what looks as if it told success, where a profile names nothing that does."""
    if binding.success not in {"", SUCCESS} or kind.partition("/")[0] in ABORTS:
        return ()
    return code_fields(fields)


def named(codes: tuple[CodeField, ...]) -> str:
    """Return what looks like a code, and how to name it in a profile, in one clause."""
    looks = " or ".join(f"{code.name} ({code.kind})" for code in codes)
    ways = "; or ".join(dict.fromkeys(code.told for code in codes))
    return f"{looks} looks like it: write {ways}"


def answered_fields(kind: str) -> Mapping[str, str] | None:
    """Return the fields of a result or a response; None where its type is not installed here."""
    package, sort, name = kind.split("/")
    part = "Result" if sort == "action" else "Response"
    try:
        cls = getattr(getattr(import_module(f"{package}.{sort}"), name), part)
    except (ImportError, AttributeError):
        return None
    fields: Mapping[str, str] = cls.get_fields_and_field_types()
    return fields
