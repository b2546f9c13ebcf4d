"""A plain process that sleeps until moments it is told: how punctual the machine itself is.

It has nothing else to do, imports next to nothing and asks for no priority. Started by
`rosic.bench.start`; reads a moment a line, monotonic nanoseconds, and writes when it woke up.
"""

from __future__ import annotations

import sys
import time

from rosic.core.time_units import SECOND_NS


def main() -> None:
    """Sleep until each moment, and say when it came."""
    for line in sys.stdin:
        while (left_ns := int(line) - time.monotonic_ns()) > 0:
            time.sleep(left_ns / SECOND_NS)
        sys.stdout.write(f"{time.monotonic_ns()}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
