"""What an interpreter owes to ROSIC: it is asked what words mean, and believed in nothing."""

from __future__ import annotations

import enum
from typing import Final, Protocol

import msgspec

ANSWER_BYTES: Final = 16 * 1024
"""So much is read of an answer; what sends more is cut off."""


class AnswerKind(enum.Enum):
    """What came of asking. The value is what a log counts it as."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    ANSWERED = "answered"
    UNREACHABLE = "unreachable"
    """No connection, or it broke."""
    LATE = "late"
    """Not there within its time."""
    REFUSED = "refused"
    """Anything but a plain success: an error, or the way to somewhere else."""
    TOO_LARGE = "too large"
    UNREADABLE = "unreadable"
    """Not of the form that was agreed."""


class InterpreterAnswer(msgspec.Struct, frozen=True):
    """What an interpreter made of some words.

    Attributes:
        text: As it came, of at most `ANSWER_BYTES`; anything may be in it. Empty unless answered.
    """

    kind: AnswerKind
    text: str = ""

    def __repr__(self) -> str:
        return f"InterpreterAnswer({self.kind.value}, {len(self.text)} characters)"


class Interpreter(Protocol):
    """Something outside ROSIC that may guess what somebody meant.

    Attributes:
        where: Whose machine reads what it is shown, as people read it: ``api.example.com``; empty
            for this machine.
    """

    where: str

    async def ask(self, instructions: str, text: str) -> InterpreterAnswer:
        """Show it a text, and return what it says.

        It is over within the time that was configured, holds no step of the event loop for more
        than 20 ms whatever comes back, reads no more than `ANSWER_BYTES`, follows no redirect,
        and sends nothing besides what it is given and what its account wants. Cancelling it cuts
        off the connection.

        Args:
            instructions: What it may say, and how.
            text: What somebody wrote.

        Returns:
            An answer in any case: nothing is raised, and nothing is tried twice.
        """
        ...
