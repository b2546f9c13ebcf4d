"""Strategies: named ways to do the same work, as a robot's profile declares them."""

from __future__ import annotations

import msgspec

from rosic.core.robot.skill import Parameter


class Strategy(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A named strategy.

    Attributes:
        parameters: What can be said of it: a speed cap, a spacing. What is left out takes its
            default; one without a default must be said.
    """

    title: str = ""
    parameters: dict[str, Parameter] = {}
