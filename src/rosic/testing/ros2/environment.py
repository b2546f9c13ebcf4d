"""The environment that a process with ROS 2 needs, and that a process without it must not get.

The ROS 2 wheels restart every Python of their virtual environment once, to put their libraries on
``LD_LIBRARY_PATH`` before anything is loaded, and leave ``_ROS_WHEELS_BOOTSTRAP_COMPLETE=1`` as a
sign that it is done. That costs 30 ms a start (29 ms become 60 ms), even for ``python -c pass``.
Children inherit both variables. For another Python of the same environment that is a gain. For a
Python of *another* environment it is a trap: with the sign set it does not look for its own
libraries, and with the path set it loads ours. `environment_for_another_python` takes both away.
The same path is bad for compilers and for any other program with libraries of its own.
"""

from __future__ import annotations

import os
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.errors import how_to_install

if TYPE_CHECKING:
    from collections.abc import Mapping

BOOTSTRAPPED = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"

_LIBRARIES = "LD_LIBRARY_PATH"
_ELSEWHERE = ("ROS_STATIC_PEERS", "ROS_DISCOVERY_SERVER")


def why_missing() -> str | None:
    """Return the sentence that says how to get ROS 2; None when it is here."""
    if find_spec("rclpy") is not None:
        return None
    return f"ROS 2 is not here: source your distribution, or run {how_to_install('ros2')}."


def environment_for_another_python(environ: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return an environment in which a Python of another virtual environment finds its own.

    Args:
        environ: What to start from; this process's by default.
    """
    environment = dict(os.environ if environ is None else environ)
    environment.pop(BOOTSTRAPPED, None)
    ours = Path(sys.prefix)
    kept = [
        entry
        for entry in environment.pop(_LIBRARIES, "").split(os.pathsep)
        if entry and not Path(entry).is_relative_to(ours)
    ]
    if kept:
        environment[_LIBRARIES] = os.pathsep.join(kept)
    return environment


def environment_of_a_graph(domain_id: int, log_folder: Path) -> dict[str, str | None]:
    """Return the variables that make a graph of its own on this machine; None takes one away."""
    return {
        "ROS_DOMAIN_ID": str(domain_id),
        # The older of the two is honoured first where it is known, and processes then find each
        # other in 0.1 s instead of 2 to 3 s; the newer one takes over where it is not.
        "ROS_LOCALHOST_ONLY": "1",
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(log_folder),
        "ROS_PYTHON_CHECK_FIELDS": "1",
        **dict.fromkeys(_ELSEWHERE, None),
    }
