"""A gateway's side in a process of its own, to be frozen: drives /base by velocities.

Usage: stream_driver.py WITHIN_S: how old what shows rest may be.

Lines on standard input: ``drive SECONDS``, ``stop``, ``resume``, ``presence``. Says ``there``,
``driving`` once the robot is measured to move, ``ended ENDING NOTE``, ``rest CONFIRMED``.
"""

from __future__ import annotations

import asyncio
import sys
from typing import TYPE_CHECKING

from rosic.core.order import OrderStage, Stop
from rosic.errors import RosicError
from rosic.system import SystemClock
from tests.real.ros2.base_profile import base_profile
from tests.real.ros2.simulated import opened, until

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.order import Order, StageReport
    from rosic.core.robot.profile import Profile
    from tests.real.ros2.simulated import TriedRobot


def say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def tell(report: StageReport) -> None:
    if report.stage is OrderStage.RECEIVED:
        say("driving")
    if report.note:
        say(f"note {report.note}")


def for_seconds(robot: TriedRobot, seconds: float) -> Order:
    return robot.order("drive", {"linear": 0.2, "duration": seconds})


async def drive(robot: TriedRobot, order: Order) -> None:
    try:
        outcome = await robot.execute(order, tell)
    except RosicError as error:
        say(f"ended {error.code} {error}")
    else:
        say(f"ended {outcome.ending.value} {outcome.note}")


async def stop(robot: TriedRobot) -> None:
    rest = await robot.stop(Stop(robot.gate.robot, robot.gate.generation + 1))
    say(f"rest {rest.confirmed}")


async def obey(profile: Profile, ordered: Callable[[TriedRobot, float], Order]) -> None:
    """Do what the lines say; the number of ``drive`` is for whoever makes the order."""
    loop, reader = asyncio.get_running_loop(), asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    async with opened(profile, SystemClock()) as robot, asyncio.TaskGroup() as tasks:
        if profile.at_rest is not None:
            await until(lambda: robot.presence().at_rest is not None)
        say("ready")
        while line := (await reader.readline()).decode().split():
            if line[0] == "drive":
                tasks.create_task(drive(robot, ordered(robot, float(line[1]))))
            elif line[0] == "stop":
                tasks.create_task(stop(robot))
            elif line[0] == "resume":
                await robot.resume(robot.gate.generation)
            else:
                say(f"online {robot.presence().online} at_rest {robot.presence().at_rest}")


if __name__ == "__main__":
    asyncio.run(obey(base_profile(float(sys.argv[1])), for_seconds))
