"""``rosic doctor``: what this machine and its robots are really like, measured."""

from __future__ import annotations

from rosic.app.setup.diagnostics import examine
from rosic.app.setup.diagnostics_checks import DiagnosticFinding, FindingVerdict

__all__ = ["DiagnosticFinding", "FindingVerdict", "examine"]
