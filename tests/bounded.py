"""Runs a command that has so many seconds on the usual machine, and more on a slower one.

`python -m tests.bounded 1800 COMMAND ...`. When its time is up it is interrupted, so that tests put
their servers away; what does not listen is killed a minute later.
"""

from __future__ import annotations

import math
import os
import sys

from tests.pace import pace

SLOW = 1.5
"""From here on it is worth a line."""


def main(seconds: str, *command: str) -> None:
    """Become the command, with a bound."""
    bound_s = math.ceil(float(seconds) * pace())
    if pace() >= SLOW:
        sys.stdout.write(
            f"This machine takes {pace():.1f} times as long as the usual one, so every limit is "
            f"{pace():.1f} times as long: the run is over within {bound_s} s.\n"
        )
        sys.stdout.flush()
    ending = ("--foreground", "--signal=INT", f"--kill-after={math.ceil(60 * pace())}")
    os.execvp("timeout", ["timeout", *ending, str(bound_s), *command])  # noqa: S606, S607 - the Makefile's command


if __name__ == "__main__":
    main(*sys.argv[1:])
