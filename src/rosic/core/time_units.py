"""Lengths of time: in nanoseconds as clocks count, in seconds as limits are written."""

from __future__ import annotations

from typing import Final

MINUTE_S: Final = 60
HOUR_S: Final = 60 * MINUTE_S
DAY_S: Final = 24 * HOUR_S

SECOND_NS: Final = 1_000_000_000
MINUTE_NS: Final = MINUTE_S * SECOND_NS
HOUR_NS: Final = HOUR_S * SECOND_NS
DAY_NS: Final = DAY_S * SECOND_NS

MINUTES_A_DAY: Final = 24 * 60
