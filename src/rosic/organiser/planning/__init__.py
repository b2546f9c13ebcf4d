"""Plans for a week: who gets a robot when, from what people wish for."""

from __future__ import annotations
