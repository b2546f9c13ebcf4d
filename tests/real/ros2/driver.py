"""A gateway's side in a process of its own, to be killed: one robot, one order.

Usage: driver.py PROFILE SKILL NAME=VALUE... Says ``ready`` when the robot is at it, and ``ended``.
"""

from __future__ import annotations

import asyncio
import sys

from rosic.core.order import OrderStage, StageReport
from rosic.system import SystemClock
from tests.real.ros2.simulated import opened, shipped


def say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


async def drive(name: str, skill: str, spoken: list[str]) -> None:
    pairs = (entry.partition("=") for entry in spoken)
    arguments = {key: _number_or_word(value) for key, _, value in pairs}

    def tell(report: StageReport) -> None:
        if report.stage is OrderStage.RUNNING and (report.fraction or 0.0) > 0.02:
            say("ready")

    async with opened(shipped(name), SystemClock()) as robot:
        outcome = await robot.execute(robot.order(skill, arguments), tell)
        say(f"ended {outcome.ending.value} {outcome.note}")
        await asyncio.sleep(600)


def _number_or_word(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


if __name__ == "__main__":
    asyncio.run(drive(sys.argv[1], sys.argv[2], sys.argv[3:]))
