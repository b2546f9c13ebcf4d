"""Robots among themselves (Algorithm 5): they share, ask, help, and people read and interrupt."""

from __future__ import annotations
