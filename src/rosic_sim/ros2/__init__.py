"""Simulated robots as ROS 2 nodes: the machines of `rosic_sim.robots`, met over the graph."""

from __future__ import annotations
