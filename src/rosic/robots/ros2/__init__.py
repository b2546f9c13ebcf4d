"""Robots on a ROS 2 graph. Nothing here imports rclpy before a runtime is opened."""

from __future__ import annotations
