"""The chat side of time: booking, seeing, cancelling, waiting, and the task that follows them."""

from __future__ import annotations
