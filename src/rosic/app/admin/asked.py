"""What a command may ask, of a running gateway or of the data."""

from __future__ import annotations

import enum
from typing import Annotated

import msgspec

NOTHING = msgspec.Raw(b"null")


class Verb(enum.Enum):
    """What may be asked."""

    STATUS = "status"
    STOP = "stop"
    RESUME = "resume"
    PEOPLE = "people"
    REVOKE = "revoke"
    INVITE = "invite"
    KEYS = "keys"
    ROTATE = "rotate-key"
    TAKE_KEY = "revoke-key"
    LOCK = "lock"
    UNLOCK = "unlock"
    EXPLAIN = "explain"
    SECURITY = "security"
    WHO = "who"
    TAKEN = "taken"
    BOOK = "book"
    CLOCK = "clock"
    CONTAINERS = "containers"
    CONTAINER = "container"
    CONTENT = "container-content"
    LIMIT = "limit-container"
    ERASE = "erase-container"
    ADD_ROBOT = "add-robot"
    HISTORY = "history"


class Form(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How an answer is to be written.

    Attributes:
        json: For programs, with ids and times of UTC.
    """

    json: bool = False


AS_JSON = msgspec.Raw(msgspec.json.encode(Form(json=True)))
"""The body of a request whose answers are for programs."""


class Ask(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """One request; one connection carries one.

    Attributes:
        names: Robots, or a person; none means all.
        body: What else a verb asks for, as its own struct.
    """

    verb: Verb
    names: Annotated[tuple[str, ...], msgspec.Meta(max_length=256)] = ()
    body: msgspec.Raw = NOTHING

    @property
    def wants_json(self) -> bool:
        """Whether the answers are for programs."""
        try:
            form = msgspec.json.decode(self.body, type=Form | None)
        except msgspec.MsgspecError:
            return False
        return form is not None and form.json
