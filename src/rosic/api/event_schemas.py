"""What is said and told over the WebSocket of events: the one definition, for server and client."""

from __future__ import annotations

from typing import Annotated, Final, TypeAlias

import msgspec

from rosic.api.schemas import IdentityOut, Name, OrderOut, PageMessage, Problem, RobotOut, StopOut

TOPICS: Final = ("robots", "orders", "chat", "rates")
ABILITIES: Final = ("jog",)
"""For a page that may be older or newer than this gateway."""
ENDED: Final = 4401
"""The code with which a connection is closed whose key or session is not good any more."""

Topic = Annotated[str, msgspec.Meta(max_length=64)]

# ---- what a client says ----


class Subscribe(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="subscribe", tag_field="op"
):
    """Tell me of these from now on, and how it is now; of nothing else.

    Attributes:
        topics: Of `TOPICS`; with any other it is refused, and everything stays as it was.
    """

    topics: tuple[Topic, ...]


class StopRequest(msgspec.Struct, frozen=True, tag="stop", tag_field="op"):
    """Stop robots, at once; all that I may see, if none is named.

    Attributes:
        id: Comes back with the answer.
    """

    robots: tuple[Name, ...] = ()
    id: str = ""


class Ping(msgspec.Struct, frozen=True, tag="ping", tag_field="op"):
    """Answer at once."""

    id: str = ""


# ---- what a client is told ----


class Hello(msgspec.Struct, frozen=True, tag="hello", tag_field="event"):
    """The first event.

    Attributes:
        run: Another one after the gateway was restarted.
        abilities: What may be said here besides.
    """

    me: IdentityOut
    run: str
    abilities: tuple[str, ...] = ABILITIES


class RobotEvent(msgspec.Struct, frozen=True, tag="robot", tag_field="event"):
    """A robot as it is now."""

    robot: RobotOut


class RobotGone(msgspec.Struct, frozen=True, tag="robot-gone", tag_field="event"):
    """A robot is not there any more, or may not be seen any more."""

    robot: str


class OrderEvent(msgspec.Struct, frozen=True, tag="order", tag_field="event"):
    """An order as it is now."""

    order: OrderOut


class MessageEvent(msgspec.Struct, frozen=True, tag="message", tag_field="event"):
    """A message of one's own conversation as it is now."""

    message: PageMessage


class MessengerRate(msgspec.Struct, frozen=True):
    """What comes in and goes out on a messenger in one second: messages, and their bytes."""

    name: str
    in_per_s: float
    out_per_s: float
    in_bytes_s: float
    out_bytes_s: float


class RobotRate(msgspec.Struct, frozen=True):
    """How many messages are sent to a robot and received from it in one second."""

    robot: str
    sent_per_s: float
    received_per_s: float


class RatesEvent(msgspec.Struct, frozen=True, tag="rates", tag_field="event"):
    """What passed in the last second, on everything that counts; told once a second."""

    messengers: tuple[MessengerRate, ...]
    robots: tuple[RobotRate, ...]


class StopEvent(msgspec.Struct, frozen=True, tag="stop", tag_field="event"):
    """What became of a stop."""

    id: str
    stop: StopOut


class Pong(msgspec.Struct, frozen=True, tag="pong", tag_field="event"):
    """The answer to a ping."""

    id: str


class ProblemEvent(msgspec.Struct, frozen=True, tag="problem", tag_field="event"):
    """Something was not done."""

    problem: Problem
    id: str = ""


Event: TypeAlias = (
    Hello
    | RobotEvent
    | RobotGone
    | OrderEvent
    | MessageEvent
    | RatesEvent
    | StopEvent
    | Pong
    | ProblemEvent
)
