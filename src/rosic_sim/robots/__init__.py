"""Simulated robots: the four machines of the paper's Figure 5, and what carries orders to them."""

from __future__ import annotations
