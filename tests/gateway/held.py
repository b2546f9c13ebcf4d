"""A gateway of its own process, on the machine's clocks, for whoever holds it (SIGSTOP).

It gives a robot that queues two orders, says so, and once it may read a line it lets the first
end. Then it says how often the robot acted, and what was told last.
"""

from __future__ import annotations

import asyncio
import os
import sys

from msgspec.structs import replace

from rosic.core.robot.profile import Busy
from rosic.core.robot.skill import Skill
from rosic.system import SystemClock
from tests.gateway.place import Place, profile

LIVES_S = 2.0
WAVE = Skill(id="wave", title="Wave", lifetime_s=LIVES_S)


class RealTime(SystemClock):
    """The machine's clocks; the place lets its own run a little before it says something."""

    async def advance(self, seconds: float) -> None:
        """Wait for so long."""
        await self.sleep(seconds)


def say(*words: object) -> None:
    """Say a line at once."""
    os.write(1, (" ".join(map(str, words)) + "\n").encode())


async def main() -> None:
    fleet = (replace(profile("kuka1", busy=Busy.QUEUE), skills={"wave": WAVE}),)
    async with Place(fleet=fleet, clock=RealTime()).open() as place:  # type: ignore[arg-type]
        robot = place.robot("kuka1")
        robot.work_s = 3600.0
        await place.say("kuka1 wave")
        await place.say("kuka1 wave")
        say("waiting", len(robot.acted))
        # In a thread: the event loop has nothing to do meanwhile, and finds itself held.
        await asyncio.get_running_loop().run_in_executor(None, sys.stdin.readline)
        robot.finish()
        await place.quiet()
        say("acted", len(robot.acted), place.last()[1].text)
        robot.finish()


if __name__ == "__main__":
    asyncio.run(main())
