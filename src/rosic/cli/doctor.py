"""``rosic doctor``: what this machine and its robots are really like."""

from __future__ import annotations

import argparse
import asyncio
from typing import TYPE_CHECKING

from rosic.app.config import Config, load_config
from rosic.app.doctor import Verdict, examine
from rosic.errors import ConfigurationError
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Measure this machine: its disk, record and clocks; look for ROS 2; check the accounts of
the messengers. With --try, one robot moves slowly for a moment, and its stop and its watchdog are
measured: have free space around it."""


def run(arguments: Sequence[str]) -> int:
    """Examine. Return 0 if all is good, 1 if something should be looked at.

    Raises:
        ConfigurationError: The configuration is wrong.
    """
    parser = argparse.ArgumentParser(prog="rosic doctor", description=ABOUT)
    parser.add_argument("-c", "--config", metavar="FILE", help="also look at what it names")
    parser.add_argument("--try", dest="tried", metavar="ROBOT", default="", help="it moves")
    options = parser.parse_args(arguments)
    if options.tried and options.config is None:
        raise ConfigurationError(
            "To try a robot, its configuration is needed.",
            hint=f"For example: rosic doctor -c rosic.toml --try {options.tried}",
        )
    config = load_config(options.config) if options.config is not None else None
    return asyncio.run(_examine(config, options.tried))


async def _examine(config: Config | None, tried: str) -> int:
    looked = False
    async for finding in examine(config, tried=tried, clock=SystemClock(), entropy=SystemEntropy()):
        print(finding, flush=True)
        looked = looked or finding.verdict is Verdict.LOOK
    return 1 if looked else 0
