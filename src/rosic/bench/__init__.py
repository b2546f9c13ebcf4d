"""Measurements that people can run: ``rosic bench NAME``."""

from __future__ import annotations

from rosic.bench.command import main

__all__ = ["main"]
