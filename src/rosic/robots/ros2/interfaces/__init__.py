"""Interfaces that no distribution ships, built in seconds where there is no colcon.

`rosic_interfaces` beside this file is an ordinary ROS 2 package: in a workspace, build it like any
other. Where ROS 2 came as Python wheels, ``python -m rosic.robots.ros2.interfaces --output DIR``
generates and compiles it, or any other package of messages, services and actions.
"""

from __future__ import annotations
