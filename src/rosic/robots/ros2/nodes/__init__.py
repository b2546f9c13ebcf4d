"""Simulated robots as ROS 2 nodes: the machines of `rosic.robots.simulated`, met over the graph."""

from __future__ import annotations
