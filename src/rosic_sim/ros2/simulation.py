"""The simulated robots as real ROS 2 nodes: ``python -m rosic_sim.ros2.simulation omni kuka1``.

One process, one node for each robot, under ``/omni``, ``/kuka1`` and so on. Several processes may
share the robots between them; the drones of one swarm then meet over a topic.
"""

from __future__ import annotations

import argparse
import gc
import signal
import sys
import time
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from rosic.errors import ConfigurationError
from rosic.robots.ros2.client.rclpy_import import (
    find_interfaces,
    find_own_interfaces,
    load_ros,
    make_executor,
)
from rosic.robots.ros2.messages.names import did_you_mean
from rosic_sim.robots.machines.field_robots import FireWatcher, Rover
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.machines.world import SimulatedWorld, build_world
from rosic_sim.ros2.endpoints import MODELS, ActuationLog, model_of
from rosic_sim.ros2.machine_node import LINK_LOST_S, NODE_NAME, LinkWatchdog, MachineNode
from rosic_sim.ros2.waiting_clock import RealtimePriority, WaitingClock
from rosic_sim.ros2_others.arm_robot import TYPES as ARM_TYPES
from rosic_sim.ros2_others.arm_robot import ArmRobot
from rosic_sim.ros2_others.nav2_robot import TYPES as NAV2_TYPES
from rosic_sim.ros2_others.nav2_robot import Nav2Robot

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import FrameType

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.ros2.reports import DrawJpeg

LONGEST_TURN_S = 0.1
# So long before a common start nothing is told any more, as that may wait for other threads and
# their locks; then nothing is heard either: a motor's controller would not be late for it.
QUIET_S, HELD_S = 0.06, 0.015
# So long before, a process that was asked to be punctual asks for priority: after the longest turn.
URGENT_S = 2 * LONGEST_TURN_S
# Robots as others build them: only by name, as they take interfaces of other packages.
OTHERS: dict[str, tuple[tuple[str, ...], type[Nav2Robot | ArmRobot]]] = {
    "rover": (NAV2_TYPES, Nav2Robot),
    "picker": (ARM_TYPES, ArmRobot),
}
MACHINES: dict[str, type[Omni]] = {"omni": Omni, "rover": Rover, "watcher": FireWatcher}

KNOWN = (*MODELS, *OTHERS)

_Node: TypeAlias = MachineNode | Nav2Robot | ArmRobot


def main(arguments: Sequence[str] | None = None, draw: DrawJpeg | None = None) -> int:
    """Run robots until SIGTERM or Ctrl-C; says ``ready`` and their names once all are up.

    Args:
        arguments: Names of robots, all by default, and the options that ``--help`` lists.
        draw: Makes the frames of their cameras; None: they have none.

    Raises:
        ConfigurationError: ROS 2 is not here, or there is no such robot.
    """
    parser = argparse.ArgumentParser(
        prog="python -m rosic_sim.ros2.simulation", description=__doc__
    )
    parser.add_argument("robots", nargs="*", metavar="ROBOT", help=f"of {', '.join(KNOWN)}")
    parser.add_argument(
        "--actuations", type=Path, metavar="FILE", help="append a line whenever a robot acts"
    )
    parser.add_argument(
        "--starts", type=Path, metavar="FILE", help="append a line whenever a robot begins to move"
    )
    parser.add_argument(
        "--punctual",
        action="store_true",
        help="ask for real-time priority when a common start is near",
    )
    parser.add_argument(
        "--link-lost",
        type=float,
        default=LINK_LOST_S,
        metavar="SECONDS",
        help="hold, or land, after so long without a sign of life from the gateway (%(default)g)",
    )
    asked = parser.parse_args(arguments)
    robots = list(dict.fromkeys(asked.robots)) or list(MODELS)
    for robot in robots:
        if robot not in OTHERS and not model_of(robot):
            raise ConfigurationError(
                f"There is no simulated robot called {robot!r}; "
                f"{did_you_mean(robot, KNOWN, have='there are')}"
            )
    find_own_interfaces()
    find_interfaces(name for robot in robots for name in OTHERS.get(robot, ((),))[0])
    try:
        log, starts = ActuationLog(asked.actuations), ActuationLog(asked.starts)
    except OSError as error:
        raise ConfigurationError(
            f"{error.filename} cannot be written ({error.strerror})."
        ) from error
    stopping = _Stopping()
    try:
        urgency = RealtimePriority(wanted=asked.punctual)
        _run(robots, _Means(log, starts, urgency, draw, asked.link_lost), stopping)
    finally:
        log.close()
        starts.close()
    return 0


