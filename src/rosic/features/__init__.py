"""What a person would call a capability; none of them knows another."""

from __future__ import annotations
