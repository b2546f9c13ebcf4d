"""`python ros_robots.py ROBOT...`: the simulated robots as ROS 2 nodes, with their cameras."""

from __future__ import annotations

import sys

from rosic.rendering.renderer import jpeg_drawer
from rosic_sim.ros2.simulation import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:], jpeg_drawer()))
