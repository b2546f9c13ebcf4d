"""``rosic robot discover``: a draft profile for every robot on the ROS 2 graph."""

from __future__ import annotations

import argparse
import asyncio
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.app.setup.discovery import LOOK_S, discover
from rosic.app.setup.neighbours import MIXED
from rosic.app.setup.profile_draft import NO_REST
from rosic.config.profiles import check_profile
from rosic.system import SystemClock

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Look at the live ROS 2 graph and write a draft profile for every robot seen there: its
stop, how rest is measured, telemetry, and its actions, services and velocity topic as skills with
careful bounds. Existing files are left alone."""


def run(arguments: Sequence[str]) -> int:
    """Discover. Return 1 if a file was in the way.

    Raises:
        ConfigurationError: ROS 2 is not here, or nobody is on the graph.
    """
    parser = argparse.ArgumentParser(prog="rosic robot discover", description=ABOUT)
    parser.add_argument("-o", "--output", metavar="FOLDER", help="write files instead of printing")
    parser.add_argument(
        "--seconds", type=float, default=LOOK_S, help=f"how long to look ({LOOK_S:g})"
    )
    options = parser.parse_args(arguments)
    seconds = min(max(options.seconds, 0.1), 60.0)
    drafts = asyncio.run(discover(SystemClock(), seconds=seconds, skip=_skipped))
    if options.output is None:
        print("\n---\n".join(drafts.values()), end="")
        return 0
    return max(
        [_write(Path(options.output) / f"{name}.yaml", text) for name, text in drafts.items()]
    )


def _skipped(name: str) -> None:
    print(
        f"Left out: {name}, where nothing takes velocities or goals, or shows odometry.",
        file=sys.stderr,
    )


def _write(path: Path, text: str) -> int:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        print(f"{path} exists already; it was left alone.", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"{path} cannot be written ({error.strerror}).", file=sys.stderr)
        return 1
    print(f"Written: {path}")
    notes = (
        line.removeprefix("# ") for line in text.splitlines() if line.startswith((MIXED, NO_REST))
    )
    for wrong in (*notes, *check_profile(path)):
        print(f"  look at: {wrong}")
    return 0
