"""``rosic check`` and ``doctor``: what is wrong, without starting anything."""

from __future__ import annotations

import argparse
import asyncio
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.app.config import Config, load_config
from rosic.app.setup import DiagnosticFinding, FindingVerdict, examine
from rosic.app.setup.check import check_all
from rosic.cli.client import CONFIG
from rosic.errors import ConfigurationError
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from collections.abc import Sequence


# ---- ``rosic check`` ----

CHECK_ABOUT = "Say everything that is wrong with a configuration file and the profiles it names."


def check(arguments: Sequence[str]) -> int:
    """Check. Return 0 if a gateway could be started with it, else 2."""
    parser = argparse.ArgumentParser(prog="rosic check", description=CHECK_ABOUT)
    parser.add_argument("-c", "--config", metavar="FILE", default=CONFIG)
    options = parser.parse_args(arguments)
    found = check_all(options.config, SystemClock())
    for advice in found.advice:
        print(f"{advice}")
    for error in found.errors:
        print(f"{error}", file=sys.stderr)
    if found.errors:
        count = len(found.errors)
        print(f"{count} {'thing is' if count == 1 else 'things are'} wrong.", file=sys.stderr)
        return 2
    print(f"{options.config} is good: {found.summary}.")
    return 0


# ---- ``rosic doctor`` ----

DOCTOR_ABOUT = """Measure this machine: its disk, record and clocks; look for ROS 2; check the
accounts of the messengers. With --try, one robot moves slowly for a moment, and its stop and its
watchdog are measured: have free space around it."""

LEFT = """Broken off. Whatever was under way was ended. Where {robot} had been stopped, it stays
stopped, also after a start: see rosic status, and say: resume {robot}"""


def doctor(arguments: Sequence[str]) -> int:
    """Examine. Return 0 if all is good, 1 if something should be looked at.

    Raises:
        ConfigurationError: The configuration is wrong.
    """
    parser = argparse.ArgumentParser(prog="rosic doctor", description=DOCTOR_ABOUT)
    parser.add_argument(
        "-c",
        "--config",
        metavar="FILE",
        help=f"also look at what it names ({CONFIG}, if it is here)",
    )
    parser.add_argument("--try", dest="tried", metavar="ROBOT", default="", help="it moves")
    options = parser.parse_args(arguments)
    found = options.config or (CONFIG if Path(CONFIG).exists() else None)
    if options.tried and found is None:
        raise ConfigurationError(
            f"To try a robot, its configuration is needed, and there is no {CONFIG} here.",
            hint=f"For example: rosic doctor -c lab/{CONFIG} --try {options.tried}",
        )
    config = load_config(found) if found is not None else None
    if config is not None and options.config is None:
        found_here = "found here; what it names is looked at, too"
        print(DiagnosticFinding(CONFIG, FindingVerdict.GOOD, found_here))
    try:
        return asyncio.run(_examine(config, options.tried))
    except KeyboardInterrupt:
        if options.tried:
            print(LEFT.format(robot=options.tried), flush=True)
        raise


async def _examine(config: Config | None, tried: str) -> int:
    looked = False
    async for finding in examine(config, tried=tried, clock=SystemClock(), entropy=SystemEntropy()):
        print(finding, flush=True)
        looked = looked or finding.verdict is FindingVerdict.LOOK
    return 1 if looked else 0
