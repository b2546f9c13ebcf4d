"""The one way a message travels: authoriser, organiser, container, linker; and back."""

from __future__ import annotations

from rosic.gateway.pipeline import Pipeline

__all__ = ["Pipeline"]
