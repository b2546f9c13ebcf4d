"""A process that writes until it is killed, and says on standard output what was acknowledged.

``process.py FOLDER FIRST [early]``: claims numbered from FIRST, 32 at a time, each written in one
call with the place where it is shown, an administrative act and a fact. With ``early`` it says so
before it is true: the fault that the test must find.
"""

from __future__ import annotations

import asyncio
import os
import sys
import time
from itertools import count
from pathlib import Path

from rosic.core.records import Letter
from rosic.stores.database import DatabaseStore
from rosic.stores.stop_latch import FileLatch
from rosic.testing.factories import ADA, a_claim, a_decision, a_fact, a_place

AT_ONCE = 32


class RealClock:
    def wall_ns(self) -> int:
        return time.time_ns()

    def monotonic_ns(self) -> int:
        return time.monotonic_ns()

    async def sleep(self, seconds: float) -> None:
        await asyncio.sleep(seconds)


def say(*words: object) -> None:
    """In one piece, at once: what is in the pipe outlives this process."""
    os.write(1, (" ".join(map(str, words)) + "\n").encode())


async def main(folder: Path, first: int, *, early: bool) -> None:
    store, latch = DatabaseStore(folder, clock=RealClock()), FileLatch(folder / "latch")
    await store.open()
    latch.read()
    say("open")
    numbers = count(first)

    async def write() -> None:
        for number in numbers:
            if early:
                say("written", number)
            await store.write(
                a_claim(number, n=number),
                a_decision(str(number)),
                a_fact(str(number), letter=Letter(ADA, b"%d" % number)),
                a_place(number, b"shown"),
            )
            if not early:
                say("written", number)

    async def stop() -> None:
        for generation in count(first):
            await latch.write("omni", generation, latched=True)
            say("stopped", generation)

    await asyncio.gather(stop(), *(write() for _ in range(AT_ONCE)))


if __name__ == "__main__":
    asyncio.run(main(Path(sys.argv[1]), int(sys.argv[2]), early="early" in sys.argv))
