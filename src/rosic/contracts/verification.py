"""What a messenger whose people's devices can be verified owes, and what it is owed for that.

Two people compare what both ends show. The one at our end looks after ROSIC; what is shown to them
has to come by a way that whoever runs the platform cannot imitate, which only the gateway knows.
"""

from __future__ import annotations

import enum
from typing import Protocol, runtime_checkable

import msgspec


class ShownCode(msgspec.Struct, frozen=True, kw_only=True):
    """What two people compare. The same on both sides, or somebody is between them.

    Attributes:
        verification: Which; to be named when it is confirmed.
        user: The account of the person at the other end.
        device: The device at the other end.
        emoji: Seven, each with its name.
        decimals: The same as three numbers; empty where emoji are shown.
    """

    verification: str
    user: str
    device: str
    emoji: tuple[tuple[str, str], ...]
    decimals: tuple[int, ...]

    @property
    def text(self) -> str:
        """Say it on one line."""
        if not self.emoji:
            return " ".join(map(str, self.decimals))
        return "  ".join(f"{sign} {name}" for sign, name in self.emoji)


class VerificationEnd(enum.Enum):
    """How a verification ended."""

    COMPARED = "compared"
    CANCELLED = "cancelled"
    NOT_KEPT = "not kept"


class VerificationResult(msgspec.Struct, frozen=True, kw_only=True):
    """What came of a verification.

    Attributes:
        verification: Its id.
        user: The account of the person at the other end.
        end: How it ended.
        master: The key that vouches for all their devices was compared, not just one device.
        code: Why it was cancelled, in the platform's words: ``m.mismatched_sas``.
        by_them: They cancelled it.
    """

    verification: str
    user: str
    end: VerificationEnd
    master: bool = False
    code: str = ""
    by_them: bool = False


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


@runtime_checkable
class VerifiesDevices(Protocol):
    """The devices of its people can be verified, begun by either side.

    Whatever ends a verification is told to the prompt, once.
    """

    def verify_with(self, prompt: VerificationPrompt) -> None:
        """Ask this prompt from now on. Until one is named nobody can be verified."""

    async def begin_verification(self, account: str) -> str:
        """Ask somebody to be verified, and return the id of the verification.

        One that is under way with them ends by it.

        Raises:
            MessengerFault: It could not be sent.
        """
        ...

    async def confirm_verification(self, verification: str) -> None:
        """Somebody at our end has compared the code: both ends show the same.

        It counts once the other end has said so, too.

        Raises:
            MessengerFault: There is no such verification any more, or nothing to confirm in it.
        """
        ...

    async def reject_verification(self, verification: str) -> None:
        """Somebody at our end has compared the code: the ends do not show the same.

        Raises:
            MessengerFault: There is no such verification any more.
        """
        ...
