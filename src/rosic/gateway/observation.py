"""Robots as one reader sees them, for whoever records or watches: what was asked beside what moved.

It only looks. What the reader may not see is not handed on, from the moment at which they may not;
what others asked is handed on in words to whoever may read the history of that robot.
"""

from __future__ import annotations

import asyncio
import logging
from contextlib import aclosing
from typing import TYPE_CHECKING, Final, NamedTuple

from msgspec.structs import replace

from rosic.core.order import OrderStage
from rosic.core.robot.observation import (
    TURN,
    NoticeObservation,
    OrderObservation,
    PresenceObservation,
    ViewObservation,
)
from rosic.core.robot.view import CompressedFrame, Drawing, OccupancyMap
from rosic.errors import NothingToSee

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.contracts.clock import Clock
    from rosic.contracts.renderer import Renderer
    from rosic.core.identity import PrincipalId
    from rosic.core.order import Order, Outcome, StageReport
    from rosic.core.robot.observation import Observation
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.view import Content, View, ViewKind
    from rosic.gateway.components import Components
    from rosic.gateway.container_context import ContainerContext
    from rosic.gateway.order_execution import OrderExecutor
    from rosic.organiser.organiser import Organiser

UNDER_WAY: Final = "it was under way already"
FRAME_BYTES: Final = 300_000
"""What a camera compressed to more than this is drawn smaller."""
HEADS: Final = ((b"\xff\xd8\xff", "image/jpeg"), (b"\x89PNG\r\n\x1a\n", "image/png"))
MAP_CELLS: Final = 4_000_000

log = logging.getLogger("rosic.recording")


class ObservationRights(NamedTuple):
    """What a reader may see, asked each time: it may end.

    Attributes:
        principal: Who reads.
        sees: Whether they may see a robot now.
        oversees: Whether they may read what others ask of it.
    """

    principal: PrincipalId
    sees: Callable[[RobotId], bool]
    oversees: Callable[[RobotId], bool]


def observation_rights(
    organiser: Organiser, containers: ContainerContext | None, principal: PrincipalId
) -> ObservationRights:
    """Return what somebody may see."""

    def sees(robot: RobotId) -> bool:
        return principal not in organiser.locked and robot in organiser.visible(principal)

    def oversees(robot: RobotId) -> bool:
        return containers is not None and containers.may_oversee(principal, robot)

    return ObservationRights(principal, sees, oversees)


