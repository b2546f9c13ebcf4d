"""Flood control: who must wait, and how long.

https://core.telegram.org/bots/faq#my-bot-is-hitting-limits-how-do-i-avoid-this and, for the answer,
https://core.telegram.org/bots/api#responseparameters (`retry_after`).
"""

from __future__ import annotations

from collections import deque
from math import ceil
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.testing.telegram.settings import Limits

GROUP_WINDOW_S = 60.0
SECOND_S = 1.0
UNDER_WAY_S = 0.25
CLOCK_SLACK_S = 0.05


class TokenBucket:
    """A token bucket that starts full."""

    def __init__(self, per_s: float, burst: float) -> None:
        self._per_s = per_s
        self._burst = burst
        self._left = burst
        self._at_s: float | None = None

    def wait_s(self, now_s: float) -> float:
        """Return how long until one token is there; 0 when it is."""
        if self._at_s is not None:
            gained = max(0.0, now_s - self._at_s) * self._per_s
            self._left = min(self._burst, self._left + gained)
        self._at_s = now_s
        # A hair of slack: who waits exactly as long as told is let through.
        return 0.0 if self._left >= 1.0 - 1e-6 else (1.0 - self._left) / self._per_s

    def take(self) -> None:
        """Spend one token."""
        self._left -= 1.0


class Window:
    """At most so many within any time of a length; an hour's quiet earns nothing."""

    def __init__(self, most: int, span_s: float) -> None:
        self._most = most
        self._span_s = span_s
        self._times: deque[float] = deque()

    def wait_s(self, now_s: float) -> float:
        """Return how long until one more is allowed; 0 when it is."""
        while self._times and self._times[0] <= now_s - self._span_s:
            self._times.popleft()
        if len(self._times) < self._most:
            return 0.0
        return self._times[0] + self._span_s - now_s

    def take(self, now_s: float) -> None:
        """Count one."""
        self._times.append(now_s)


class Limiter:
    """Counts what is sent and edited, by chat, by group and overall.

    Attributes:
        limits: None switches everything off.
    """

    def __init__(self, limits: Limits | None) -> None:
        self.limits = limits
        self._chats: dict[int, TokenBucket] = {}
        self._groups: dict[int, Window] = {}
        self._overall: Window | None = None
        self._told: dict[int, tuple[float, float]] = {}

    def told(self, chat_id: int, retry_after_s: int, now_s: float) -> None:
        """Remember that the bot was told to wait."""
        self._told[chat_id] = (now_s, now_s + retry_after_s)

    def impatient_s(self, chat_id: int, now_s: float) -> float:
        """Return how many seconds too early a call comes that follows a 429; 0 when it does not.

        Calls that were under way when the 429 was given are forgiven.
        """
        told_s, until_s = self._told.get(chat_id, (0.0, 0.0))
        early_s = until_s - now_s
        return early_s if now_s > told_s + UNDER_WAY_S and early_s > CLOCK_SLACK_S else 0.0

    def set(self, limits: Limits | None) -> None:
        """Start anew under other limits."""
        self.limits = limits
        self._chats.clear()
        self._groups.clear()
        self._overall = None

    def retry_after_s(self, chat_id: int, *, is_group: bool, now_s: float) -> int:
        """Count one message or edit, or say how long to wait.

        Returns:
            0 when it was counted and may pass; else whole seconds, and nothing was counted.
        """
        limits = self.limits
        if limits is None:
            return 0
        if self._overall is None:
            self._overall = Window(max(1, int(limits.overall_per_s)), SECOND_S)
        chat = self._chats.setdefault(chat_id, TokenBucket(limits.chat_per_s, limits.chat_burst))
        window = self._groups.setdefault(chat_id, Window(limits.group_per_min, GROUP_WINDOW_S))
        wait_s = max(chat.wait_s(now_s), self._overall.wait_s(now_s))
        if is_group:
            wait_s = max(wait_s, window.wait_s(now_s))
        if wait_s > 0:
            return max(limits.min_retry_after_s, ceil(wait_s))
        chat.take()
        self._overall.take(now_s)
        if is_group:
            window.take(now_s)
        return 0
