"""``rosic demo``: six simulated robots in this terminal."""

from __future__ import annotations

import argparse
import asyncio
from typing import TYPE_CHECKING

from rosic.app.demo import demonstrate
from rosic.app.face import face_of
from rosic.app.logs import log_to_standard_error
from rosic.cli.begun import begun_ns
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Six simulated robots in this terminal: no account, no ROS, nothing is kept. With standard
input piped, its lines run one after another, each to its end."""


def run(arguments: Sequence[str]) -> int:
    """Run the demonstration."""
    parser = argparse.ArgumentParser(prog="rosic demo", description=ABOUT)
    parser.add_argument("--plain", action="store_true", help="no colours, no prompt that redraws")
    options = parser.parse_args(arguments)
    log_to_standard_error("warning", face_of())
    return asyncio.run(
        demonstrate(SystemClock(), SystemEntropy(), plain=options.plain, begun_ns=begun_ns())
    )
