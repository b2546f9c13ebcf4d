"""What a robot's side answers: whether it means success, in which words, with which facts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from rosic.core.i18n import joined, said
from rosic.robots.ros2.answer_fields import MESSAGES, SUCCESS, unjudged
from rosic.robots.ros2.errors import BadName
from rosic.robots.ros2.messages.coerce import clean_text
from rosic.robots.ros2.messages.decode import FieldReader, compile_path
from rosic.robots.ros2.messages.fields import fields_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.profile import AnswerFields

NOTE_BYTES = 240
_MOST_FACTS = 64
ORDERS_KEPT: Final = 8
"""Whose answers are kept; programs take them at once."""


def check_fields(cls: RosObject, fields: Mapping[str, object]) -> None:
    """Make sure that a message has the fields that a profile names.

    Raises:
        BadName: It has not.
    """
    for field in fields:
        compile_path(cls, field)


class BindingAnswer:
    """What a result or a response says of success, and in which words, if it has such fields."""

    def __init__(self, cls: RosObject, fields: AnswerFields) -> None:
        """Check the fields that the profile names.

        Raises:
            BadName: One is not there, or what it says could never mean success.
        """
        self._good, self._codes = fields.good, fields.codes
        coded = not isinstance(fields.good, bool)
        self._success = _reader(cls, fields.success, *(() if coded else (SUCCESS,)))
        if self._success is not None:
            _check_kind(self._success, self._good)
        package, told = cls.__module__.partition(".")[0], cls.get_fields_and_field_types()
        codes = unjudged(fields, package, told) if self._success is None else ()
        self._unjudged = {code.name: compile_path(cls, code.name) for code in codes}
        self._message = _reader(cls, fields.message, *MESSAGES)
        self._facts = _reader(cls, "", "fact_names"), _reader(cls, "", "fact_values")

    def succeeded(self, answer: RosObject) -> bool:
        """Tell whether it says success; one that does not speak of it means it."""
        if self._success is None:
            return True
        told = self._success(answer)
        return told == self._good and isinstance(told, bool) == isinstance(self._good, bool)

    def in_doubt(self, answer: RosObject) -> str:
        """Return what it says in fields that nobody judges, for an end that counts as success."""
        found = {name: read(answer) for name, read in self._unjudged.items()}
        told = ", ".join(
            f"{name} {note(str(value).lower() if isinstance(value, bool) else value)}"
            for name, value in found.items()
            if value != ""
        )
        if not told:
            return ""
        return said("answered {told}; whether that is success is not known", told=told)

    def words(self, answer: RosObject) -> str:
        """Return the robot's words, after its code if that means no success; may be empty."""
        told = "" if self._message is None else note(self._message(answer))
        return joined("; ", filter(None, dict.fromkeys((self._code(answer), told))))

    def _code(self, answer: RosObject) -> str:
        if self._success is None or isinstance(self._good, bool) or self.succeeded(answer):
            return ""
        code = str(self._success(answer))
        if isinstance(self._good, str):
            return note(code)
        words = self._codes.get(code, "")
        coded = said("code {code}", code=code)
        return joined(", ", (coded, note(words))) if words else coded

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


def _check_kind(reader: FieldReader, good: bool | int | str) -> None:
    """See that a field can say what means success.

    Raises:
        BadName: It is a number where yes or no is wanted, or the other way round, and so on.
    """
    path = reader.path
    if isinstance(good, str):
        if reader.shape != "text":
            raise BadName(
                f"{path} of the answer holds no word, and 'good' is one.",
                hint="Name the field of the word: success: status.",
            )
    elif not isinstance(good, bool):
        if reader.shape != "number":
            raise BadName(
                f"{path} of the answer holds no number, and 'good' is one.",
                hint="Name the field of the code: success: error_code.",
            )
    elif reader.shape == "number":
        raise BadName(
            f"{path} of the answer is a number, and nothing says which means success.",
            hint="Write it, for example good: 0.",
        )
    elif reader.shape == "text":
        raise BadName(
            f"{path} of the answer is a word, and nothing says which means success.",
            hint="Write it, for example good: SUCCEEDED.",
        )


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


class OrderAnswers:
    """What a robot's side said of its newest orders, word for word, for programs that ask for it.

    Of feedback the newest is kept.
    """

    def __init__(self) -> None:
        self._feedback: dict[int, RosObject] = {}
        self._ends: dict[int, RosObject] = {}

    def put_feedback(self, n: int, message: RosObject) -> None:
        """Take in feedback about an order, by its number."""
        _keep(self._feedback, n, message)

    def put_end(self, n: int, message: RosObject) -> None:
        """Take in the result or the response that ended an order."""
        self._feedback.pop(n, None)
        _keep(self._ends, n, message)

    def feedback(self, n: int) -> dict[str, Any] | None:
        """Return the newest feedback about an order by its fields; None: there is none."""
        return _fields(self._feedback.get(n))

    def end(self, n: int) -> dict[str, Any] | None:
        """Return what ended an order by its fields; None: nothing has come."""
        return _fields(self._ends.get(n))


def _keep(kept: dict[int, RosObject], n: int, message: RosObject) -> None:
    kept.pop(n, None)
    kept[n] = message
    if len(kept) > ORDERS_KEPT:
        del kept[next(iter(kept))]


def _fields(message: RosObject) -> dict[str, Any] | None:
    if message is None:
        return None
    cls: RosObject = type(message)
    found: dict[str, Any] = fields_of(cls)(message)
    return found
