"""One chat's card: whose, of which robots, in which message; and how that is written down."""

from __future__ import annotations

from hashlib import blake2b
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.message import Button, Chat, ChatKind
from rosic.core.records import Fact, Letter
from rosic.core.robot.profile import RobotId
from rosic.features.dashboard.camera_preview import PreviewedCamera

if TYPE_CHECKING:
    import asyncio

    from rosic.contracts.messenger import Messenger
    from rosic.features.dashboard.camera_preview import PreviewViewer

KIND: Final = "card"


class DashboardBody(msgspec.Struct, frozen=True):
    """What stands in the open.

    Attributes:
        robots: As they were named; none: every robot that the owner may see.
        pinned: It is kept in sight.
        picture_of: The robot whose picture its message shows; empty for none.
        picture_ns: When that was so, wall clock.
    """

    owner: PrincipalId
    robots: tuple[RobotId, ...]
    pinned: bool
    picture_of: RobotId = ""
    picture_ns: int = 0


class DashboardPlace(msgspec.Struct, frozen=True):
    """Where it is: in the owner's container, for a chat's id is an account's."""

    messenger: str
    platform: str
    chat: str
    kind: str
    message: str


_encode = msgspec.msgpack.Encoder().encode
_body = msgspec.msgpack.Decoder(DashboardBody).decode
_place = msgspec.msgpack.Decoder(DashboardPlace).decode


class Dashboard:
    """A card.

    Attributes:
        kind: Of its fact: what sort of card it is.
        key: Of its fact: a digest of the chat.
        message: The platform's id; empty until it was sent.
        pinned: It is kept in sight, as far as is known.
        wanted_pinned: It is to be.
        shows: Robots in the newest text, and the number of the look at each.
        stamped_ns: When that text was so, monotonic clock; 0: never in this run.
        settled_ns: When the last edit was over, monotonic clock.
        lag_s: How long the last edit took to arrive.
        failures: Edits that failed in a row.
        again_ns: Not to be tried before, monotonic clock.
        picture: The picture on it, or the one that is to be; None: it is text.
        offered, offered_ns, buttons: Robots that can be looked at by a tap, since when, and how.
        last: What it says when it is over; empty while it is not.
        watched: Who looks at its picture; None: it is not renewed by itself.
        task: The edit under way.
    """

    __slots__ = (
        "again_ns", "buttons", "chat", "failures", "key", "kind", "lag_s", "last", "message",
        "messenger", "offered", "offered_ns", "owner", "picture", "pinned", "robots",
        "settled_ns", "shows", "stamped_ns", "task", "wanted_pinned", "watched",
    )  # fmt: skip

    def __init__(
        self, messenger: Messenger, chat: Chat, owner: PrincipalId, robots: tuple[RobotId, ...],
        kind: str = KIND,
    ) -> None:  # fmt: skip
        self.kind = kind
        self.key = key_of(messenger, chat)
        self.messenger = messenger
        self.chat = chat
        self.owner = owner
        self.robots = robots
        self.message = ""
        self.pinned = self.wanted_pinned = False
        self.shows: dict[RobotId, int] = {}
        self.stamped_ns = 0
        self.settled_ns = 0
        self.lag_s = 0.0
        self.failures = 0
        self.again_ns = 0
        self.picture: PreviewedCamera | None = None
        self.watched: PreviewViewer | None = None
        self.offered: tuple[RobotId, ...] = ()
        self.offered_ns = 0
        self.buttons: tuple[Button, ...] = ()
        self.last = ""
        self.task: asyncio.Task[None] | None = None

    @property
    def pictured_anew(self) -> bool:
        """Whether there is a picture that its message does not show yet."""
        return self.picture is not None and self.picture.content is not None

    def fact(self) -> Fact:
        """Return what is to be written so that it outlives this process."""
        chat = self.chat
        shown = self.picture or PreviewedCamera("", 0)
        place = DashboardPlace(
            self.messenger.name, chat.platform, chat.id, chat.kind.value, self.message
        )
        return Fact(
            kind=self.kind,
            key=self.key,
            body=_encode(
                DashboardBody(self.owner, self.robots, self.pinned, shown.robot, shown.at_ns)
            ),
            letter=Letter(self.owner, _encode(place)),
        )

    def no_fact(self) -> Fact:
        """Return what is to be written so that it is over."""
        return Fact(kind=self.kind, key=self.key, body=b"")


def read_fact(fact: Fact) -> tuple[DashboardBody, DashboardPlace] | None:
    """Return what a fact says; None if there is no card, or nobody can read any more where.

    Raises:
        msgspec.MsgspecError: It cannot be read.
    """
    if not fact.body or fact.letter is None:
        return None
    return _body(fact.body), _place(fact.letter.content)


def key_of(messenger: Messenger, chat: Chat) -> str:
    """Return the key of a chat's card, which names nobody."""
    said = "\0".join((messenger.name, chat.platform, chat.id))
    return blake2b(said.encode(), digest_size=16).hexdigest()


def chat_of(place: DashboardPlace) -> Chat:
    """Return the chat.

    Raises:
        ValueError: Of an unknown kind.
    """
    return Chat(place.platform, place.chat, ChatKind(place.kind))
