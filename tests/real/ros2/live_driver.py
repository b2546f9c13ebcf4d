"""A gateway's side in a process of its own, to be frozen: drives /base live, by what it is told.

Usage: live_driver.py WITHIN_S: how old what shows rest may be.

Lines on standard input: ``live``, ``sample NUMBER SENT_NS LINEAR``, ``release``, ``counts``,
``stop``, ``resume``, ``presence``. Says what `stream_driver` says, and to ``presence`` as well
``orders NUMBER``: so many are under way. The end of each is said before it counts no more.
"""

from __future__ import annotations

import asyncio
import sys
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.contracts.live_control import LiveControls
from rosic.core.sample_gate import LiveRange, LiveSample, SampleGate
from rosic.errors import RosicError
from rosic.system import SystemClock
from tests.real.ros2.base_profile import base_profile
from tests.real.ros2.simulated import opened, until
from tests.real.ros2.stream_driver import say, stop, tell

if TYPE_CHECKING:
    from rosic.core.order import Order
    from tests.real.ros2.simulated import TriedRobot

CAP_M_S = 0.4


async def drive(robot: TriedRobot, order: Order, controls: LiveControls) -> None:
    try:
        outcome = await robot.execute_live(order, tell, controls)
    except RosicError as error:
        say(f"ended {error.code} {error}")
    else:
        say(f"ended {outcome.ending.value} {outcome.code or '-'} {outcome.note}")


def controls_of(order: Order) -> LiveControls:
    """Return controls that nobody has used yet."""
    ranges = (LiveRange("linear", -CAP_M_S, CAP_M_S),)
    return LiveControls(SampleGate(order.cid, ranges, order.arguments), SystemClock())


async def obey(robot: TriedRobot) -> None:
    """Do what the lines say."""
    loop, reader = asyncio.get_running_loop(), asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    order, controls = robot.order("drive", {"duration": 0.1}), None
    under_way: set[asyncio.Task[None]] = set()
    say("ready")
    async with asyncio.TaskGroup() as tasks:
        while line := (await reader.readline()).decode().split():
            if line[0] == "live":
                order = replace(robot.order("drive", {"duration": 0.1}), live=True)
                controls = controls_of(order)
                driving = tasks.create_task(drive(robot, order, controls))
                under_way.add(driving)
                driving.add_done_callback(under_way.discard)
            elif line[0] == "sample" and controls is not None:
                values = {"linear": float(line[3])}
                controls.put(LiveSample(order.cid, values, int(line[2]), int(line[1])))
            elif line[0] == "release" and controls is not None:
                controls.release()
            elif line[0] == "counts" and controls is not None:
                some = " ".join(f"{v.value}={n}" for v, n in controls.gate.counts.items() if n)
                say(f"counts {some}")
            elif line[0] == "stop":
                tasks.create_task(stop(robot))
            elif line[0] == "resume":
                await robot.resume(robot.gate.generation)
            else:
                say(f"orders {len(under_way)}")
                say(f"online {robot.presence().online} at_rest {robot.presence().at_rest}")


async def main(within_s: float) -> None:
    """Drive it until nobody says anything any more."""
    async with opened(base_profile(within_s), SystemClock()) as robot:
        await until(lambda: robot.presence().at_rest is not None)
        await obey(robot)


if __name__ == "__main__":
    asyncio.run(main(float(sys.argv[1])))
