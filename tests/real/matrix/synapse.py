"""The homeserver that tests start, and wait for as long as this machine needs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.testing.matrix import DOMAIN, Account, HomeserverFault, Synapse
from tests.pace import pace
from tests.servers import synapse_python

if TYPE_CHECKING:
    from pathlib import Path

__all__ = ["DOMAIN", "Account", "HomeserverFault", "Synapse", "synapse_in"]


def synapse_in(folder: Path, **settings: object) -> Synapse:
    """Prepare one in an empty folder; skip the test that asks, where it is not installed."""
    return Synapse(folder, synapse_python(), patience=pace(), **settings)
