"""Robots that hear from outside: what arrives on a line is brought to them, and nothing else."""

from __future__ import annotations

import asyncio
from time import perf_counter_ns
from typing import TYPE_CHECKING, cast

import msgspec

from rosic.bench.feeding import Beat, Values, Wish
from rosic.core.robot import Presence
from rosic.core.view import Pose
from rosic.robots.memory import MemoryRobot

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.core.gate import Gate
    from rosic.core.order import Rest, Stop
    from rosic.core.robot import Profile, RobotId

LENGTH_BYTES = 2


class Latest:
    """What a robot last said.

    Attributes:
        at_ns: When, on the clock of ``perf_counter_ns``; 0: it has said nothing.
    """

    __slots__ = ("at_ns", "pose", "values")

    def __init__(self) -> None:
        self.at_ns = 0
        self.pose: Pose | None = None
        self.values: dict[str, float | str] = {}


class FedRobot(MemoryRobot):
    """Knows of itself what it last said, and is absent when it has said nothing for too long.

    Attributes:
        latest: What it last said.
        handed_ns: When it was last told to stop, on the clock of ``perf_counter_ns``.
        within_s: It says something at least so often.
    """

    def __init__(self, profile: Profile, gate: Gate, clock: Clock) -> None:
        super().__init__(profile, gate, clock)
        self.latest = Latest()
        self.within_s = profile.link.heartbeat_s
        self.handed_ns = 0

    async def stop(self, stop: Stop) -> Rest:
        """Note the time before anything else."""
        self.handed_ns = perf_counter_ns()
        return await super().stop(stop)

    def presence(self) -> Presence:
        """Return what it last said."""
        latest = self.latest
        age_s = (perf_counter_ns() - latest.at_ns) / 1e9 if latest.at_ns else None
        doing = self._doing.skill.id if self._doing else ""
        return Presence(
            online=age_s is not None and age_s <= self.within_s,
            age_s=age_s,
            doing=doing,
            at_rest=self._doing is None,
            values=latest.values,
            pose=latest.pose,
        )


class Feed:
    """Brings to each robot what it said.

    What robots said last lies side by side, and so do the names that it is found by, as they are
    made before all else that a gateway keeps of each: a message touches little memory, and none of
    it far from that of the next.

    Attributes:
        messages: How many so far.
        robots: Whom it brings them to.
    """

    def __init__(self, names: Iterable[RobotId]) -> None:
        self.messages = 0
        self.robots: Mapping[RobotId, FedRobot] = {}
        self._latest = {name: Latest() for name in names}
        self._read = msgspec.msgpack.Decoder(Beat | Values).decode

    def join(self, robots: Mapping[RobotId, FedRobot]) -> None:
        """Have robots know what was brought."""
        self.robots = robots
        for name, robot in robots.items():
            robot.latest = self._latest[name]

    def take(self, words: bytes) -> None:
        """Take one message."""
        said = self._read(words)
        latest = self._latest[said.robot]
        latest.at_ns = perf_counter_ns()
        if type(said) is Values:
            latest.values = {"battery": said.battery}
            latest.pose = Pose(said.x_m, said.y_m)
        self.messages += 1


read_wish = msgspec.msgpack.Decoder(Wish).decode


class Frames(asyncio.Protocol):
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
