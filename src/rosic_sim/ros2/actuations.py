"""A file with one line for every time a robot began to act, for whoever counts from outside."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path


class ActuationLog:
    """Appends ``robot skill goal number``; a line is whole or absent, whoever else appends."""

    def __init__(self, path: Path | None) -> None:
        """Open it, unless there is none to keep.

        Raises:
            OSError: It cannot be written.
        """
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC
        self._file = None if path is None else os.open(path, flags, 0o600)

    def add(self, robot: str, skill: str, goal: str, number: int) -> None:
        """Write one down.

        Args:
            robot: Which acts.
            skill: What it does; ``drive`` for a stream of velocities.
            goal: Id of the goal in hexadecimal digits, ``-`` for a stream.
            number: Counts what this robot did since it was switched on, from 1.
        """
        if self._file is not None:
            os.write(self._file, f"{robot} {skill} {goal} {number}\n".encode())

    def moved(self, robot: str, wall_ns: int) -> None:
        """Write down that a robot's motors were first told to move, for one goal."""
        if self._file is not None:
            os.write(self._file, f"{robot} {wall_ns}\n".encode())

    def close(self) -> None:
        """Close it."""
        if self._file is not None:
            os.close(self._file)
            self._file = None
