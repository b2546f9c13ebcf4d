"""Adapters between people's messengers and the pipeline; each owes `contracts.messenger`."""

from __future__ import annotations
