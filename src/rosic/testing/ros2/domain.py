"""A ROS domain that nobody else on this machine has."""

from __future__ import annotations

import fcntl
import os
import tempfile
from pathlib import Path
from typing import IO

# Ports of higher domains run into those that Linux lends to outgoing connections. 0 is where
# everybody's robots are who never thought about it.
_DOMAINS = range(1, 102)
_LOCKS = "rosic-ros-domains-{user}"


class NoDomainLeft(Exception):
    """Every domain is taken by another test on this machine."""


class Domain:
    """One domain, held by a lock on a file: it is free again when its process ends, however.

    Attributes:
        id: What ``ROS_DOMAIN_ID`` is set to.
    """

    def __init__(self) -> None:
        folder = Path(tempfile.gettempdir()) / _LOCKS.format(user=os.getuid())
        folder.mkdir(mode=0o700, exist_ok=True)
        first = os.getpid() % len(_DOMAINS)  # neighbours start apart, and rarely meet
        for offset in range(len(_DOMAINS)):
            self.id = _DOMAINS[(first + offset) % len(_DOMAINS)]
            lock = _take(folder / f"{self.id}.lock")
            if lock is not None:
                self._lock = lock
                return
        raise NoDomainLeft(f"All {len(_DOMAINS)} ROS domains are taken.")

    def release(self) -> None:
        """Give it back."""
        self._lock.close()


def _take(path: Path) -> IO[str] | None:
    file = path.open("a")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        return None
    return file
