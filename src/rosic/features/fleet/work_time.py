"""How long robots were at work in the last days: added up as it happens, kept over restarts.

Of each robot and quarter of an hour is kept how many seconds it was at work, eight days back: what
it costs to ask does not grow with the past.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.records import Fact
from rosic.core.time_units import DAY_NS, MINUTE_NS, SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from rosic.contracts.clock import Clock
    from rosic.core.robot.profile import RobotId

KIND: Final = "work-time"
QUARTER_NS: Final = 15 * MINUTE_NS
DAYS: Final = 8
A_DAY: Final = DAY_NS // QUARTER_NS
WRITTEN_EVERY_S: Final = 60.0

_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(dict[int, float]).decode


class WorkTime:
    """Adds up the time at work of each robot; wall clock.

    Args:
        now_ns: When nothing is known of before, counting begins here.
    """

    def __init__(self, now_ns: int) -> None:
        self._begun_ns = now_ns
        # Of each robot and day, counted from 1970: seconds in each quarter of an hour.
        self._days: dict[tuple[RobotId, int], dict[int, float]] = {}
        self._unwritten: set[tuple[RobotId, int]] = set()

    def add(self, robot: RobotId, begin_ns: int, end_ns: int) -> None:
        """A robot was at work; more than eight days of it are not kept."""
        begin_ns = max(begin_ns, end_ns - DAYS * DAY_NS)
        while begin_ns < end_ns:
            quarter = begin_ns // QUARTER_NS
            until_ns = min(end_ns, (quarter + 1) * QUARTER_NS)
            key = robot, quarter // A_DAY
            there = self._days.setdefault(key, {})
            there[quarter] = there.get(quarter, 0.0) + (until_ns - begin_ns) / SECOND_NS
            self._unwritten.add(key)
            begin_ns = until_ns

    def worked_s(self, robot: RobotId, since_ns: int, now_ns: int) -> float:
        """Return the seconds of work since a full quarter of an hour, at most eight days ago."""
        first = -(-since_ns // QUARTER_NS)
        return sum(
            seconds
            for day in range(first // A_DAY, now_ns // DAY_NS + 1)
            for quarter, seconds in self._days.get((robot, day), {}).items()
            if quarter >= first
        )

    def counted_s(self, since_ns: int, now_ns: int) -> float:
        """Return for how much of the time since then was counted at all."""
        return max(0, now_ns - max(since_ns, self._begun_ns)) / SECOND_NS

    # ---- on disk ----

    def facts(self, now_ns: int) -> Iterator[Fact]:
        """Yield what has changed since the last time, and let go what is older than eight days."""
        oldest = now_ns // DAY_NS - DAYS
        over = [key for key in self._days if key[1] < oldest]
        for key in over:
            del self._days[key]
            yield Fact(kind=KIND, key=_key(*key), body=b"")
        for key in self._unwritten.difference(over):
            yield Fact(kind=KIND, key=_key(*key), body=_encode(self._days[key]))
        self._unwritten.clear()

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote; what cannot be read was no work."""
        for fact in facts:
            robot, _, day = fact.key.rpartition(" ")
            try:
                found = _decode(fact.body) if fact.body else {}
            except msgspec.MsgspecError:
                continue
            if found and day.isdigit():
                self._days[robot, int(day)] = found
                self._begun_ns = min(self._begun_ns, min(found) * QUARTER_NS)

    def apply(self, fact: Fact) -> None:
        """Nothing: it says what was added here before it was written."""


def _key(robot: RobotId, day: int) -> str:
    return f"{robot} {day}"


class WorkTimeStore:
    """Writes down once a minute what was added up.

    Args:
        hours: What is added up.
        settle: Adds what goes on at this moment.
        note: Writes soon, without waiting.
    """

    def __init__(
        self,
        hours: WorkTime,
        clock: Clock,
        settle: Callable[[], None],
        note: Callable[[tuple[Fact, ...]], None],
    ) -> None:
        self._hours, self._clock, self._settle, self._note = hours, clock, settle, note
        self._running: asyncio.Task[None] | None = None

    def run(self) -> None:
        """Begin."""
        self._running = asyncio.create_task(self._run())

    async def _run(self) -> None:
        while True:
            await self._clock.sleep(WRITTEN_EVERY_S)
            self.write()

    def write(self) -> None:
        """Write what has changed."""
        self._settle()
        facts = tuple(self._hours.facts(self._clock.wall_ns()))
        if facts:
            self._note(facts)

    async def close(self) -> None:
        """Write for the last time."""
        if self._running is not None:
            self._running.cancel()
            await asyncio.gather(self._running, return_exceptions=True)
            self.write()
