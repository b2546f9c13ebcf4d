"""Recordings under way: what is seen is gathered on the event loop, and made a file beside it."""

from __future__ import annotations

import asyncio
import enum
import logging
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from rosic.core.identity import OPERATOR
from rosic.core.robot.observation import NoticeObservation, recorded_robot
from rosic.core.robot.view import ViewKind
from rosic.errors import NotPermitted, RecordUnavailable, TooManyRequests
from rosic.features.recording import messages as words
from rosic.gateway.observation import ObservationRights, RobotObserver, observation_rights
from rosic.gateway.scheduling import go_round, sleep_or_wake

if TYPE_CHECKING:
    from collections.abc import Coroutine, Sequence

    from rosic.contracts.clock import Clock
    from rosic.contracts.recording import RecordingEncoder
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.observation import Observation
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.feature import Kernel

WritePart: TypeAlias = Callable[[bytes], Awaitable[None]]
"""Takes the next part of a file; raises RecordUnavailable if that cannot be kept."""

LOOK_EVERY_S: Final = 0.1
PART_EVERY_S: Final = 2.0
EVERY_S: Final = {ViewKind.MAP: 5.0, ViewKind.PICTURE: 1.0}
"""How often is looked at what a robot shows."""
AT_ONCE: Final = 8
AGAIN_S: Final = 60.0
WAITING_AT_MOST: Final = 20_000
"""Observations that wait to be written; beyond it the newest are left out, and counted."""

log = logging.getLogger("rosic.recording")


class RecordingEnd(enum.Enum):
    """Why a recording is over."""

    TIME = "time"
    ASKED = "asked"
    UNSEEN = "unseen"
    FULL = "full"
    UNWRITTEN = "unwritten"
    CLOSED = "closed"
    FAILED = "failed"


class Recording:
    """One recording.

    Attributes:
        principal: For whom.
        robots: Which were asked for.
        size: Bytes so far.

    Args:
        encoder: Makes the file.
        write: Takes its parts.
        clock: Waits.
        most_bytes: It ends before it is larger.
    """

    def __init__(
        self,
        principal: PrincipalId,
        robots: Sequence[RobotId],
        encoder: RecordingEncoder,
        write: WritePart,
        clock: Clock,
        most_bytes: int,
    ) -> None:
        self.principal, self.robots, self.size = principal, tuple(robots), 0
        self._encoder, self._write, self._clock = encoder, write, clock
        self._most = most_bytes
        self._seen: list[Observation] = []
        self._left_out = 0
        self._why: RecordingEnd | None = None
        self._over = asyncio.Event()

    def take(self, seen: Observation) -> None:
        """Take one thing in; it is written soon."""
        if len(self._seen) < WAITING_AT_MOST:
            self._seen.append(seen)
        else:
            self._left_out += 1

    def end(self, why: RecordingEnd) -> None:
        """Let it end; the first reason counts."""
        if self._why is None:
            self._why = why
        self._over.set()

    async def run(
        self, observer: RobotObserver, for_s: float, sights: Sequence[tuple[RobotId, ViewKind]]
    ) -> RecordingEnd:
        """Record until it is over; return why it is. Never raises but when cancelled."""
        observer.open(self.robots)
        following = [asyncio.create_task(work) for work in self._following(observer, for_s, sights)]
        try:
            while self._why is None:
                await sleep_or_wake(self._clock, PART_EVERY_S, self._over)
                await self._part()
            if self._why is not RecordingEnd.UNWRITTEN:
                observer.look(tuple(observer.robots))
                await self._part()
                if self._why is not RecordingEnd.CLOSED or self.principal == OPERATOR:
                    await self._put(await asyncio.to_thread(self._encoder.finish))
        except RecordUnavailable:
            self._why = RecordingEnd.UNWRITTEN
        except Exception:
            log.exception("a recording ended")
            self._why = RecordingEnd.FAILED
        finally:
            observer.close()
            for task in following:
                task.cancel()
            await asyncio.gather(*following, return_exceptions=True)
        return self._why

    def _following(
        self, observer: RobotObserver, for_s: float, sights: Sequence[tuple[RobotId, ViewKind]]
    ) -> list[Coroutine[Any, Any, None]]:
        shown = [observer.show(robot, sight, EVERY_S[sight]) for robot, sight in sights]
        return [self._look(observer), self._time(for_s), *shown]

    async def _look(self, observer: RobotObserver) -> None:
        await go_round(self._clock, LOOK_EVERY_S, observer.robots, observer.look)
        self.end(RecordingEnd.UNSEEN)

    async def _time(self, for_s: float) -> None:
        await self._clock.sleep(for_s)
        self.end(RecordingEnd.TIME)

    async def _part(self) -> None:
        seen, self._seen = self._seen, []
        if self._left_out:
            text = f"{self._left_out} observations were left out: they came too fast"
            now_ns, robot = self._clock.wall_ns(), self.robots[0]
            seen.append(NoticeObservation(at_ns=now_ns, robot=robot, text=text, grave=True))
            self._left_out = 0
        if seen:
            await self._put(await asyncio.to_thread(self._encoder.encode, seen))

    async def _put(self, part: bytes) -> None:
        if part:
            await self._write(part)
            self.size += len(part)
        if self.size >= self._most:
            self.end(RecordingEnd.FULL)