class RobotObserver:
    """Follows robots for one reader.

    Attributes:
        robots: Those that it follows still; one that the reader may not see any more is none.

    Args:
        take: Is handed everything, on the event loop; it must not wait.
        renderer: Draws frames that are too large, or no pictures yet; None: those are left out.
    """

    def __init__(
        self,
        rooms: Components,
        executor: OrderExecutor,
        clock: Clock,
        rights: ObservationRights,
        take: Callable[[Observation], None],
        renderer: Renderer | None = None,
    ) -> None:
        self.robots: dict[RobotId, None] = {}
        self._rooms = rooms
        self._executor = executor
        self._clock = clock
        self._rights = rights
        self._take = take
        self._renderer = renderer
        self._stops: dict[RobotId, tuple[int, bool]] = {}

    def open(self, robots: Iterable[RobotId]) -> None:
        """Follow robots from now on; those that the reader may not see are left out."""
        for robot in robots:
            if not self._rights.sees(robot):
                continue
            self.robots[robot] = None
            stopped = self._rooms.stops[robot]
            self._stops[robot] = (stopped.generation, stopped.latched)
            if stopped.latched:
                self._say_stop(robot, stopped.since_ns, stopped.by, "is stopped")
            current = self._rooms.linker.current(robot)
            if current is not None:
                self._step(current, TURN, note=UNDER_WAY)
        self._executor.watching.observe(self)

    def close(self) -> None:
        """Follow nothing any more."""
        self._executor.watching.observe(self, wanted=False)
        self.robots.clear()

    # ---- what moves ----

    def look(self, robots: Iterable[RobotId]) -> None:
        """Look once at some of them, and let those go that the reader may not see any more."""
        now_ns = self._clock.wall_ns()
        for robot in robots:
            if not self._rights.sees(robot):
                self.robots.pop(robot, None)
                continue
            try:
                self._look_at(robot, now_ns)
            except Exception:
                log.exception("%s could not be looked at", robot)

    def _look_at(self, robot: RobotId, now_ns: int) -> None:
        stopped, before = self._rooms.stops[robot], self._stops[robot]
        now = (stopped.generation, stopped.latched)
        if now != before:
            self._stops[robot] = now
            if now[0] != before[0]:
                self._say_stop(robot, stopped.at_ns or now_ns, stopped.by, "was stopped")
            if not now[1]:
                self._take(NoticeObservation(at_ns=now_ns, robot=robot, text="was resumed"))
        presence = self._rooms.linker.presence(robot)
        seen = PresenceObservation(
            at_ns=now_ns, robot=robot, presence=presence, stopped=stopped.latched
        )
        self._take(seen)

    def _say_stop(self, robot: RobotId, at_ns: int, by: PrincipalId, what: str) -> None:
        known = self._rights.oversees(robot) or by == self._rights.principal
        who = f" by {by}" if by and known else ""
        text = f"{what}{who}"
        self._take(NoticeObservation(at_ns=at_ns, robot=robot, text=text, grave=True))

    def notice(self, robot: RobotId, text: str, *, grave: bool) -> None:
        """Hand on what happened to a robot, if it is followed and may be seen."""
        if robot in self.robots and self._rights.sees(robot):
            now_ns = self._clock.wall_ns()
            self._take(NoticeObservation(at_ns=now_ns, robot=robot, text=text, grave=grave))

    # ---- what is asked ----

    def accepted(self, order: Order) -> None:
        """Hear that an order is decided and on disk."""
        self._step(order, OrderStage.ACCEPTED.value)

    def reported(self, order: Order, report: StageReport) -> None:
        """Hear how far an order is, by what was sent and by what the robot's side says."""
        self._step(order, report.stage.value, fraction=report.fraction, note=report.note)

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Hear that it is over, and how."""
        self._step(order, outcome.ending.value, note=outcome.note, outcome=outcome)

    def _step(
        self,
        order: Order,
        stage: str,
        *,
        fraction: float | None = None,
        note: str = "",
        outcome: Outcome | None = None,
    ) -> None:
        robot, asker = order.robot, order.permit.principal
        if robot not in self.robots or not self._rights.sees(robot):
            return
        seen = OrderObservation(
            at_ns=self._clock.wall_ns(),
            robot=robot,
            order=order.cid.hex(),
            n=order.n,
            skill=order.skill.id,
            stage=stage,
            over=outcome is not None,
            fraction=fraction,
            code="" if outcome is None else outcome.code,
        )
        if asker == self._rights.principal or self._rights.oversees(robot):
            seen = replace(
                seen,
                by=asker,
                words=order.words,
                arguments=order.arguments,
                note=note,
                facts={} if outcome is None else outcome.facts,
            )
        self._take(seen)

    # ---- what it shows ----

    async def show(self, robot: RobotId, sight: ViewKind, every_s: float) -> None:
        """Hand on what a robot shows, again and again, until it may not be seen any more.

        One that shows nothing for a while is asked again; it keeps nobody from anything.
        """
        while robot in self.robots:
            try:
                async with aclosing(self._rooms.linker.look(robot, sight)) as views:
                    async for view in views:
                        await self._pass_on(robot, view)
                        if robot not in self.robots:
                            return
                        await self._clock.sleep(every_s)
            except NothingToSee as nothing:
                log.debug("%s shows nothing: %s", robot, nothing)
            except Exception:
                log.exception("what %s shows could not be looked at", robot)
            await self._clock.sleep(every_s)

    async def _pass_on(self, robot: RobotId, view: View) -> None:
        age_ns = max(0, self._clock.monotonic_ns() - view.taken_ns)
        content: OccupancyMap | Drawing | None
        if isinstance(view.content, OccupancyMap):
            content = view.content if len(view.content.cells) <= MAP_CELLS else None
        else:
            content = await self._drawn(view.content)
        if content is not None and robot in self.robots and self._rights.sees(robot):
            at_ns = self._clock.wall_ns() - age_ns
            self._take(ViewObservation(at_ns=at_ns, robot=robot, content=content))

    async def _drawn(self, content: Content) -> Drawing | None:
        """Return a frame as a picture: as its camera compressed it, if that is small enough."""
        if isinstance(content, CompressedFrame) and len(content.data) <= FRAME_BYTES:
            for head, media_type in HEADS:
                if content.data.startswith(head):
                    return Drawing(media_type, content.data, 0, 0)
        if self._renderer is None:
            return None
        return await asyncio.to_thread(self._renderer, content, low=True)