class _Means(NamedTuple):
    """What a process of robots has besides them.

    Attributes:
        log, starts: What is taken down.
        draw: Makes the frames of cameras; None: there are none.
        link_lost_s: So long without a sign of life of a gateway, and the link is lost.
    """

    log: ActuationLog
    starts: ActuationLog
    urgency: RealtimePriority
    draw: DrawJpeg | None
    link_lost_s: float


class _Stopping:
    """Set by SIGTERM and Ctrl-C."""

    def __init__(self) -> None:
        self.asked = False
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, self._ask)

    def _ask(self, _number: int, _frame: FrameType | None) -> None:
        self.asked = True


def _run(robots: Sequence[str], means: _Means, stopping: _Stopping) -> None:
    ros = load_ros()
    context = ros.rclpy.Context()
    ros.rclpy.init(context=context, signal_handler_options=ros.signals.SignalHandlerOptions.NO)
    executor = make_executor(ros, context)
    world, clock = _world(robots), WaitingClock()
    nodes: list[_Node] = []
    try:
        for robot in robots:
            ros_node = _node(ros, context, robot)
            executor.add_node(ros_node)
            nodes.append(_robot(ros_node, robot, world, clock, means))
            if means.draw is not None and isinstance(nodes[-1], MachineNode):
                nodes[-1].show(world, means.draw)
        machines = [node for node in nodes if isinstance(node, MachineNode)]
        gc.collect()
        gc.freeze()  # what lasts is looked through no more: that takes as long as a late start
        sys.stdout.write(f"ready {' '.join(robots)}\n")
        sys.stdout.flush()
        while not stopping.asked:
            if _wait(executor, clock, nodes, means.urgency):
                _act(machines, nodes)
    finally:
        executor.shutdown()
        for node in nodes:
            node.close()
        context.try_shutdown()


def _wait(
    executor: RosObject, clock: WaitingClock, nodes: Sequence[_Node], urgency: RealtimePriority
) -> bool:
    """Hear what comes until a robot wants its turn; tell whether it is time for turns."""
    now_s = clock.now_s()
    starts_s = (node.machine.start_s for node in nodes if isinstance(node, MachineNode))
    start_s = min((start_s for start_s in starts_s if start_s > now_s), default=inf)
    until_s = start_s - now_s
    urgency.be(until_s < URGENT_S)
    if until_s < HELD_S:
        time.sleep(until_s)
        return True
    if until_s < QUIET_S:
        wait_s = until_s - HELD_S
    else:
        wait_s = min(min(node.due_s for node in nodes) - now_s, until_s - QUIET_S)
    executor.spin_once(timeout_sec=min(max(wait_s, 0.0), LONGEST_TURN_S))
    return not 0.0 < start_s - clock.now_s() < QUIET_S


def _act(machines: Sequence[MachineNode], nodes: Sequence[_Node]) -> None:
    """Step all before any of them speaks."""
    for machine in machines:
        machine.step()
    for node in nodes:
        node.turn()


def _node(ros: RosObject, context: RosObject, robot: str) -> RosObject:
    name = OTHERS[robot][1].NODE_NAME if robot in OTHERS else NODE_NAME
    return ros.node.Node(name, namespace=f"/{robot}", context=context, use_global_arguments=False)


def _robot(
    node: RosObject, robot: str, world: SimulatedWorld, clock: WaitingClock, means: _Means
) -> _Node:
    if robot in OTHERS:
        return OTHERS[robot][1](node, robot, clock, means.log)
    watch = LinkWatchdog(means.link_lost_s)
    return MachineNode(node, robot, world, clock, means.log, starts=means.starts, watch=watch)


def _world(robots: Sequence[str]) -> SimulatedWorld:
    """Build the world, with every robot in it that is simulated here."""
    world = build_world(one_swarm=False)
    for robot in robots:
        if robot not in KNOWN:
            world.add(MACHINES[model_of(robot)](robot))
    return world


if __name__ == "__main__":
    try:
        sys.exit(main())
    except ConfigurationError as error:
        sys.stderr.write(f"{error}\n")
        sys.exit(2)
