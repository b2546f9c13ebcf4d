"""Robots as others build them: Nav2 and ros2_control as they meet ROSIC, without either of them."""

from __future__ import annotations
