"""Since when we have listened without a gap: a value machine, fed with what the polls did.

What was sent while nobody listened is backlog. It is stamped as such explicitly
(``listening_since_ns`` one above the receive time), so that no clock decides it. Afterwards the
stamp is the moment at which the poll that found nothing was asked, less a grace: Telegram cuts the
date of a message to whole seconds, and its clock is not ours. Without the grace the first messages
after every start would be refused as backlog. It cannot let backlog in: that came earlier, stamped.
"""

from __future__ import annotations

from typing import NamedTuple

from rosic.core.time_units import SECOND_NS
from rosic.messengers.telegram.errors import NetworkState

GAP_NS = 5 * SECOND_NS
JUMP_NS = 2 * SECOND_NS
"""Wall and monotonic clock may drift this far apart between two polls. More is a clock that was
set, or a machine that slept: the monotonic clock stands still meanwhile."""
CALM_NS = 15 * SECOND_NS
"""How long nobody else may have received for this bot before it counts as ours again."""
GRACE_NS = 2 * SECOND_NS
"""One second for the cut date, one for clocks that differ."""
BETWEEN_NS = 70 * SECOND_NS
"""From one poll that failed to the next at the most, while we run."""
SHORT_POLLS = 3
"""So many polls in a row that were not full show an empty backlog as well: with people writing all
the time, no poll comes back empty."""


class PollMoment(NamedTuple):
    """One moment on both clocks."""

    wall_ns: int
    monotonic_ns: int


class Outage:
    """When the network was away, as far as the polls have seen.

    From the first of some polls in a row that failed until the first that did not, if one of them
    found no way to anybody, and none an answer. Nothing is said of a time in which we did not run.
    """

    def __init__(self) -> None:
        self._from_ns = self._since_ns = self._until_ns = 0
        self._away = self._answered = False
        self._looked_ns = 0

    def failed(
        self, asked: PollMoment, now: PollMoment, network: NetworkState, within_s: float
    ) -> None:
        """Note that a poll failed.

        Args:
            asked: When it was asked.
            now: When it had failed.
            network: What it shows.
            within_s: How long it may have taken; in more, we did not run all the time.
        """
        took_ns = max(now.wall_ns - asked.wall_ns, now.monotonic_ns - asked.monotonic_ns)
        waited_ns = asked.wall_ns - self._looked_ns
        if not self._since_ns or waited_ns > BETWEEN_NS:
            self._since_ns = asked.wall_ns
        if took_ns > within_s * SECOND_NS:
            self._since_ns = now.wall_ns
        self._looked_ns = now.wall_ns
        self._away = self._away or network is NetworkState.AWAY
        self._answered = self._answered or network is NetworkState.THERE

    def answered(self, asked: PollMoment) -> None:
        """Note that a poll succeeded; call it before stamping what it brought."""
        if self._away and not self._answered:
            self._from_ns, self._until_ns = self._since_ns, asked.wall_ns
        self._since_ns, self._away, self._answered = 0, False, False

    def over(self) -> None:
        """Everything that was sent meanwhile has been received."""
        self._from_ns = self._until_ns = 0

    def covers(self, sent_ns: int) -> bool:
        """Whether what was sent in a second, by its beginning, was sent while it was away."""
        return self._from_ns <= sent_ns and sent_ns + SECOND_NS <= self._until_ns


class PollingGap:
    """Frozen until the backlog has been drained.

    Attributes:
        frozen: What is received now is backlog.
        since_ns: Wall clock; has a meaning while not frozen.
    """

    def __init__(self) -> None:
        self.frozen = True
        self.since_ns = 0
        self._answered: PollMoment | None = None
        self._calm_from_ns = 0
        self._short = 0

    def contested(self, now: PollMoment) -> None:
        """Somebody else received for this bot: what they took, nobody here knows."""
        self._freeze()
        self._calm_from_ns = now.monotonic_ns + CALM_NS

    def calm(self, now: PollMoment) -> bool:
        """Whether the bot is ours alone, as far as anybody can tell."""
        return now.monotonic_ns >= self._calm_from_ns

    def answered(self, now: PollMoment) -> None:
        """Note that a poll succeeded; call it before stamping what it brought."""
        last, self._answered = self._answered, now
        if last is None:
            return
        apart_ns = now.monotonic_ns - last.monotonic_ns
        jumped_ns = now.wall_ns - last.wall_ns - apart_ns
        if apart_ns > GAP_NS or abs(jumped_ns) > JUMP_NS:
            self._freeze()

    def stamp(self, received_ns: int) -> int:
        """Return ``listening_since_ns`` for a message received now."""
        return received_ns + 1 if self.frozen else self.since_ns

    def drained(self, asked: PollMoment, *, empty: bool, full: bool) -> bool:
        """Note what the poll brought, after it was stamped; thaw if that was the backlog.

        Args:
            asked: When the poll was asked.
            empty: It brought nothing new.
            full: It brought as much as fits into an answer.

        Returns:
            True at the moment of thawing.
        """
        if not self.frozen:
            return False
        self._short = 0 if full else self._short + 1
        through = (empty and not full) or self._short >= SHORT_POLLS
        if not through or not self.calm(asked):
            return False
        self.frozen = False
        self.since_ns = asked.wall_ns - GRACE_NS
        return True

    def _freeze(self) -> None:
        self.frozen = True
        self._short = 0
