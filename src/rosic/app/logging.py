"""The log of a running gateway: standard error, one line each, secrets masked."""

from __future__ import annotations

import ctypes
import logging
import sys
import traceback
from pathlib import PurePath
from typing import TYPE_CHECKING, Final

from rosic.core.secret import MASK, Secret

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.order_status import Face


# ---- private memory ----

# Keeps tokens and keys out of core dumps, and out of reach of this user's other programs.

try:
    import resource
except ImportError:  # no Unix
    resource = None  # type: ignore[assignment]

PR_GET_DUMPABLE: Final = 3
PR_SET_DUMPABLE: Final = 4


def keep_memory_private() -> bool:
    """Have this process leave no core dump, and let no debugger of the same user in.

    Returns:
        Whether both hold now, as read back. Where the system offers neither, nothing is changed.
    """
    if sys.platform != "linux" or resource is None:
        return False
    try:
        _, most = resource.getrlimit(resource.RLIMIT_CORE)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0 if most else most))
        limited = resource.getrlimit(resource.RLIMIT_CORE)[0] == 0
        libc = ctypes.CDLL(None, use_errno=True)
        libc.prctl(PR_SET_DUMPABLE, 0, 0, 0, 0)
        return limited and libc.prctl(PR_GET_DUMPABLE, 0, 0, 0, 0) == 0
    except (OSError, ValueError, AttributeError):
        return False


# ---- logging ----

SHORTEST_SECRET = 4


class OneLine(logging.Formatter):
    """``14:02:07 warning rosic.delivery: not told yet: ...``; a trace becomes its last place.

    Args:
        face: Shows the time of day.
        secrets: Never shown, whoever logs them.
        traces: Show whole traces too, on lines of their own, and microseconds; for finding faults.
    """

    def __init__(self, face: Face, secrets: Iterable[Secret] = (), *, traces: bool = False) -> None:
        super().__init__()
        self._face = face
        self._traces = traces
        self._hidden = sorted(_parts(secrets), key=len, reverse=True)

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        time = self._face(int(record.created * 1e9))
        if self._traces:
            time += f".{int(record.created * 1e6) % 1_000_000:06}"
        said = " ".join(record.getMessage().split())
        line = f"{time} {record.levelname.lower()} {record.name}: {said}"
        error = record.exc_info[1] if record.exc_info else None
        if error is not None:
            line += f" ({_place(error)})"
            if self._traces:
                line += "\n" + "".join(traceback.format_exception(error)).rstrip()
        for secret in self._hidden:
            line = line.replace(secret, MASK)
        return line


class StandardError(logging.StreamHandler):  # type: ignore[type-arg] # generic in stubs only
    """Writes to whatever standard error is at that moment: a prompt may have put itself before."""

    def __init__(self) -> None:
        logging.Handler.__init__(self)

    @property
    def stream(self) -> object:
        """Standard error of now."""
        return sys.stderr


def log_to_standard_error(level: str, face: Face, secrets: Iterable[Secret] = ()) -> None:
    """Log from now on; replaces what was set up before.

    Args:
        level: ``debug``, ``info``, ``warning`` or ``error``. Other libraries are kept to warnings.
        face: Shows the time of day.
        secrets: Masked.
    """
    handler = StandardError()
    handler.setFormatter(OneLine(face, secrets, traces=level == "debug"))
    root = logging.getLogger()
    root.handlers[:] = [handler]
    root.setLevel(logging.WARNING)
    logging.getLogger("rosic").setLevel(level.upper())


def _parts(secrets: Iterable[Secret]) -> set[str]:
    """Return what to mask: of ``number:token`` the number is public, and operators need it."""
    texts = [secret.reveal() for secret in secrets]
    parts = {text.partition(":")[2] or text for text in texts}
    return {part for part in parts if len(part) >= SHORTEST_SECRET}


def _place(error: BaseException) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    said = f"{type(error).__name__}: {' '.join(str(error).split())}"
    if not frames:
        return said
    return f"{said}, at {PurePath(frames[-1].filename).name}:{frames[-1].lineno}"
