"""What is seen of robots, live, for one reader who may be slow: the newest of everything counts.

What waits is replaced by what is newer, so that a slow reader sees less and never something old;
steps of orders, stops and alarms are kept, as `SendQueue` keeps them. Frames are made beside the
event loop.
"""

from __future__ import annotations

import asyncio
from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from rosic.core.robot.observation import PresenceObservation, ViewObservation
from rosic.core.robot.view import OccupancyMap, ViewKind
from rosic.core.time_units import SECOND_NS
from rosic.gateway.scheduling import go_round
from rosic.gateway.send_queue import SendQueue, sent_in_time

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterable

    from rosic.contracts.clock import Clock
    from rosic.contracts.recording import Frame, ObservationSession
    from rosic.core.robot.observation import Observation
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.view import Drawing
    from rosic.gateway.observation import RobotObserver

LOOK_EVERY_S: Final = 0.1
SHOW_EVERY_S: Final = {ViewKind.MAP: 2.0, ViewKind.PICTURE: 0.2}
STEP_BYTES: Final = 1_024
"""As which a step counts: an order, a stop, how a robot is."""
HEARD_AT_MOST: Final = 500
"""Frames of the other end in a second; whoever sends more has gone wrong."""
HEARD_BYTES: Final = 65_536
"""Of all of them that wait; what another end has to say is short."""


class ObservationFeed:
    """One reader, from the first frame to the last.

    Attributes:
        overflowed: The other end has said more than is read.

    Args:
        session: Makes frames, and reads those of the other end.
        clock: Waits.
    """

    def __init__(self, session: ObservationSession, clock: Clock) -> None:
        self.overflowed = False
        self._session, self._clock = session, clock
        self._seen: SendQueue[Observation] = SendQueue(lambda: clock.monotonic_ns() / SECOND_NS)
        self._heard: deque[Frame] = deque()
        self._since_ns = self._count = self._heard_bytes = 0
        self._shows: dict[tuple[RobotId, ViewKind], asyncio.Task[None]] = {}
        self._news = self._seen.news

    def take(self, seen: Observation) -> None:
        """Take one thing in, in place of what is older and was not told yet."""
        if isinstance(seen, PresenceObservation):
            self._seen.show(("presence", seen.robot), seen, STEP_BYTES)
        elif isinstance(seen, ViewObservation):
            content = seen.content
            self._seen.show((type(content).__name__, seen.robot), seen, _size(content))
        else:
            self._seen.say(seen, STEP_BYTES)

    def hear(self, frame: Frame) -> None:
        """Take in what the other end says."""
        now_ns = self._clock.monotonic_ns()
        if now_ns - self._since_ns >= SECOND_NS:
            self._since_ns, self._count = now_ns, 0
        self._count += 1
        self._heard_bytes += len(frame)
        if self._count > HEARD_AT_MOST or self._heard_bytes > HEARD_BYTES:
            self.overflowed = True
            self._heard.clear()
        else:
            self._heard.append(frame)
        self._news.set()

    async def run(
        self,
        observer: RobotObserver,
        robots: Iterable[RobotId],
        send: Callable[[Frame], Awaitable[None]],
    ) -> None:
        """Show robots until none may be seen any more, or too much was heard; then return.

        Args:
            observer: Follows robots, and hands on to `take`.
            robots: Which ones.
            send: Sends one frame; whatever it raises ends this.

        Raises:
            SlowConsumer: The reader takes too little.
        """
        observer.open(robots)
        known = dict(observer.robots)
        looking = asyncio.create_task(
            go_round(self._clock, LOOK_EVERY_S, observer.robots, observer.look)
        )
        looking.add_done_callback(lambda _: self._news.set())
        try:
            for frame in self._session.begin():
                await sent_in_time(send, frame)
            while not self.overflowed:
                await self._news.wait()
                self._news.clear()
                gone = [robot for robot in known if robot not in observer.robots]
                for robot in gone:
                    del known[robot]
                for frame in await asyncio.to_thread(self._step, *self._batch(), gone):
                    await sent_in_time(send, frame)
                self._look_at(observer)
                if looking.done():
                    return
        finally:
            observer.close()
            await _ended(looking, *self._shows.values())

    def _batch(self) -> tuple[list[Frame], list[Observation]]:
        heard = list(self._heard)
        self._heard.clear()
        self._heard_bytes = 0
        return heard, self._seen.take_all()

    def _step(
        self, heard: list[Frame], seen: list[Observation], gone: list[RobotId]
    ) -> list[Frame]:
        """Make frames; on a thread, one call at a time."""
        session = self._session
        frames = [frame for robot in gone for frame in session.forget(robot)]
        frames += session.encode(seen)
        return frames + [answer for frame in heard for answer in session.heard(frame)]

    def _look_at(self, observer: RobotObserver) -> None:
        """Look at what somebody wants to see now, and at nothing else."""
        wanted = {
            (robot, sight) for robot, sight in self._session.wanted if robot in observer.robots
        }
        for gone in self._shows.keys() - wanted:
            self._shows.pop(gone).cancel()
        for robot, sight in wanted - self._shows.keys():
            showing = observer.show(robot, sight, SHOW_EVERY_S[sight])
            self._shows[robot, sight] = asyncio.create_task(showing)


def _size(content: OccupancyMap | Drawing) -> int:
    """Return as how many bytes a view counts."""
    seen = content.cells if isinstance(content, OccupancyMap) else content.content
    return STEP_BYTES + len(seen)


async def _ended(*tasks: asyncio.Task[None]) -> None:
    for task in tasks:
        task.cancel()
    with suppress(asyncio.CancelledError):
        await asyncio.gather(*tasks, return_exceptions=True)
