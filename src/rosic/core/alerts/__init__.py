"""Conditions, rules and states of alerts."""

from __future__ import annotations
