"""Reading the parameters of a call, and saying what is wrong with them.

https://core.telegram.org/bots/api#making-requests: query string, urlencoded form, JSON, multipart.
Every value may be text; where the documentation says "JSON-serialized", an object or its text is
accepted.
"""

from __future__ import annotations

import enum
import hashlib
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import msgspec

from rosic.testing.telegram.refusals import bad_request
from rosic.testing.telegram.spool import DiskFile

if TYPE_CHECKING:
    from rosic.testing.telegram.state import JsonObject

WHOLE = re.compile(r"-?[0-9]{1,19}\Z")


class Kind(enum.Enum):
    """What the documentation calls the type of a parameter."""

    INTEGER = "Integer"
    TEXT = "String"
    FLAG = "Boolean"
    CHAT = "Integer or String"
    OBJECT = "object"
    ARRAY = "Array"
    FILE = "InputFile or String"


Signature = Mapping[str, Kind]


class Upload(msgspec.Struct, frozen=True, kw_only=True):
    """One file part of a multipart request.

    Attributes:
        content: Empty where it lies on a disk.
        on_disk: Where; None where it is in memory.
    """

    name: str
    content_type: str
    content: bytes = b""
    on_disk: DiskFile | None = None

    @property
    def size(self) -> int:
        """How long it is."""
        return len(self.content) if self.on_disk is None else self.on_disk.size

    @property
    def sha256(self) -> str:
        """What stands for its content."""
        if self.on_disk is not None:
            return self.on_disk.sha256
        return hashlib.sha256(self.content).hexdigest()


class Raw(msgspec.Struct, frozen=True, kw_only=True):
    """A request as it came.

    Attributes:
        values: Text from forms and queries; any JSON value from a JSON body.
        typed: Names of the values that came from a JSON body.
    """

    values: dict[str, object]
    files: dict[str, Upload]
    typed: frozenset[str] = frozenset()


class CallParameters:
    """The checked parameters of one call."""

    def __init__(self, values: dict[str, Any], files: dict[str, Upload]) -> None:
        self._values = values
        self.files = files

    def __contains__(self, name: str) -> bool:
        return name in self._values

    def text(self, name: str) -> str:
        """Return a String, "" when it is missing."""
        value: str = self._values.get(name, "")
        return value

    def integer(self, name: str, default: int = 0) -> int:
        """Return an Integer."""
        value: int = self._values.get(name, default)
        return value

    def flag(self, name: str) -> bool:
        """Return a Boolean, False when it is missing."""
        return self._values.get(name) is True

    def chat(self, name: str) -> int | str | None:
        """Return a chat id or an @name."""
        value: int | str | None = self._values.get(name)
        return value

    def object(self, name: str) -> JsonObject | None:
        """Return a JSON object."""
        value: JsonObject | None = self._values.get(name)
        return value

    def array(self, name: str) -> list[Any] | None:
        """Return a JSON array."""
        value: list[Any] | None = self._values.get(name)
        return value

    def file(self, name: str) -> Upload | str | None:
        """Return an uploaded file, or the text that names one."""
        if name in self.files:
            return self.files[name]
        value: str | None = self._values.get(name)
        if value is not None and value.startswith("attach://"):
            return self.files.get(value.removeprefix("attach://"))
        return value

    def shown(self) -> JsonObject:
        """Return what the record keeps: values, and name and size of files."""
        files = {n: f"<{f.name}, {f.size} bytes>" for n, f in self.files.items()}
        return {**self._values, **files}


def check(signature: Signature, raw: Raw) -> tuple[CallParameters, list[str]]:
    """Convert every parameter as Telegram does.

    Returns:
        The arguments, and one sentence for each thing a correct client does not send. Telegram
        forgives those (it ignores what it does not know, and reads "x" as the number 0), and so the
        call goes on.

    Raises:
        ApiError: 400, for JSON that cannot be parsed.
    """
    values: dict[str, Any] = {}
    problems: list[str] = []
    for name, value in raw.values.items():
        kind = signature.get(name)
        if value is None:
            continue
        if kind is None:
            problems.append(f"unknown parameter {name!r}")
            continue
        values[name], wrong = convert(name, kind, value, typed=name in raw.typed)
        if wrong:
            problems.append(f"parameter {name!r} should be {kind.value}, got {value!r:.80}")
    within = [
        part for value in values.values() if isinstance(value, dict) for part in value.values()
    ]
    attached = {value for value in (*values.values(), *within) if isinstance(value, str)}
    problems += [
        f"unknown file {name!r}"
        for name in raw.files
        if signature.get(name) is not Kind.FILE and f"attach://{name}" not in attached
    ]
    return CallParameters(values, raw.files), problems


def convert(name: str, kind: Kind, value: object, *, typed: bool) -> tuple[Any, bool]:
    """Return the value as Telegram reads it, and whether a correct client would have sent it so."""
    match kind:
        case Kind.INTEGER:
            return _integer(value, typed=typed)
        case Kind.FLAG:
            return _flag(value, typed=typed)
        case Kind.CHAT:
            return _chat(value)
        case Kind.TEXT | Kind.FILE:
            return (value, False) if isinstance(value, str) else (_serial(value), True)
        case Kind.OBJECT:
            return _json(name, value, dict)
        case Kind.ARRAY:
            return _json(name, value, list)


def _integer(value: object, *, typed: bool) -> tuple[int, bool]:
    if isinstance(value, int) and not isinstance(value, bool):
        return value, False
    if isinstance(value, str) and WHOLE.match(value):
        return int(value), typed
    return 0, True


def _flag(value: object, *, typed: bool) -> tuple[bool, bool]:
    if isinstance(value, bool):
        return value, False
    word = str(value).lower()
    return word in {"true", "yes", "1"}, typed or word not in {"true", "false", "1", "0"}


def _chat(value: object) -> tuple[int | str, bool]:
    if isinstance(value, int) and not isinstance(value, bool):
        return value, False
    if isinstance(value, str):
        return (int(value) if WHOLE.match(value) else value), False
    return str(value), True


def _json(name: str, value: object, expected: type) -> tuple[object, bool]:
    if isinstance(value, str):
        try:
            value = msgspec.json.decode(value)
        except (msgspec.DecodeError, UnicodeEncodeError):
            raise bad_request(f"can't parse {LABELS.get(name, name)} JSON object") from None
    if not isinstance(value, expected):
        raise bad_request(f"can't parse {LABELS.get(name, name)} JSON object")
    return value, False


def _serial(value: object) -> str:
    return msgspec.json.encode(value).decode()


LABELS = {
    "reply_markup": "reply keyboard markup",
    "reply_parameters": "reply parameters",
    "scope": "BotCommandScope",
}
"""How the published server names some parameters in its sentences."""
