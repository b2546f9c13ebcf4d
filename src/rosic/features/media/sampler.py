"""Takes the samples: values every second, places while an order is carried out."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from rosic.features.media.telemetry_buffer import EVERY_S, FOLLOW_S, TelemetryBuffer, Track
from rosic.gateway.scheduling import go_round

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.contracts.clock import Clock
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.linker.linker import Linker

log = logging.getLogger("rosic.seeing")


class TelemetrySampler:
    """Watches robots for people; nothing is decided by what it sees, and nothing fails by it.

    Attributes:
        samples: Values of the last minutes.
        tracks: The way of each robot's last order.
    """

    def __init__(self, linker: Linker, clock: Clock) -> None:
        self.samples = TelemetryBuffer()
        self.tracks: dict[RobotId, Track] = {}
        self._linker = linker
        self._clock = clock
        self._reporting: dict[RobotId, None] = {}
        self._some = asyncio.Event()
        self._placed: set[RobotId] = set()
        self._open: dict[RobotId, Track] = {}
        self._following: asyncio.Task[None] | None = None

    def enlist(self, profile: Profile) -> None:
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
                self.samples.take(robot, presence.values.items(), now_s)

    # ---- ways ----

    def began(self, order: Order) -> None:
        """Follow a robot from now on, if it says where it is."""
        robot = order.robot
        if robot not in self._placed:
            return
        track = Track(order.words or order.skill.id, self._clock.monotonic_ns())
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

    def _note(self, robot: RobotId, track: Track, *, last: bool = False) -> None:
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
