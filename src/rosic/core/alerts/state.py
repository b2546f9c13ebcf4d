"""One rule about one robot, as time goes by: pending, raised, acknowledged, over.

A value machine: it is fed what the robot reports and what the clock says, and answers what is to
be told. The tests compare it with a few lines that say the same of a whole history.
"""

from __future__ import annotations

import enum

import msgspec

# An alarm that nobody sees is told so often; then it only stands in the list.
TOLD_AT_MOST = 12


class AlertReading(enum.Enum):
    """What one look at the robot says about a rule."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    BAD = "bad"
    BETWEEN = "between"
    """Not bad, and not yet so good that an alarm would end."""
    GOOD = "good"
    MISSING = "missing"
    """Not reported, or no number: it neither raises nor ends anything."""


class Phase(enum.Enum):
    """Where a rule is."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    OK = "ok"
    PENDING = "pending"
    RAISED = "raised"
    ACKNOWLEDGED = "acknowledged"


class AlertEvent(enum.Enum):
    """What is to be told now."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    RAISED = "raised"
    AGAIN = "again"
    """Raised before, and still so: after a restart, or when it is not muted any more."""
    ESCALATED = "escalated"
    CLEARED = "cleared"


class AlertTimes(msgspec.Struct, frozen=True):
    """How long things take, in nanoseconds.

    Attributes:
        lasting_ns: It is bad for so long, without a break, before it is raised.
        escalate_ns: Nobody has acknowledged it for so long: more people are told. 0: never.
    """

    lasting_ns: int
    escalate_ns: int = 0


class AlertWatch:
    """Follows one alert rule of one robot over time.

    Attributes:
        phase: Where it is.
        level: How often it was escalated.
    """

    __slots__ = ("_announced", "_pace", "_since_ns", "_told", "_told_ns", "level", "phase")

    def __init__(self, pace: AlertTimes) -> None:
        self._pace = pace
        self.phase = Phase.OK
        self.level = 0
        self._since_ns = 0
        self._told_ns = 0
        self._told = False  # since it was raised, or hushed
        self._announced = False  # somebody was told of this occurrence

    def restore(self, now_ns: int, *, acknowledged: bool, level: int) -> None:
        """Go on with an alarm of an earlier run: it is told again unless it was acknowledged."""
        self.phase = Phase.ACKNOWLEDGED if acknowledged else Phase.RAISED
        self._announced, self._told, self.level = True, acknowledged, level
        self._since_ns = now_ns

    def feed(self, reading: AlertReading, now_ns: int, *, muted: bool = False) -> AlertEvent | None:
        """Take one look in, and return what is to be told.

        Args:
            reading: What the robot reports.
            now_ns: Monotonic clock; never goes back.
            muted: Nothing is to be told now, except that what was told is over.
        """
        if self.open:
            if reading is AlertReading.GOOD:
                return self._over()
        elif reading is not AlertReading.BAD:
            self.phase = Phase.OK
        else:
            self._suspect(now_ns)
        if self.phase is not Phase.RAISED or muted:
            return None
        return self._news(reading, now_ns)

    def _suspect(self, now_ns: int) -> None:
        if self.phase is Phase.OK:
            self.phase, self._since_ns = Phase.PENDING, now_ns
        if now_ns - self._since_ns >= self._pace.lasting_ns:
            self.phase = Phase.RAISED
            self._told = self._announced = False
            self.level = 0

    def _news(self, reading: AlertReading, now_ns: int) -> AlertEvent | None:
        pace = self._pace
        if not self._told:
            unheard = reading is AlertReading.MISSING and now_ns - self._since_ns < pace.lasting_ns
            if self._announced and unheard:
                return None  # just begun anew: the robot may yet say that it is over
            event = AlertEvent.AGAIN if self._announced else AlertEvent.RAISED
            self._told, self._announced, self._told_ns = True, True, now_ns
            return event
        due = pace.escalate_ns and now_ns - self._told_ns >= pace.escalate_ns
        if not due or self.level >= TOLD_AT_MOST - 1:
            return None
        self.level += 1
        self._told_ns = now_ns
        return AlertEvent.ESCALATED

    def _over(self) -> AlertEvent | None:
        self.phase = Phase.OK
        self.level = 0
        return AlertEvent.CLEARED if self._announced else None

    @property
    def open(self) -> bool:
        """Whether it is raised and not over, seen or not."""
        return self.phase is Phase.RAISED or self.phase is Phase.ACKNOWLEDGED

    @property
    def announced(self) -> bool:
        """Whether somebody was told of what is open now."""
        return self.open and self._announced

    def acknowledge(self) -> bool:
        """Somebody has seen it: nothing more is told until it is over. Return whether it helped."""
        if self.phase is not Phase.RAISED:
            return False
        self.phase = Phase.ACKNOWLEDGED
        return True

    def hush(self) -> None:
        """It is muted: what is still so when that ends is told again, from the beginning."""
        self._told = False
        self.level = 0
