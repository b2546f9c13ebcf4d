"""How robots do against what is expected of them, and how they are set: Algorithm 2."""

from __future__ import annotations
