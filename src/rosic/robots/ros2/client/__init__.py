"""What ROSIC asks of rclpy: one node, its thread, topics, services, actions."""

from __future__ import annotations
