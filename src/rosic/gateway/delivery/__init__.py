"""What is said to people: queued per chat, sent, refreshed, never lost."""

from __future__ import annotations
