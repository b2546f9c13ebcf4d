"""What clients of rosbridge say, and what they are told, in JSON.

See https://github.com/RobotWebTools/rosbridge_suite/blob/ros2/ROSBRIDGE_PROTOCOL.md.
"""

from __future__ import annotations

import re
from array import array
from typing import TYPE_CHECKING, Annotated, Any, Final, TypeAlias

import msgspec

from rosic.core.i18n import plain

if TYPE_CHECKING:
    from collections.abc import Callable

NAME_MOST: Final = 256
MESSAGE_BYTES: Final = 1 << 20
PARTS_AT_MOST: Final = 8_000
"""Lists, objects and fields in one message: making more of them would hold up everybody else."""
NOT_READ: Final = "That is no JSON object with an op."
TOO_MANY_PARTS: Final = f"That has more than {PARTS_AT_MOST} lists, objects and fields."
LEVELS: Final = ("none", "error", "warning", "info")
"""Each tells of everything before it."""

Name: TypeAlias = Annotated[str, msgspec.Meta(min_length=1, max_length=NAME_MOST)]
Id: TypeAlias = Annotated[str, msgspec.Meta(max_length=NAME_MOST)] | int | None


class Publish(msgspec.Struct, frozen=True, tag="publish", tag_field="op"):
    """Publish a message."""

    topic: Name
    msg: dict[str, Any] = {}
    id: Id = None


class Advertise(msgspec.Struct, frozen=True, tag="advertise", tag_field="op"):
    """A topic will be published to."""

    topic: Name
    type: Annotated[str, msgspec.Meta(max_length=NAME_MOST)] = ""
    id: Id = None


class Unadvertise(msgspec.Struct, frozen=True, tag="unadvertise", tag_field="op"):
    """A topic will not be published to any more."""

    topic: Name
    id: Id = None


class SubscribeTopic(msgspec.Struct, frozen=True, tag="subscribe", tag_field="op"):
    """Tell me what is published there.

    Attributes:
        throttle_rate: Milliseconds between two messages, at least.
        queue_length: So many may wait because of that.
        fragment_size: Not done here; said so.
    """

    topic: Name
    type: Annotated[str, msgspec.Meta(max_length=NAME_MOST)] | None = None
    throttle_rate: Annotated[float, msgspec.Meta(ge=0, le=3_600_000)] | None = None
    queue_length: Annotated[int, msgspec.Meta(ge=0)] | None = None
    fragment_size: int | None = None
    compression: str | None = None
    id: Id = None


class Unsubscribe(msgspec.Struct, frozen=True, tag="unsubscribe", tag_field="op"):
    """Tell me no more of a topic: of this subscription, or of all of them."""

    topic: Name
    id: Id = None


class CallService(msgspec.Struct, frozen=True, tag="call_service", tag_field="op"):
    """Call a service."""

    service: Name
    args: dict[str, Any] | list[Any] | None = None
    id: Id = None


class SendActionGoal(msgspec.Struct, frozen=True, tag="send_action_goal", tag_field="op"):
    """Send a goal to an action."""

    action: Name
    action_type: Annotated[str, msgspec.Meta(max_length=NAME_MOST)] = ""
    args: dict[str, Any] | list[Any] | None = None
    feedback: bool = False
    id: Id = None


class CancelActionGoal(msgspec.Struct, frozen=True, tag="cancel_action_goal", tag_field="op"):
    """Cancel a goal that I have sent."""

    action: Name
    id: Id = None


class SetLevel(msgspec.Struct, frozen=True, tag="set_level", tag_field="op"):
    """Tell me of statuses down to this level."""

    level: str
    id: Id = None


class Authenticate(msgspec.Struct, frozen=True, tag="auth", tag_field="op"):
    """Show a key: as ``key``, or as ``mac`` where a client library knows only that field."""

    key: Annotated[str, msgspec.Meta(max_length=512)] = ""
    mac: Annotated[str, msgspec.Meta(max_length=512)] = ""
    id: Id = None


HeardOfKnown: TypeAlias = (
    Publish
    | Advertise
    | Unadvertise
    | SubscribeTopic
    | Unsubscribe
    | CallService
    | SendActionGoal
    | CancelActionGoal
)
"""What only who has shown a key may say."""
Heard: TypeAlias = HeardOfKnown | SetLevel | Authenticate
_OPS: Final = frozenset(each.__struct_config__.tag for each in Heard.__args__)
_read: Callable[[str], Heard] = msgspec.json.Decoder(Heard).decode


