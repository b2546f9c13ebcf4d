"""Adapters that each break one rule: what the conformance suites must catch."""

from __future__ import annotations
