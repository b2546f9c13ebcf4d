"""Real ROS 2 nodes for tests: each test on a graph of its own, in processes of their own."""

from __future__ import annotations
