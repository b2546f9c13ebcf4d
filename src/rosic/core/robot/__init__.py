"""What a robot is: its profile, skills, limits, and what is known of it now."""

from __future__ import annotations
