"""``rosic bench``: measure how fast ROSIC is here."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence


def run(arguments: Sequence[str]) -> int:
    """Hand over to the benches: edges of the house do not import each other."""
    return int(import_module("rosic.bench").main(arguments))
