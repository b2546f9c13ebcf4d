"""Between ROS 2 messages and plain values, checked field by field."""

from __future__ import annotations
