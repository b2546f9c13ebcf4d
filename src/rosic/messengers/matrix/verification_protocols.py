"""What a verification needs of others: somebody who sends, and somebody who compares."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Protocol

import msgspec

if TYPE_CHECKING:
    from rosic.messengers.matrix.sas import Content, ShownCode


class VerificationEnd(enum.Enum):
    """How a verification ended."""

    COMPARED = "compared"
    CANCELLED = "cancelled"
    NOT_KEPT = "not kept"


class VerificationResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came of a verification.

    Attributes:
        verification: Its id.
        user: The person at the other end.
        end: How it ended.
        master: Their master key was compared, not just one device.
        code: Why it was cancelled, in the specification's words: ``m.mismatched_sas``.
        by_them: They cancelled it.
    """

    verification: str
    user: str
    end: VerificationEnd
    master: bool = False
    code: str = ""
    by_them: bool = False


class VerificationTransport(Protocol):
    """Carries what two devices say to each other. Raises ``MessengerFault`` where it does not."""

    async def to_device(self, user: str, device: str, kind: str, content: Content) -> None:
        """Send one to-device message, as it is; ``*`` is every device of that person."""
        ...

    async def in_room(self, room: str, kind: str, content: Content) -> str:
        """Send one event into a room, encrypted where the room is, and return its id."""
        ...


class VerificationPrompt(Protocol):
    """The people at our end. All of it is called on the event loop."""

    def accepts(self, user: str) -> bool:
        """Whether this person may begin one. What a stranger begins is passed over in silence."""
        ...

    def show(self, code: ShownCode) -> None:
        """Show the code to whoever looks after the robot, who then confirms or rejects it."""
        ...

    def tell(self, result: VerificationResult) -> None:
        """Say how one ended; once for each that had begun."""
        ...
