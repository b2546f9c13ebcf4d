"""A file that is handed to a robot, and what the robot's side says about it."""

from __future__ import annotations

from typing import Final

import msgspec

CONTENT_BYTES: Final = 60_000
"""The most that goes inside a message; anything larger goes by its path."""


class FileForRobot(msgspec.Struct, frozen=True, kw_only=True):
    """One file on its way to a robot.

    Attributes:
        name: Plain; no path.
        path: Where it lies in the robot's inbox; empty where it has none.
        sort: What it is by its content: ``yaml``.
        digest: SHA-256.
        content: Only where the profile sends it inside the message; else empty.
    """

    name: str
    path: str
    sort: str
    size: int
    digest: bytes
    content: bytes = b""

    def __repr__(self) -> str:
        return f"Parcel({self.sort}, {self.size} bytes)"


class Receipt(msgspec.Struct, frozen=True, kw_only=True):
    """What the robot's side answered to a file.

    Attributes:
        received: The robot's side said that it has it; False: nothing acknowledges, or it declined.
        declined: It said that it does not take it.
        digest: The SHA-256 that it read, as it says; empty where it says none.
        words: What else it says; inert.
    """

    received: bool
    declined: bool = False
    digest: str = ""
    words: str = ""

    def agrees(self, digest: bytes) -> bool:
        """Whether it read what was sent."""
        return self.digest.strip().casefold() == digest.hex()
