"""What a robot reports: the newest values in the profile's units, and whether it is at rest."""

from __future__ import annotations

import asyncio
import logging
from contextlib import suppress
from math import hypot, isfinite, pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.time_units import SECOND_NS
from rosic.robots.ros2.client.kept_topics import KeptTopics
from rosic.robots.ros2.errors import BadValue
from rosic.robots.ros2.messages.coerce import clean_text
from rosic.robots.ros2.messages.decode import FieldReader, Plain, compile_path
from rosic.robots.ros2.rest_reading import ODOMETRY, RestReading, numbers

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rosic.contracts.clock import Clock
    from rosic.robots.ros2.client.graph import GraphSnapshot
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.topics import LatestMessage
    from rosic.robots.ros2.profile import Ros2Profile


# ---- reported units ----

# What robots report, in the units that a profile shows it in.

_log = logging.getLogger(__name__)

PERCENT: Final = "%"
FULL: Final = 1.1
"""No share is larger: a battery may say 102 %."""
# Robots report SI, and a battery as a fraction (REP 103, sensor_msgs/BatteryState).
FACTORS: Final[Mapping[str, float]] = MappingProxyType(
    {
        PERCENT: 100.0,
        "deg": 180.0 / pi,
        "deg/s": 180.0 / pi,
        "cm": 100.0,
        "cm/s": 100.0,
        "mm": 1000.0,
        "mm/s": 1000.0,
        "km": 0.001,
        "km/h": 3.6,
    }
)


class UnitScale:
    """Turns one reported value into the profile's unit.

    Many a battery says its charge in per cent, against the definition of its message: one that has
    once said more than a fraction can be is read so for good, also when it is nearly empty. Before
    that it is known only where the profile says so.

    Attributes:
        guessed: It was taken for per cent though the profile says nothing of it.
    """

    def __init__(self, unit: str, what: str, full: float = 1.0) -> None:
        """Make it.

        Args:
            unit: As the profile shows it.
            what: Whose value, for the log.
            full: What a whole share is reported as.
        """
        self.guessed = False
        self._unit = unit
        self._what = what
        self._factor = FACTORS.get(unit, 1.0) / (full if unit == PERCENT else 1.0)
        self._guesses = unit == PERCENT and full == 1.0

    def __call__(self, value: float) -> float:
        """Return a finite value in the unit."""
        if self._guesses and not self.guessed and abs(value) > FULL:
            self._factor, self.guessed = 1.0, True
            _log.warning(
                "%s is %g, and no fraction of 1 as ROS defines it: taken for per cent from now on "
                "(its profile can say full: 100)",
                self._what,
                value,
            )
        return value * self._factor


# ---- telemetry ----

_PLACE = (
    "pose.pose.position.x",
    "pose.pose.position.y",
    "twist.twist.linear.x",
    "twist.twist.linear.y",
)
AWAKE_EVERY_S = 0.25
_OFTEN = 10
"""After so many more it is known how often something comes."""
_TEXT_BYTES = 200
_AGAIN_AND_AGAIN = 5
"""What was heard anew so often, each time in time, is said again and again, and may be missed."""


class _Value(NamedTuple):
    name: str
    source: LatestMessage
    read: FieldReader
    scale: UnitScale


class MeasuredPose(NamedTuple):
    """Where a robot was by its odometry, and how fast, and when it said so on our clock.

    Attributes:
        restarts: How often its odometry had begun anew.
    """

    x_m: float
    y_m: float
    speed_m_s: float
    at_ns: int
    restarts: int


