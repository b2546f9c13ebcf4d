"""Keeps tokens and keys out of core dumps, and out of reach of this user's other programs."""

from __future__ import annotations

import ctypes
import sys
from typing import Final

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
