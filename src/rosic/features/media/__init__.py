"""Seeing: pictures, clips, maps, charts and ways, for whoever may read the robot."""

from __future__ import annotations