class Measurements:
    """Everything that is heard of one robot. Each topic is subscribed to once.

    Attributes:
        sources: The subscriptions, by topic and type.
    """

    def __init__(self, profile: Ros2Profile, clock: Clock) -> None:
        self._profile = profile
        self._clock = clock
        self._runtime: RosRuntime | None = None
        self._kept = KeptTopics()
        self._all_kept = True
        self._said_once = False
        self._in_a_row = self._received = 0
        self._places: list[tuple[LatestMessage, tuple[FieldReader, ...]]] = []
        self.sources: dict[tuple[str, str], LatestMessage] = {}
        self._values: list[_Value] = []
        self._rest: RestReading | None = None
        self._cut_ns = 0
        self._awake_ns: int | None = None
        self._awake: asyncio.Task[None] | None = None

    def types(self) -> set[str]:
        """Return the types of message that it takes."""
        at_rest = self._profile.at_rest
        named = {entry.type for entry in self._profile.telemetry.values() if entry.topic}
        return named | ({at_rest.type} if at_rest is not None else set())

    async def open(self, runtime: RosRuntime) -> None:
        """Subscribe.

        Raises:
            BadName: A topic, a type or a field does not exist. What was opened goes with the node.
        """
        self._runtime = runtime
        for name, entry in self._profile.telemetry.items():
            if entry.topic:
                source = await self._source(runtime, entry.topic, entry.type)
                read = compile_path(runtime.types.message(entry.type), entry.field)
                scale = UnitScale(entry.unit, f"{name} of {self._profile.id}", entry.full)
                self._values.append(_Value(name, source, read, scale))
        at_rest = self._profile.at_rest
        if at_rest is None:
            return
        self._awake = asyncio.create_task(self._stay_awake())
        source = await self._source(runtime, at_rest.topic, at_rest.type)
        cls = runtime.types.message(at_rest.type)
        self._rest = RestReading(at_rest, source, cls, self._clock)

    async def close(self) -> None:
        """Subscribe no more."""
        if self._awake is not None:
            self._awake.cancel()
        self._kept.close()
        self._runtime = None
        for source in self.sources.values():
            await source.close()
        self.sources.clear()
        self._places.clear()

    async def _source(self, runtime: RosRuntime, topic: str, type_name: str) -> LatestMessage:
        key = topic, type_name
        if key not in self.sources:
            self.sources[key] = source = await runtime.latest(topic, type_name)
            if type_name == ODOMETRY:
                cls = runtime.types.message(type_name)
                self._places.append((source, tuple(compile_path(cls, path) for path in _PLACE)))
        return self.sources[key]

    # ---- what was said before we came ----

    def look(self, seen: GraphSnapshot) -> None:
        """Take in who is on the graph: what a publisher keeps is asked for once it is there."""
        topics = {topic.name: topic for topic in seen.topics}
        if self._runtime is not None:
            unmeasured = (s for s in self.sources.values() if not self._is_measured(s))
            self._kept.look(self._runtime, seen, unmeasured)
        there = (topics.get(source.topic) for source in self.sources.values())
        speaking = [topic for topic in there if topic is not None and topic.publishers]
        self._all_kept &= all(topic.latched == topic.publishers for topic in speaking)
        self._said_once = bool(speaking) and self._all_kept
        self._count()

    def _count(self) -> None:
        """Count the looks that find something new, as long as none came too late."""
        before, self._received = self._received, sum(s.received for s in self.sources.values())
        if self._in_a_row >= _AGAIN_AND_AGAIN:
            return
        if self._received > before:
            self._in_a_row += 1
        elif (self._heard_s() or 0.0) > self.silence_s:
            self._in_a_row = 0

    def _is_measured(self, source: LatestMessage) -> bool:
        """Tell whether rest or a way is measured by it: what was kept is no reading of now."""
        rests = self._rest is not None and source is self._rest.source
        return rests or any(source is odometry for odometry, _ in self._places)

    @property
    def tells_presence(self) -> bool:
        """Whether a robot that is there is heard.

        Not where everything that it reports is said once and kept by its publisher: it may be
        silent for as long as nothing changes. Where a publisher was there that keeps nothing, that
        one is missed when it is gone.
        """
        said_once = self._said_once and self._rest is None and self._in_a_row < _AGAIN_AND_AGAIN
        return bool(self.sources) and not said_once

    # ---- what is known ----

    @property
    def measures_rest(self) -> bool:
        """Whether the profile says how rest is measured."""
        return self._rest is not None

    @property
    def within_s(self) -> float:
        """The deadline of what shows rest; where nothing does, of any word of the robot."""
        at_rest = self._profile.at_rest
        return self._profile.link.heartbeat_s if at_rest is None else at_rest.within_s

    @property
    def silence_s(self) -> float:
        """After how many seconds without a word a robot counts as not there."""
        return self._profile.link.heartbeat_s

    def judged_age_s(self) -> float | None:
        """Return for how long that was not measured which `within_s` is about; None: never yet."""
        return self.age_s() if self._rest is None else self._rest.age_s()

    def stale_ns(self) -> int:
        """Return when something was measured that is too old to speak of now."""
        return self._clock.monotonic_ns() - int(self.within_s * SECOND_NS)

    def fresh(self) -> bool:
        """Tell whether rest, or the lack of it, is measured now; else, whether it is heard at all.

        True, too, for a robot of which nothing can be heard.
        """
        if self._rest is not None:
            return self.at_rest(self.stale_ns()) is not None
        age_s = self.age_s()
        return not self.tells_presence or (age_s is not None and age_s <= self.within_s)

    @property
    def restarts(self) -> int:
        """How often what shows rest, or else anything that is heard, has begun anew."""
        heard = self.sources.values() if self._rest is None else (self._rest.source,)
        return sum(source.senders.restarts for source in heard)

    def place(self) -> MeasuredPose | None:
        """Return where the robot last was by its odometry; None where it has none."""
        for source, readers in self._places:
            at_ns, restarts = source.sent_ns or 0, source.senders.restarts
            try:
                message = source.message()
            except BadValue:
                continue
            if message is not None:
                x_m, y_m, *speeds = (numbers(read(message))[0] for read in readers)
                known = all(map(isfinite, (x_m, y_m, *speeds)))
                return MeasuredPose(x_m, y_m, hypot(*speeds), at_ns, restarts) if known else None
        return None

    def age_s(self) -> float | None:
        """Return for how many seconds nothing was heard; None: nothing ever was, or has to be."""
        return self._heard_s() if self.tells_presence else None

    def _heard_s(self) -> float | None:
        ages = [age for source in self.sources.values() if (age := source.age_s) is not None]
        return min(ages, default=None)

    # ---- whether it rests ----

    def cut(self) -> None:
        """Take nothing from before now for rest: what moved, or was to be measured, broke off."""
        self._cut_ns = self._clock.monotonic_ns()

    async def _stay_awake(self) -> None:
        while True:
            self._look_awake()
            await self._clock.sleep(AWAKE_EVERY_S)

    def _look_awake(self) -> None:
        """Notice that ROSIC itself stood still: nobody knows what the robot did meanwhile."""
        now_ns, before_ns = self._clock.monotonic_ns(), self._awake_ns
        self._awake_ns = now_ns
        watchdog_s = self._profile.watchdog_s or self._profile.link.heartbeat_s
        if before_ns is not None and now_ns - before_ns > (AWAKE_EVERY_S + watchdog_s) * SECOND_NS:
            self._cut_ns = now_ns

    def at_rest(self, since_ns: int) -> bool | None:
        """Tell whether the newest message says rest.

        None: it was not sent after ``since_ns``, or not after the last break. A number that is
        missing, or not finite, is not measured: neither rest nor motion.
        """
        return self._still(since_ns, ())

    def holds(self, since_ns: int) -> bool | None:
        """Tell likewise whether it keeps its place; None, too, where that is not told from rest."""
        at_rest = self._profile.at_rest
        apart = () if at_rest is None else at_rest.counting_for_stops
        return self._still(since_ns, apart) if apart else None

    def _still(self, since_ns: int, left_out: tuple[str, ...]) -> bool | None:
        self._look_awake()
        if self._rest is None:
            return None
        return self._rest.still(max(since_ns, self._cut_ns), left_out)

    def doubt(self) -> str:
        """Return why rest is not measured though it is heard what should show it; else empty."""
        if self._rest is None or (self._rest.source.received_ns or 0) <= self.stale_ns():
            return ""
        return self._rest.doubt(self.stale_ns())

    def guessed(self) -> tuple[str, ...]:
        """Return which values were taken for per cent, as they are no fractions of 1."""
        return tuple(value.name for value in self._values if value.scale.guessed)

    async def every_s(self, within_s: float) -> float | None:
        """Listen to what shows rest; return how many seconds apart it comes, None: not twice.

        Args:
            within_s: Listen for so long at most.
        """
        if self._rest is None:
            return None
        source = self._rest.source
        begun, begun_ns = 0, 0
        with suppress(TimeoutError):
            async with asyncio.timeout(within_s):
                begun = await source.newer(source.received, timeout_s=within_s)
                begun_ns = source.received_ns or 0
                while source.received < begun + _OFTEN:
                    await source.newer(source.received, timeout_s=within_s)
        if not begun or source.received == begun:
            return None
        return ((source.received_ns or 0) - begun_ns) / SECOND_NS / (source.received - begun)

    async def next_word(self, timeout_s: float) -> None:
        """Wait until the topic that shows rest says something, at most so long."""
        if self._rest is None:
            await asyncio.sleep(timeout_s)
            return
        try:
            await self._rest.source.newer(self._rest.source.received, timeout_s=timeout_s)
        except TimeoutError:
            return

    def ages_s(self) -> dict[str, float]:
        """Return for how long each of `values` has not been heard, or was kept."""
        return {
            value.name: age_s
            for value in self._values
            if (age_s := value.source.told_age_s) is not None
        }

    def values(self) -> dict[str, float | str]:
        """Return the newest of everything the profile names; what cannot be read is left out."""
        told = ((name, _shown(value, scale)) for name, value, scale in self._told())
        return {name: shown for name, shown in told if shown is not None}

    def no_number(self) -> tuple[str, ...]:
        """Return of which of them the newest is none, such as NaN."""
        return tuple(
            name
            for name, value, _ in self._told()
            if isinstance(value, float) and not isfinite(value)
        )

    def _told(self) -> Iterator[tuple[str, Plain, UnitScale]]:
        for name, source, read, scale in self._values:
            with suppress(BadValue):
                message = source.message()
                if message is not None:
                    yield name, read(message), scale


def _shown(value: Plain, scale: UnitScale) -> float | str | None:
    if isinstance(value, str):
        return clean_text(value, max_bytes=_TEXT_BYTES)
    if isinstance(value, (bool, int, float)) and isfinite(value):
        return scale(float(value))
    return None
