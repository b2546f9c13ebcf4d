"""How the simulated robots look: solids for somebody else to draw. Values in, values out."""

from __future__ import annotations
