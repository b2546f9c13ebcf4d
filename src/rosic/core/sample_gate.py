"""What steers a live order: samples of its values, each checked before it counts (I6).

A live order is one whose values are replaced while it runs, by whoever holds a stick or a key. It
is a value machine, so that the tests of its properties drive the very same code.

How old a sample is, is told by its sender's clock, and how far that is from ours by what was
measured when the controls were opened, or by the first sample. Quicker samples set that right by no
more than `LATE_S` in all: a clock that is set forward makes nothing young again that has waited.
"""

from __future__ import annotations

import enum
from math import trunc
from sys import float_info
from typing import TYPE_CHECKING, Final, NamedTuple, TypeGuard

from rosic.core.i18n import said
from rosic.core.time_units import MINUTE_S, SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.identity import CommandId
    from rosic.core.robot.skill import Argument

LATE_S: Final = 0.3
"""An older sample steers nothing, and without a younger one what moves comes to rest."""
FIRST_WITHIN_S: Final = 2.0
"""For so long the first sample is waited for, once the robot's turn has come; nothing moves yet."""
LIVE_MOST_S: Final = 10.0 * MINUTE_S
"""Nobody drives for longer without beginning anew, whatever comes of their controls."""

LARGEST: Final = float_info.max
NAMED_AT_MOST: Final = 40

CONTROLS_SILENT: Final = "controls-silent"
"""The code of an outcome that ended because nothing came of the controls any more."""
LIVE_TIME_OVER: Final = "live-time-over"
"""The code of one that ended because it had lasted as long as it may."""


class SampleVerdict(enum.Enum):
    """What became of a sample. Only one that was taken steers anything."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    TAKEN = "taken"
    LATE = "late"
    """Older than `LATE_S`, or than the robot's own time-out."""
    AHEAD = "ahead"
    """From later than now: its sender's clock was set."""
    DISORDERED = "out-of-order"
    """A later one, or this very one, has come before."""
    NO_NUMBER = "no-number"
    """A value, its number or its time is no finite number."""
    UNFIT = "does-not-fit"
    """It names what this skill does not take, or what it does not bind is not zero."""
    ANOTHER = "another-order"
    """It was sent for another order."""
    WAITING = "waiting"
    """The robot's turn has not come yet."""
    OVER = "over"
    """The order has ended, or is ending: it steers nothing any more."""


