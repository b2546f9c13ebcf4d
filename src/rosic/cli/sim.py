"""``rosic sim``: the simulated robots as ROS 2 nodes, with their own watchdogs."""

from __future__ import annotations

import argparse
from importlib import import_module
from typing import TYPE_CHECKING

from rosic.rendering.renderer import jpeg_drawer
from rosic.robots.ros2.client.rclpy_import import load_ros

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Run simulated robots as ROS 2 nodes, for gateways that reach them over ROS 2, until
Ctrl-C. Without names: kuka1, omni, yumi, cf1, cf2 and cf3. By name alone: rover and picker, as
others build robots, and those of the plays: watch, carrier1, rover1. To try them without ROS:
rosic demo."""
NODES = "rosic_sim.ros2.simulation"


def run(arguments: Sequence[str]) -> int:
    """Run the nodes.

    Raises:
        RosMissing: ROS 2 is not here.
    """
    parser = argparse.ArgumentParser(prog="rosic sim", description=ABOUT)
    parser.add_argument("robots", metavar="ROBOT", nargs="*")
    parser.add_argument("--ros2", action="store_true", help="as ROS 2 nodes; the only way so far")
    parser.add_argument(
        "--link-lost",
        type=float,
        metavar="SECONDS",
        help="hold, or land, after so long without a sign of life from the gateway",
    )
    options = parser.parse_args(arguments)
    load_ros()
    lost = [] if options.link_lost is None else [f"--link-lost={options.link_lost:g}"]
    status = import_module(NODES).main([*options.robots, *lost], jpeg_drawer())
    return status if isinstance(status, int) else 0
