"""The live cards of chats, as whoever follows the chats sees them: begun, found, ended."""

from __future__ import annotations

from hashlib import blake2b
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Chat
    from rosic.core.records import Fact
    from rosic.core.robot.profile import RobotId


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

    async def end(self, card: ChatDashboard) -> None:
        """End a card because somebody said so.

        Raises:
            RecordUnavailable: It is not over.
        """
        ...


def key_of(messenger: Messenger, chat: Chat) -> str:
    """Return the key of a chat's card, which names nobody."""
    said = "\0".join((messenger.name, chat.platform, chat.id))
    return blake2b(said.encode(), digest_size=16).hexdigest()
