"""``rosic doctor``: what this machine and its robots are really like, measured."""

from __future__ import annotations

from rosic.app.doctor.examination import examine
from rosic.app.doctor.findings import Finding, Verdict

__all__ = ["Finding", "Verdict", "examine"]
