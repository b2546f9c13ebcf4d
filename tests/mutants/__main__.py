"""`python -m tests.mutants`: change safety code at random and see which tests notice.

What was found is kept below `build/mutants`: a run that is cut off goes on where it was, and what
has not changed is not tried again.
"""

from __future__ import annotations

import argparse
import sys
import time
from datetime import UTC, datetime

from tests.mutants import report
from tests.mutants.campaign import ROOT, Wanted, listed, share, table, tried, unlisted
from tests.mutants.modules import MODULES

AT_LEAST = 95.0


def main() -> int:
    """Run, print, and return the exit status."""
    asked = _asked()
    wanted = Wanted(
        seed=asked.seed,
        at_most=asked.at_most,
        each_s=asked.each,
        until_s=time.time() + asked.seconds,
        folder=ROOT / "build" / "mutants",
        keep_kills=asked.keep_kills,
        again=asked.again,
    )
    found = []
    for module in MODULES:
        if any(part in module.file for part in asked.only.split(",")):
            one = tried(module, wanted)
            found.append(one)
            print(f"{module.file}: {one.killed} of {one.real} noticed", file=sys.stderr)  # noqa: T201
            for test in one.failing:
                print(f"  fails without a change: {test}", file=sys.stderr)  # noqa: T201
    known = listed()
    unexplained = unlisted(found, known)
    print(table(found))  # noqa: T201
    for line in unexplained:
        print(line)  # noqa: T201
    if asked.write:
        report.write(found, asked.seed, datetime.now(UTC).date().isoformat())
    enough = share(found) >= AT_LEAST
    left = sum(len(one.chosen) - len(one.results) for one in found)
    print(  # noqa: T201
        f"{share(found):.1f} % noticed, {len(unexplained)} survivors without a reason, "
        f"{left} not tried"
    )
    return 0 if enough and not unexplained and not left else 1


def _asked() -> argparse.Namespace:
    words = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    words.add_argument(
        "--only", default="", help="modules whose file contains one of these, parted by commas"
    )
    words.add_argument("--at-most", type=int, default=0, help="mutants per module; 0: all")
    words.add_argument("--seed", type=int, default=1, help="which of them, when not all")
    words.add_argument("--each", type=float, default=30.0, help="seconds of tests per mutant")
    words.add_argument("--seconds", type=float, default=14_400.0, help="none is begun after that")
    words.add_argument(
        "--keep-kills", action="store_true", help="what other tests killed before counts as killed"
    )
    words.add_argument("--again", action="store_true", help="try once more what survived before")
    words.add_argument(
        "--write", action="store_true", help="put what was tried to the end into docs/mutants.md"
    )
    return words.parse_args()


if __name__ == "__main__":
    sys.exit(main())
