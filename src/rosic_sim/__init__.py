"""Simulated robots, their ROS 2 nodes, and the scenarios of `rosic demo`."""

from __future__ import annotations
