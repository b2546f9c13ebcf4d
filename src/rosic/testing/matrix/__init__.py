"""A real homeserver of Matrix on this machine alone, for tests and benches."""

from __future__ import annotations

from rosic.testing.matrix.synapse import DOMAIN, Account, HomeserverFault, Synapse

__all__ = ["DOMAIN", "Account", "HomeserverFault", "Synapse"]
