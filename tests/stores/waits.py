"""Which waits for the disk are really made: of the system itself, whoever asked for them."""

from __future__ import annotations

import os
import sys
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType

WAITS = (os.fsync, os.fdatasync)


@contextmanager
def waits() -> Iterator[list[str]]:
    """Yield the names of those that this thread makes meanwhile, and threads that begin now."""
    made: list[str] = []

    def note(_frame: FrameType, event: str, what: object) -> None:
        if event == "c_call":
            made.extend(wait.__name__ for wait in WAITS if wait is what)

    before = sys.getprofile()
    sys.setprofile(note)
    threading.setprofile(note)
    try:
        yield made
    finally:
        threading.setprofile(None)
        sys.setprofile(before)
