"""Scopes: what one word of a right names."""

from __future__ import annotations

import re

import msgspec

from rosic.core.saying import said

READ = "read"
RESUME = "resume"
FILES = "files"
"""The right to put files into a robot's inbox, and to fetch those it gives."""

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
