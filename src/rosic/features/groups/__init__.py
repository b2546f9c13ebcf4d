"""Groups, their topics, and channels for reading."""

from __future__ import annotations
