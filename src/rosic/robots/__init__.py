"""Adapters to robots: over ROS 2, simulated in process, and in memory."""

from __future__ import annotations
