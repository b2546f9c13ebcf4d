"""The live cards of chats, as whoever follows the chats sees them: begun, found, ended."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from hashlib import blake2b
from typing import TYPE_CHECKING, Protocol, TypeAlias

from rosic.core.identity import DIGEST_BYTES
from rosic.core.message import Outbound

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Chat
    from rosic.core.records import Fact
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.commands import CommandContext


class ChatDashboard(Protocol):
    """A chat's card."""

    @property
    def key(self) -> str:
        """Return the key of its fact: `key_of` its chat."""

    @property
    def messenger(self) -> Messenger:
        """Return through which its chat is reached."""

    @property
    def chat(self) -> Chat:
        """Return where it is."""

    @property
    def owner(self) -> PrincipalId:
        """Return whose rights say what it shows."""

    @property
    def robots(self) -> tuple[RobotId, ...]:
        """Return which it shows, as they were named; none: every robot that the owner may see."""

    @property
    def pinned(self) -> bool:
        """Return whether it is kept in sight, as far as is known."""

    @property
    def wanted_pinned(self) -> bool:
        """Return whether it is to be."""

    def no_fact(self) -> Fact:
        """Return what is to be written so that it is over."""
        ...


class ChatDashboards(Protocol):
    """All of them; at most one a chat."""

    def of(self, messenger: Messenger, chat: Chat) -> ChatDashboard | None:
        """Return a chat's card."""
        ...

    def in_channels(self) -> Sequence[ChatDashboard]:
        """Return the cards that anybody may read."""
        ...

    def begin(
        self,
        messenger: Messenger,
        chat: Chat,
        owner: PrincipalId,
        robots: tuple[RobotId, ...],
        *,
        pinned: bool,
    ) -> None:
        """Begin a card in a new message; an older one of this chat ends.

        Raises:
            TooManyRequests: There are too many cards; nothing has changed.
        """
        ...

    async def end(self, dashboard: ChatDashboard) -> None:
        """End a card because somebody said so.

        Raises:
            RecordUnavailable: It is not over.
        """
        ...


Deliver: TypeAlias = Callable[[int, Outbound], Awaitable[None]]


class CameraPreview(Protocol):
    """Looks at robots that may be looked at."""

    def offers(self, robot: RobotId) -> bool:
        """Whether its profile opens its camera to people, and pictures can be drawn here."""
        ...

    def look(
        self, asked: CommandContext, robot: RobotId, deliver: Deliver, *, unasked: bool = False
    ) -> None:
        """Begin to make a picture, and hand over when it was taken (wall clock), and how it looks.

        Only if whoever asked may still look then.

        Args:
            asked: By whom, where.
            robot: At which robot.
            deliver: Takes it.
            unasked: Nobody has asked for just this one: where there is none, nothing is said, and
                it keeps nobody's from being made.

        Raises:
            Refusal: Not now; nothing was begun.
        """
        ...


class FleetStatus(Protocol):
    """What is known of a fleet: its robots, and the tasks they have."""

    def settled(self, robots: Sequence[RobotId]) -> tuple[object, ...]:
        """Return what does not change all the time: while it is the same, so is the fleet."""
        ...

    def lines(self, robots: Sequence[RobotId], wall_ns: int, who: PrincipalId) -> Iterable[str]:
        """Return what there is to say about some robots and their tasks, for somebody to read."""
        ...


def key_of(messenger: Messenger, chat: Chat) -> str:
    """Return the key of a chat's card, which names nobody."""
    said = "\0".join((messenger.name, chat.platform, chat.id))
    return blake2b(said.encode(), digest_size=DIGEST_BYTES).hexdigest()
