"""Robots that hear from outside: what arrives on a line is brought to them, and nothing else."""

from __future__ import annotations

import asyncio
from array import array
from math import isnan, nan
from time import perf_counter_ns
from typing import TYPE_CHECKING, cast

import msgspec

from rosic.bench.load_generator import FeedRequest, ReportedValues, RobotHeartbeat
from rosic.core.robot.profile import Presence
from rosic.core.robot.view import Pose
from rosic.robots.memory import MemoryRobot

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.core.order import RestReport, Stop
    from rosic.core.order_gate import OrderGate
    from rosic.core.robot.profile import Profile, RobotId

LENGTH_BYTES = 2


class LatestReports:
    """What robots last said, as numbers side by side: told as more when somebody looks.

    A message touches one line of memory here, however many robots there are.

    Attributes:
        sites: Where each robot's begin in both rows.
        heard_ns: When each last said anything, on the clock of ``perf_counter_ns``; 0: never.
        reported: Battery in percent, and place in m: three for each robot.
    """

    def __init__(self, names: Iterable[RobotId]) -> None:
        self.sites = {name: place for place, name in enumerate(names)}
        self.heard_ns = array("q", bytes(8 * len(self.sites)))
        self.reported = array("d", [nan, 0.0, 0.0] * len(self.sites))

    def has_reported(self, place: int) -> bool:
        """Whether a robot has said more than that it lives."""
        return not isnan(self.reported[3 * place])


class ReportingRobot(MemoryRobot):
    """Knows of itself what it last said, and is absent when it has said nothing for too long.

    Attributes:
        latest, place: What all last said, and where in it this one's is.
        handed_ns: When it was last told to stop, on the clock of ``perf_counter_ns``.
        within_s: It says something at least so often.
    """

    def __init__(self, profile: Profile, gate: OrderGate, clock: Clock) -> None:
        super().__init__(profile, gate, clock)
        self.latest, self.place = LatestReports((profile.id,)), 0
        self.within_s = profile.link.heartbeat_s
        self.handed_ns = 0

    async def stop(self, stop: Stop) -> RestReport:
        """Note the time before anything else."""
        self.handed_ns = perf_counter_ns()
        return await super().stop(stop)

    def hear_from(self, latest: LatestReports) -> None:
        """Know of itself what is kept there from now on."""
        self.latest, self.place = latest, latest.sites[self.profile.id]

    def presence(self) -> Presence:
        """Return what it last said."""
        heard_ns = self.latest.heard_ns[self.place]
        age_s = (perf_counter_ns() - heard_ns) / 1e9 if heard_ns else None
        battery, x_m, y_m = self.latest.reported[3 * self.place : 3 * self.place + 3]
        reported = self.latest.has_reported(self.place)
        return Presence(
            online=age_s is not None and age_s <= self.within_s,
            age_s=age_s,
            doing=self._doing.skill.id if self._doing else "",
            at_rest=self._doing is None,
            values={"battery": battery} if reported else {},
            ages_s={"battery": age_s} if reported and age_s is not None else {},
            pose=Pose(x_m, y_m) if reported else None,
        )


class ReportDelivery:
    """Brings to each robot what it said.

    Attributes:
        messages: How many so far.
    """

    def __init__(self, names: Iterable[RobotId]) -> None:
        self.messages = 0
        self.latest = LatestReports(names)
        self._read = msgspec.msgpack.Decoder(RobotHeartbeat | ReportedValues).decode

    def join(self, robots: Mapping[RobotId, ReportingRobot]) -> None:
        """Have robots know what was brought."""
        for robot in robots.values():
            robot.hear_from(self.latest)

    def take(self, words: bytes) -> None:
        """Take one message."""
        said, latest = self._read(words), self.latest
        place = latest.sites[said.robot]
        latest.heard_ns[place] = perf_counter_ns()
        if type(said) is ReportedValues:
            at, reported = 3 * place, latest.reported
            reported[at], reported[at + 1], reported[at + 2] = said.battery, said.x_m, said.y_m
        self.messages += 1

    def all_have_reported(self) -> bool:
        """Whether every robot has said more than that it lives."""
        return all(map(self.latest.has_reported, self.latest.sites.values()))


read_wish = msgspec.msgpack.Decoder(FeedRequest).decode


class FrameProtocol(asyncio.Protocol):
    """Cuts what arrives on a line into messages."""

    def __init__(self, take: Callable[[bytes], None]) -> None:
        self.transport: asyncio.Transport
        self.connected = asyncio.Event()
        self._take = take
        self._rest = b""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Somebody is there."""
        self.transport = cast("asyncio.Transport", transport)  # uvloop's own kind derives from none
        self.connected.set()

    def data_received(self, data: bytes) -> None:
        """Take every message that is whole."""
        if self._rest:
            data = self._rest + data
        at, end, take = 0, len(data), self._take
        while at + LENGTH_BYTES <= end:
            after = at + LENGTH_BYTES + (data[at] << 8 | data[at + 1])
            if after > end:
                break
            take(data[at + LENGTH_BYTES : after])
            at = after
        self._rest = data[at:]
