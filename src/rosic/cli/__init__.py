"""What a person meets outside the chat: the ``rosic`` command."""

from __future__ import annotations

from rosic.cli.main import main

__all__ = ["main"]