class RecordingService:
    """Everything that is recorded now."""

    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel
        self._under_way: dict[Recording, tuple[RobotObserver, asyncio.Task[RecordingEnd]]] = {}
        self._begun: dict[Recording, None] = {}

    def __len__(self) -> int:
        return len(self._under_way) + len(self._begun)

    def find(self, principal: PrincipalId, robot: RobotId = "") -> Recording | None:
        """Return what is recorded for somebody: of a robot, or of any."""
        for recording in (*self._begun, *self._under_way):
            if recording.principal == principal and robot in {"", *recording.robots}:
                return recording
        return None

    def check_possible(self) -> None:
        """See that a recording can be made here now.

        Raises:
            NotPermitted: None can be made here.
            TooManyRequests: Too many are being made.
        """
        if self._kernel.recorder is None:
            raise NotPermitted(words.NO_RECORDER)
        if len(self) >= AT_ONCE:
            raise TooManyRequests(words.TOO_MANY, retry_after_s=AGAIN_S)

    def rights_of(self, principal: PrincipalId) -> ObservationRights:
        """Return what somebody may see; whoever owns the machine sees everything."""
        if principal == OPERATOR:
            return ObservationRights(OPERATOR, lambda _robot: True, lambda _robot: True)
        kernel = self._kernel
        return observation_rights(kernel.rooms.organiser, kernel.containers, principal)

    def begin(
        self, principal: PrincipalId, robots: Sequence[RobotId], write: WritePart, most_bytes: int
    ) -> Recording:
        """Return a recording that has yet to run, and counts from now on until it is over.

        Raises:
            NotPermitted: Recordings cannot be made here.
        """
        kernel = self._kernel
        if kernel.recorder is None:
            raise NotPermitted(words.NO_RECORDER)
        profiles = [kernel.rooms.profiles[robot] for robot in robots]
        about = {
            "for": principal,
            "place": kernel.site.name,
            "begun_ns": str(kernel.clock.wall_ns()),
            "orders of others": "in words where the reader may read them, else without",
        }
        encoder = kernel.recorder.begin([recorded_robot(profile) for profile in profiles], about)
        clock = kernel.machine_clock
        recording = Recording(principal, robots, encoder, write, clock, most_bytes)
        self._begun[recording] = None
        return recording

    def drop(self, recording: Recording) -> None:
        """Let a recording that never ran count no more."""
        self._begun.pop(recording, None)

    async def run(
        self, recording: Recording, for_s: float, *, pictures: bool = False
    ) -> RecordingEnd:
        """Record, until it is over or somebody ends it; return why it is."""
        kernel = self._kernel
        profiles = kernel.rooms.profiles
        observer = RobotObserver(
            kernel.rooms,
            kernel.pipeline.executor,
            kernel.clock,
            self.rights_of(recording.principal),
            recording.take,
            kernel.renderer,
        )
        wanted = (ViewKind.MAP, ViewKind.PICTURE) if pictures else (ViewKind.MAP,)
        sights = [(r, s) for r in recording.robots for s in wanted if profiles[r].offers(s)]
        task = asyncio.create_task(recording.run(observer, for_s, sights))
        self.drop(recording)
        self._under_way[recording] = (observer, task)
        try:
            return await task
        finally:
            del self._under_way[recording]

    def notice(self, robot: RobotId, text: str, grave: bool) -> None:
        """Hear what happened to a robot."""
        for observer, _ in self._under_way.values():
            observer.notice(robot, text, grave=grave)

    async def end(self, principal: PrincipalId) -> None:
        """Break off what is recorded for somebody who is being erased."""
        await self._cancel(lambda recording: recording.principal == principal)

    async def close(self) -> None:
        """End everything; what was seen so far is written."""
        for recording in self._under_way:
            recording.end(RecordingEnd.CLOSED)
        tasks = [task for _, task in self._under_way.values()]
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _cancel(self, which: Callable[[Recording], bool]) -> None:
        tasks = [task for one, (_, task) in self._under_way.items() if which(one)]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
