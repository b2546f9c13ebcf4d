"""The terminal as a messenger: one person, sitting at the machine or piping a script into it."""

from __future__ import annotations

from rosic.messengers.terminal.messenger import TerminalMessenger, terminal_messenger

__all__ = ["TerminalMessenger", "terminal_messenger"]
