"""Scopes: what one word of a right names."""

from __future__ import annotations

import re

import msgspec

from rosic.core.i18n import said

READ = "read"
RESUME = "resume"
FILES = "files"
"""The right to put files into a robot's inbox, and to fetch those it gives."""
SHARE = "share"
"""The right to share data in a robot's name: its own, and nobody else's."""
ASK = "ask"
"""Of itself: to ask for help. Of another: to speak to it."""
HELP = "help"
"""The right to accept a robot's request for help."""
STRATEGY = "strategy"
"""The right to change a robot's strategy."""
AMONG = (SHARE, ASK, HELP, STRATEGY)
"""What robots may be to each other (Algorithm 5); people who help or adjust hold the same."""

SCOPE = re.compile(r"[a-z0-9_*?-]+:[a-z0-9_*?-]+\Z")


class Scope(msgspec.Struct, frozen=True):
    """``robot:skill`` with wildcards: ``kuka1:grasp``, ``crazyflie-*:*``, ``*:read``."""

    robot: str
    skill: str

    @classmethod
    def parse(cls, text: str) -> Scope:
        """Read a scope.

        Raises:
            ValueError: Not of the form ``robot:skill``.
        """
        if not SCOPE.match(text):
            raise ValueError(
                said("{text!r} is not a scope: write robot:skill, for example omni:move", text=text)
            )
        robot, _, skill = text.partition(":")
        return cls(robot, skill)
