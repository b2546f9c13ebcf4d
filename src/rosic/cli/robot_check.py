"""``rosic robot check``: everything that is wrong with profiles."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from rosic.app.documents.profiles import known_units, read_profile

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = "Say everything that is wrong with robots' profiles, with file, line and a hint."


def run(arguments: Sequence[str]) -> int:
    """Check. Return 0 if all are good, else 2."""
    parser = argparse.ArgumentParser(prog="rosic robot check", description=ABOUT)
    parser.add_argument("files", metavar="FILE", nargs="+")
    options = parser.parse_args(arguments)
    units = known_units()
    wrong = 0
    for file in options.files:
        read = read_profile(file, units)
        wrong += len(read.errors)
        for advice in read.advice:
            print(advice)
        for error in read.errors:
            print(error, file=sys.stderr)
        if read.profile is not None:
            print(f"{file} is good: {read.profile.shown}, {len(read.profile.skills)} skills.")
    return 2 if wrong else 0