class _Any(msgspec.Struct):
    """As much of a message as tells what is wrong with it."""

    op: Any = None
    id: Any = None


class RefusedMessage(msgspec.Struct, frozen=True):
    """A message that was not followed.

    Attributes:
        why: What is wrong with it; empty: its op is not done here.
        op: As it says; empty: it cannot be read.
    """

    why: str
    op: str = ""
    id: Id = None


def read(text: str) -> Heard | RefusedMessage:
    """Return what a client says, or what is wrong with it."""
    if _has_too_many_parts(text):
        return RefusedMessage(TOO_MANY_PARTS)
    try:
        return _read(text)
    except RecursionError:
        return RefusedMessage("That is nested too deeply.")
    except (msgspec.MsgspecError, UnicodeError) as error:
        return _misread(text, str(error))


def _has_too_many_parts(text: str) -> bool:
    if len(text) <= PARTS_AT_MOST:  # nearly every message: a part is a letter at least
        return False
    lists = text.count("[") + text.count("{")
    if lists + text.count(":") <= PARTS_AT_MOST:
        return False
    return lists + sum(1 for _ in _FIELD.finditer(text)) > PARTS_AT_MOST


_FIELD: Final = re.compile(r'"\s*:')


def _misread(text: str, why: str) -> RefusedMessage:
    try:
        found = msgspec.json.decode(text, type=_Any)
    except (msgspec.MsgspecError, UnicodeError, RecursionError):
        return RefusedMessage(NOT_READ)
    known = found.id if isinstance(found.id, str | int) and not isinstance(found.id, bool) else None
    known = known[:NAME_MOST] if isinstance(known, str) else known
    if not isinstance(found.op, str):
        return RefusedMessage(NOT_READ, id=known)
    if found.op not in _OPS:
        return RefusedMessage("", op=found.op[:40], id=known)
    return RefusedMessage(f"{found.op}: {why[:200]}", op=found.op, id=known)


def about(heard: Heard | RefusedMessage) -> tuple[str, str]:
    """Return the op of a message, and the topic, service or action that it names."""
    if isinstance(heard, RefusedMessage):
        return heard.op or "message", ""
    if isinstance(heard, Publish | Advertise | Unadvertise | SubscribeTopic | Unsubscribe):
        name = heard.topic
    elif isinstance(heard, CallService):
        name = heard.service
    elif isinstance(heard, SendActionGoal | CancelActionGoal):
        name = heard.action
    else:
        name = ""
    return str(heard.__struct_config__.tag), name


# ---- what they are told ----


class StatusMessage(msgspec.Struct, frozen=True, tag="status", tag_field="op", omit_defaults=True):
    """How something went."""

    level: str
    msg: str
    id: Id = None


class ServiceResponse(msgspec.Struct, frozen=True, tag="service_response", tag_field="op"):
    """The answer to a call."""

    service: str
    values: Any
    result: bool
    id: Id | msgspec.UnsetType = msgspec.UNSET


class ActionFeedback(msgspec.Struct, frozen=True, tag="action_feedback", tag_field="op"):
    """How far a goal is."""

    action: str
    values: Any
    id: Id | msgspec.UnsetType = msgspec.UNSET


class ActionResult(msgspec.Struct, frozen=True, tag="action_result", tag_field="op"):
    """How a goal ended.

    Attributes:
        status: As ``action_msgs/msg/GoalStatus`` has it.
    """

    action: str
    values: Any
    status: int
    result: bool
    id: Id | msgspec.UnsetType = msgspec.UNSET


class TopicPublish(msgspec.Struct, frozen=True, tag="publish", tag_field="op"):
    """A message of a topic."""

    topic: str
    msg: Any


class PngMessage(msgspec.Struct, frozen=True, tag="png", tag_field="op"):
    """Another message, in the pixels of a picture, in base64."""

    data: str


Told: TypeAlias = (
    StatusMessage | ServiceResponse | ActionFeedback | ActionResult | TopicPublish | PngMessage
)


def _as_plain(value: object) -> object:
    return value.tolist() if isinstance(value, array) else plain(value)


_encode = msgspec.json.Encoder(enc_hook=_as_plain).encode


def written(told: Told) -> bytes:
    """Return a message as it is sent. Bytes are written in base64, what is no number as null."""
    return _encode(told)


def given_id(known: Id) -> Id | msgspec.UnsetType:
    """Return an id for an answer, which has one only if the question had."""
    return msgspec.UNSET if known is None else known
