"""A policy that is nothing but its number."""

from __future__ import annotations


class Policy:
    """What is in force, as far as a linker asks."""

    def __init__(self, epoch: int) -> None:
        self.epoch = epoch
