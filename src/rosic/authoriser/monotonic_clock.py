"""A calendar clock that never goes back, so that what has ended does not begin again.

The machine's clock may be set back by hand, by a flat battery or by somebody who wants an old
code to be good again. Here time is the machine's clock or the highest time seen so far plus what
has passed since on the monotonic clock, whichever is later.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.records import Fact
from rosic.core.signal import Signal
from rosic.core.time_units import MINUTE_NS, SECOND_NS

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock

KIND: Final = "high-water"
KEY: Final = "wall"
EVERY_NS: Final = MINUTE_NS
BEHIND_NS: Final = 2 * SECOND_NS
"""Less is how clocks are kept right."""

_log = logging.getLogger(__name__)


class WallClockMark(msgspec.Struct, frozen=True):
    """The body of the fact.

    Attributes:
        wall_ns: Wall clock.
        accepted: The owner of the machine has said that this is the right time, although it is
            earlier than one seen before.
    """

    wall_ns: int
    accepted: bool = False


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(WallClockMark).decode


class MonotonicWallClock:
    """A clock whose calendar time is never earlier than it was.

    Whatever begins or ends by the calendar asks this one: keys, grants, invitations, slots.

    Attributes:
        monotonic_ns, sleep: Those of the clock it is made from.
        behind: The machine's clock was set back, by more than two seconds, and is not accepted.
        when_behind: Tells whenever that changes.
        when_ahead: Tells the nanoseconds that the machine's clock was set forward by, when
            more than two seconds: the machine may have been paused, and what was to end by the
            monotonic clock is older than that says.
    """

    def __init__(self, clock: Clock) -> None:
        self.monotonic_ns = clock.monotonic_ns
        self.sleep = clock.sleep
        self.behind = False
        self.when_behind: Signal[[bool]] = Signal()
        self.when_ahead: Signal[[int]] = Signal()
        self._machine_ns = clock.wall_ns
        # By how much the highest time seen is ahead of the monotonic clock.
        self._ahead_ns = clock.wall_ns() - clock.monotonic_ns()
        self._written_ns = 0

    def wall_ns(self) -> int:
        """Return Unix time in nanoseconds; never less than before."""
        now_ns = self.monotonic_ns()
        ahead_ns = self._machine_ns() - now_ns
        lost_ns = self._ahead_ns - ahead_ns
        if lost_ns <= 0:
            self._ahead_ns = ahead_ns
            if lost_ns < -BEHIND_NS:
                self.when_ahead.emit(-lost_ns)
        if (lost_ns > BEHIND_NS) is not self.behind:
            self.behind = not self.behind
            self.when_behind.emit(self.behind)
        return now_ns + self._ahead_ns

    def behind_s(self) -> float:
        """Return by how many seconds the machine's clock is behind the highest time seen."""
        return (self.wall_ns() - self._machine_ns()) / 1e9

    def due(self) -> tuple[Fact, ...]:
        """Return the fact to write, at most one a minute: to be asked for every now and then."""
        now_ns = self.wall_ns()
        return (self.mark(),) if now_ns - self._written_ns >= EVERY_NS else ()

    def mark(self) -> Fact:
        """Return the fact that says how late it is, to be written at the end of a run."""
        return Fact(kind=KIND, key=KEY, body=_encode(WallClockMark(self.wall_ns())))

    def accept(self) -> Fact:
        """Return the fact by which the machine's clock counts again, for the owner to decide.

        What ended between that time and the highest one may be good again.
        """
        return Fact(
            kind=KIND, key=KEY, body=_encode(WallClockMark(self._machine_ns(), accepted=True))
        )

    def apply(self, fact: Fact) -> None:
        """Take over what was written, now or in an earlier run."""
        try:
            mark = _decode(fact.body)
        except msgspec.MsgspecError:
            _log.warning("the highest time seen cannot be read; the machine's clock counts")
            return
        highest_ns = mark.wall_ns if mark.accepted else max(self.wall_ns(), mark.wall_ns)
        self._ahead_ns = highest_ns - self.monotonic_ns()
        self._written_ns = mark.wall_ns
        self.wall_ns()
