"""Chance as an argument."""

from __future__ import annotations

from typing import Protocol


class Entropy(Protocol):
    """Unguessable bytes."""

    def token(self, length: int) -> bytes:
        """Return ``length`` bytes fit for secrets; a test may own the sequence."""
        ...
