"""Alarms from what robots report: who is told, who has seen it, what the robot does then."""

from __future__ import annotations
