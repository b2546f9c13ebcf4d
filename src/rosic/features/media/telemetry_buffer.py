"""What robots reported over the last minutes, and where they went: bounded, in memory only."""

from __future__ import annotations

import asyncio
import logging
from array import array
from math import dist, isfinite
from typing import TYPE_CHECKING

from rosic.gateway.scheduling import go_round

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.robot.view import Pose
    from rosic.linker.linker import Linker


# ---- samples ----
# Of the last minutes; bounded, in memory only.

KEPT = 600
WAY_POINTS = 600
EVERY_S = 1.0
FOLLOW_S = 0.1
NEGLIGIBLE_M = 1e-4
SAME_S = 0.1
"""Two readings that were heard so close together are one: their ages are told apart from now."""


class SampleRing:
    """The newest samples of one value; 16 bytes each."""

    __slots__ = ("_count", "_next", "_times", "_values")

    def __init__(self) -> None:
        self._times = array("d", bytes(8 * KEPT))
        self._values = array("d", bytes(8 * KEPT))
        self._next = 0
        self._count = 0

    @property
    def newest_s(self) -> float | None:
        """When the newest sample is from; None: there is none."""
        return self._times[self._next - 1] if self._count else None

    def add(self, at_s: float, value: float) -> None:
        """Take a sample; the oldest goes."""
        self._times[self._next] = at_s
        self._values[self._next] = value
        self._next = (self._next + 1) % KEPT
        self._count = min(KEPT, self._count + 1)

    def points(self, now_s: float) -> tuple[tuple[float, float], ...]:
        """Return what is kept, in order; seconds before now are negative."""
        first = (self._next - self._count) % KEPT
        places = ((first + i) % KEPT for i in range(self._count))
        return tuple((self._times[i] - now_s, self._values[i]) for i in places)


class TelemetryBuffer:
    """Rings, by robot and value."""

    def __init__(self) -> None:
        self._rings: dict[tuple[RobotId, str], SampleRing] = {}

    def take(
        self,
        robot: RobotId,
        values: Iterable[tuple[str, float | str]],
        now_s: float,
        ages_s: Mapping[str, float] | None = None,
    ) -> None:
        """Keep what is a number and was heard since the last time, as of when it was heard.

        Args:
            robot: Whose.
            values: What it reported last.
            now_s: Monotonic clock.
            ages_s: Since each was heard; one that is not named is of now.
        """
        for name, value in values:
            if isinstance(value, str) or not isfinite(value):
                continue
            ring = self._rings.get((robot, name))
            if ring is None:
                ring = self._rings[robot, name] = SampleRing()
            heard_s = now_s - max(0.0, (ages_s or {}).get(name, 0.0))
            if ring.newest_s is None or heard_s > ring.newest_s + SAME_S:
                ring.add(heard_s, value)

    def names(self, robot: RobotId) -> tuple[str, ...]:
        """Return the values of a robot that were ever a number."""
        return tuple(sorted(name for owner, name in self._rings if owner == robot))

    def points(self, robot: RobotId, name: str, now_s: float) -> tuple[tuple[float, float], ...]:
        """Return a value's samples; empty for one that was never heard."""
        ring = self._rings.get((robot, name))
        return () if ring is None else ring.points(now_s)


class RobotTrack:
    """Where a robot went while it carried out one order.

    Attributes:
        words: The order, as people read it.
        begun_ns, ended_ns: Monotonic clock; None while it goes on.
        points: At most `WAY_POINTS`, evenly thinned when there were more.
    """

    __slots__ = ("_every", "_skipped", "begun_ns", "ended_ns", "points", "words")

    def __init__(self, words: str, begun_ns: int) -> None:
        self.words = words
        self.begun_ns = begun_ns
        self.ended_ns: int | None = None
        self.points: list[Pose] = []
        self._every = 1
        self._skipped = 0

    def add(self, pose: Pose, *, last: bool = False) -> None:
        """Take a pose; the first and the last are always kept."""
        self._skipped += 1
        if self.points and not last and self._skipped < self._every:
            return
        self._skipped = 0
        if last and self.points and _place(self.points[-1]) == _place(pose):
            self.points[-1] = pose
            return
        self.points.append(pose)
        if len(self.points) >= WAY_POINTS:
            del self.points[1:-1:2]
            self._every *= 2

    @property
    def length_m(self) -> float:
        """How far it went, along the way."""
        places = [_place(point) for point in self.points]
        return sum(map(dist, places, places[1:]))

    @property
    def rises(self) -> bool:
        """Whether its height changed."""
        heights = [point.z_m for point in self.points]
        return bool(heights) and max(heights) - min(heights) > NEGLIGIBLE_M


