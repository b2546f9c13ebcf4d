"""``rosic check``: everything that is wrong with a configuration, without starting anything."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from rosic.app.setup.check import check_all
from rosic.cli.client import CONFIG
from rosic.system import SystemClock

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = "Say everything that is wrong with a configuration file and the profiles it names."


def run(arguments: Sequence[str]) -> int:
    """Check. Return 0 if a gateway could be started with it, else 2."""
    parser = argparse.ArgumentParser(prog="rosic check", description=ABOUT)
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