class LiveEnd(enum.Enum):
    """Why a live order goes on no further, as far as its controls know."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    RELEASED = "released"
    SILENT = "silent"
    TIME_OVER = "time-over"
    CLOSED = "closed"
    """Something else has ended it: a stop, a right that is gone."""


class LiveSample(NamedTuple):
    """Values at one moment.

    Attributes:
        order: The id of the order that it steers.
        values: By parameter, SI; what is left out is zero.
        sent_ns: Its sender's wall clock when it was sent.
        sequence: Its number; each is higher than the one before.
    """

    order: CommandId
    values: Mapping[str, float]
    sent_ns: int
    sequence: int


class SampleResult(NamedTuple):
    """What became of a sample.

    Attributes:
        clamped: Parameters whose values were brought within what is allowed.
        sentence: What is wrong with it, for people; empty where the verdict says it all.
    """

    verdict: SampleVerdict
    clamped: tuple[str, ...] = ()
    sentence: str = ""

    @property
    def taken(self) -> bool:
        """Whether it steers the robot."""
        return self.verdict is SampleVerdict.TAKEN


class LiveRange(NamedTuple):
    """How far one parameter may be steered, SI, inclusive; zero always lies within.

    Attributes:
        integer: Only whole numbers; what lies between is brought towards zero.
    """

    name: str
    low: float
    high: float
    integer: bool = False


OVER: Final = SampleResult(SampleVerdict.OVER)


class SampleGate:
    """The samples of one live order: which of them count, and when there are too few.

    What has ended once stays ended: whatever comes later steers nothing.

    Attributes:
        ranges: How far each parameter may be steered.
        values: Of the newest sample that was taken, every parameter, SI.
        counts: How many samples became what; of a fixed size.
        clamped: How many of those that were taken were brought within the ranges.
        end: Why it goes on no further; None while it does.
        taken_ns: When the newest of them was sent, on our monotonic clock; 0: there was none.
        begun_ns: When the robot's turn came, on our monotonic clock; 0: it has not.
    """

    def __init__(
        self, order: CommandId, ranges: tuple[LiveRange, ...], fixed: Mapping[str, Argument]
    ) -> None:
        """Begin.

        Args:
            order: Whose samples count.
            ranges: How far its parameters may be steered.
            fixed: Its arguments that no sample changes.
        """
        self.order = order
        self.values: dict[str, Argument] = {**fixed}
        self.counts = dict.fromkeys(SampleVerdict, 0)
        self.clamped = 0
        self.end: LiveEnd | None = None
        self.taken_ns = self.begun_ns = 0
        self._late_ns = int(LATE_S * SECOND_NS)
        self._sequence: int | None = None
        self._offset_ns: int | None = None
        self._slack_ns = self._late_ns
        self._asked: Mapping[str, float] = {}
        self.confine(ranges)

    def confine(self, ranges: tuple[LiveRange, ...], most_s: float = LIVE_MOST_S) -> None:
        """Let other bounds count from now on: what is allowed has changed.

        What the newest sample said is brought within them at once.

        Args:
            ranges: How far each parameter may be steered.
            most_s: For how long at most, from the beginning.
        """
        self.ranges = ranges
        self._most_ns = int(min(LIVE_MOST_S, most_s) * SECOND_NS)
        self._by_name = {one.name: one for one in ranges}
        self._put(self._asked)

    def measure(self, theirs_ns: int, asked_ns: int) -> None:
        """Take in what the sender's clock showed when it was asked, before any sample.

        Args:
            theirs_ns: What it answered.
            asked_ns: When it was asked, on our monotonic clock: so no sample seems younger than it
                is.
        """
        if self._sequence is None:
            self._offset_ns = asked_ns - theirs_ns

    def begin(self, now_ns: int, *, watchdog_s: float) -> None:
        """Take samples from now on: the robot's turn has come.

        Args:
            now_ns: Our monotonic clock.
            watchdog_s: The robot's own time-out; a sample is late by the shorter one.
        """
        self.begun_ns = now_ns
        self._late_ns = int(min(LATE_S, watchdog_s) * SECOND_NS)

    @property
    def until_ns(self) -> int:
        """When it ends if nothing comes, on our monotonic clock."""
        first_ns = self.begun_ns + int(FIRST_WITHIN_S * SECOND_NS)
        silent_ns = self.taken_ns + self._late_ns if self.taken_ns else first_ns
        return min(silent_ns, self.begun_ns + self._most_ns)

    @property
    def most_s(self) -> float:
        """For how long it may last."""
        return self._most_ns / SECOND_NS

    def look(self, now_ns: int) -> LiveEnd | None:
        """Return why nothing may be sent any more; None: the newest values may, now."""
        if self.end is None and self.begun_ns and now_ns > self.until_ns:
            over = now_ns > self.begun_ns + self._most_ns
            self.end = LiveEnd.TIME_OVER if over else LiveEnd.SILENT
        return self.end

    def release(self) -> None:
        """Whoever steers has let go."""
        self.close(LiveEnd.RELEASED)

    def close(self, end: LiveEnd = LiveEnd.CLOSED) -> None:
        """Let nothing more be steered; why it ended first is what counts."""
        if self.end is None:
            self.end = end

    def take(self, sample: LiveSample, now_ns: int) -> SampleResult:
        """Take a sample in, or drop it; each is counted.

        Args:
            sample: As it came.
            now_ns: Our monotonic clock.
        """
        result = self._take(sample, now_ns)
        self.counts[result.verdict] += 1
        self.clamped += bool(result.clamped)
        return result

    def _take(self, sample: LiveSample, now_ns: int) -> SampleResult:
        if self.look(now_ns) is not None:
            return OVER
        sent_ns = self._in_time(sample, now_ns)
        if isinstance(sent_ns, SampleVerdict):
            return SampleResult(sent_ns)
        refused = self._unfit(sample.values)
        if refused is not None:
            return refused
        if not self.begun_ns:
            return SampleResult(SampleVerdict.WAITING)
        self.taken_ns = max(self.taken_ns, sent_ns)
        return SampleResult(SampleVerdict.TAKEN, self._put(sample.values))

    def _in_time(self, sample: LiveSample, now_ns: int) -> int | SampleVerdict:
        """Return when a sample was sent, on our monotonic clock, or why it does not count."""
        if sample.order != self.order:
            return SampleVerdict.ANOTHER
        if not (_is_whole(sample.sent_ns) and _is_whole(sample.sequence)):
            return SampleVerdict.NO_NUMBER
        if self._sequence is not None and sample.sequence <= self._sequence:
            return SampleVerdict.DISORDERED
        self._sequence = sample.sequence
        sent_ns = self._sent_ns(sample.sent_ns, now_ns)
        if sent_ns is None:
            return SampleVerdict.AHEAD
        return SampleVerdict.LATE if now_ns - sent_ns > self._late_ns else sent_ns

    def _sent_ns(self, theirs_ns: int, now_ns: int) -> int | None:
        """Return when a sample was sent, on our clock, never later than now; None: after that."""
        if self._offset_ns is None:
            self._offset_ns = now_ns - theirs_ns
        ahead_ns = theirs_ns + self._offset_ns - now_ns
        if ahead_ns > self._slack_ns:
            return None
        if ahead_ns <= 0:
            return now_ns + ahead_ns
        self._offset_ns -= ahead_ns  # what told how far the clocks are apart was slower than this
        self._slack_ns -= ahead_ns
        return now_ns

    def _unfit(self, values: Mapping[str, float]) -> SampleResult | None:
        for name, value in values.items():
            if name not in self._by_name:
                sentence = said("{name} cannot be steered.", name=str(name)[:NAMED_AT_MOST])
                return SampleResult(SampleVerdict.UNFIT, (), sentence)
            if not is_finite_number(value):
                return _no_number(name)
        return None

    def _put(self, values: Mapping[str, float]) -> tuple[str, ...]:
        """Bring values within the ranges, and let them count; return which were changed."""
        self._asked = values
        clamped: tuple[str, ...] = ()
        for one in self.ranges:
            value = values.get(one.name, 0.0)
            within = _within(one, value)
            if within != value:
                clamped += (one.name,)
            self.values[one.name] = within
        return clamped


def _within(one: LiveRange, value: float) -> float:
    within = min(max(value, one.low), one.high)
    return trunc(within) if one.integer else float(within)


def _is_whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def is_finite_number(value: object) -> TypeGuard[float]:
    """Whether something is a number that can be sent."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= LARGEST  # not so of what is no number, nor of what no float can hold


def _no_number(name: str) -> SampleResult:
    sentence = said("{name} is no finite number.", name=name[:NAMED_AT_MOST])
    return SampleResult(SampleVerdict.NO_NUMBER, (), sentence)