def _place(pose: Pose) -> tuple[float, float, float]:
    return pose.x_m, pose.y_m, pose.z_m


# ---- sampling ----

log = logging.getLogger("rosic.media")


class TelemetrySampler:
    """Watches robots for people; nothing is decided by what it sees, and nothing fails by it.

    Attributes:
        samples: Values of the last minutes.
        tracks: The way of each robot's last order.
    """

    def __init__(self, linker: Linker, clock: Clock) -> None:
        self.samples = TelemetryBuffer()
        self.tracks: dict[RobotId, RobotTrack] = {}
        self._linker = linker
        self._clock = clock
        self._reporting: dict[RobotId, None] = {}
        self._some = asyncio.Event()
        self._placed: set[RobotId] = set()
        self._open: dict[RobotId, RobotTrack] = {}
        self._following: asyncio.Task[None] | None = None

    def names(self, robot: RobotId) -> tuple[str, ...]:
        """Return the values of a robot that were ever a number."""
        return self.samples.names(robot)

    def values(self, robot: RobotId, name: str) -> tuple[tuple[float, float], ...]:
        """Return how many seconds ago which value was reported, the oldest first."""
        now_s = self._clock.monotonic_ns() / 1e9
        return tuple((-at_s, x) for at_s, x in self.samples.points(robot, name, now_s))

    def add_robot(self, profile: Profile) -> None:
        """Sample what a robot reports, from the next round on."""
        if profile.telemetry:
            self._reporting[profile.id] = None
            self._some.set()
        if profile.pose is not None:
            self._placed.add(profile.id)

    async def run(self) -> None:
        """Sample values until cancelled; without any to sample it only waits."""
        await go_round(self._clock, EVERY_S, self._reporting, self._sample, self._some)

    def _sample(self, robots: Iterable[RobotId]) -> None:
        now_s = self._clock.monotonic_ns() / 1e9
        for robot in robots:
            try:
                presence = self._linker.presence(robot)
            except Exception:
                log.exception("%s could not be sampled", robot)
                continue
            if presence.online is not False:
                self.samples.take(robot, presence.values.items(), now_s, presence.ages_s)

    # ---- ways ----

    def began(self, order: Order) -> None:
        """Follow a robot from now on, if it says where it is."""
        robot = order.robot
        if robot not in self._placed:
            return
        track = RobotTrack(order.words or order.skill.id, self._clock.monotonic_ns())
        self.tracks[robot] = self._open[robot] = track
        self._note(robot, track)
        if self._following is None or self._following.done():
            self._following = asyncio.create_task(self._follow())

    def ended(self, order: Order, _outcome: Outcome) -> None:
        """Follow it no more."""
        track = self._open.pop(order.robot, None)
        if track is not None:
            self._note(order.robot, track, last=True)
            track.ended_ns = self._clock.monotonic_ns()

    async def _follow(self) -> None:
        while self._open:
            await self._clock.sleep(FOLLOW_S)
            for robot, track in tuple(self._open.items()):
                self._note(robot, track)

    def _note(self, robot: RobotId, track: RobotTrack, *, last: bool = False) -> None:
        try:
            pose = self._linker.presence(robot).pose
        except Exception:
            log.exception("%s could not be followed", robot)
            return
        if pose is not None:
            track.add(pose, last=last)

    def close(self) -> None:
        """Follow nobody."""
        self._open.clear()
        if self._following is not None:
            self._following.cancel()
