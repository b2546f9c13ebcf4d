"""What webhooks are told of: orders, stops, alarms, robots that come, go and come back."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rosic.api.order_feed import order_id
from rosic.api.schemas import moment
from rosic.api.webhooks.delivery import WebhookDelivery, WebhookEvent
from rosic.api.webhooks.settings import WebhookTopic
from rosic.core.i18n import said
from rosic.core.order import OrderEnding
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.api.webhooks.settings import WebhookSettings
    from rosic.core.identity import PrincipalId
    from rosic.core.order import Order, Outcome, StageReport
    from rosic.core.records import Unfinished
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.feature import Kernel

LOOK_S: Final = 0.5
LATE_S: Final = 1.0
"""After a standstill of so long nobody was heard: robots are looked at once more first."""
CHUNK: Final = 200
STOPS_AT_MOST: Final = 20_000

log = logging.getLogger("rosic.webhooks")


class WebhookStop(NamedTuple):
    """A robot that was stopped, or may go on, and is to be told of."""

    robot: RobotId
    by: PrincipalId
    at_ns: int
    stopped: bool


class WebhookWatcher:
    """Tells webhooks what happens, until cancelled. Nothing waits for it.

    Args:
        kernel: Of a gateway that is open.
        hooks: Who is told.
    """

    def __init__(self, kernel: Kernel, hooks: Sequence[WebhookSettings]) -> None:
        self._rooms, self._clock = kernel.rooms, kernel.machine_clock
        self._reach, self._admins = kernel.reach, kernel.admins
        run = f"{self._clock.wall_ns():x}"
        self.deliveries = tuple(
            WebhookDelivery(hook, self._clock, f"{run}_{number}")
            for number, hook in enumerate(hooks)
        )
        self._stops: deque[WebhookStop] = deque(maxlen=STOPS_AT_MOST)
        self._telling: asyncio.Handle | None = None
        self._online: dict[RobotId, bool | None] = dict.fromkeys(self._rooms.profiles)
        for delivery in self.deliveries:
            delivery.news.connect(partial(self._say, delivery.shown))
            delivery.put("", WebhookEvent("gateway.started", moment(self._clock.wall_ns()), {}))
        self._tell_in_doubt(kernel.shared.in_doubt.find() or ())
        kernel.pipeline.executor.watching.observe(self)
        kernel.shared.alarm_news.connect(self._see_alarm)
        self._rooms.stops.changed.connect(self._note_stop)

    def _tell_in_doubt(self, orders: Sequence[Unfinished]) -> None:
        """Tell of orders of the last run that ended unseen, and of their robots, held for that."""
        held = dict.fromkeys(order.robot for order in orders)
        for robot in held:
            if robot in self._online and (entry := self._rooms.stops[robot]).latched:
                self._tell_stop(WebhookStop(robot, entry.by, entry.at_ns, stopped=True))
        for order in orders:
            data = {"order": order_id(order.cid), "skill": order.skill}
            how = {"state": OrderEnding.UNKNOWN.value, "note": "", "code": ""}
            self._tell(WebhookTopic.ORDERS, order.robot, "order.ended", data | how)

    async def run(self) -> None:
        """Look at robots until cancelled. What fails is logged, and looked at again."""
        looked_ns = self._clock.monotonic_ns()
        try:
            while True:
                now_ns = self._clock.monotonic_ns()
                stood_still = now_ns - looked_ns > (LOOK_S + LATE_S) * SECOND_NS
                try:
                    await self._look(stood_still=stood_still)
                except Exception:
                    log.exception("webhooks could not be told how robots are")
                looked_ns = self._clock.monotonic_ns()
                await asyncio.sleep(LOOK_S)
        finally:
            for delivery in self.deliveries:
                await delivery.close()

    async def _look(self, *, stood_still: bool) -> None:
        for number, robot in enumerate(tuple(self._rooms.profiles)):
            if number % CHUNK == CHUNK - 1:
                await asyncio.sleep(0)
            self._see_presence(robot, stood_still=stood_still)

    def _note_stop(self, robot: RobotId) -> None:
        """Note that a robot was stopped, or may go on: it is told once all of them are."""
        entry = self._rooms.stops[robot]
        at_ns = entry.at_ns if entry.latched else self._clock.wall_ns()
        self._stops.append(WebhookStop(robot, entry.by, at_ns, stopped=entry.latched))
        if self._telling is None:
            self._telling = asyncio.get_running_loop().call_soon(self._tell_stops)

    def _tell_stops(self) -> None:
        self._telling = None
        for _ in range(min(CHUNK, len(self._stops))):
            self._tell_stop(self._stops.popleft())
        if self._stops:
            self._telling = asyncio.get_running_loop().call_soon(self._tell_stops)

    def _tell_stop(self, one: WebhookStop) -> None:
        data: dict[str, Any] = {}
        if one.stopped:
            by = self._rooms.authoriser.directory.name(one.by) if one.by else ""
            data = {"by": by, "stopped": self._rooms.stops[one.robot].latched}
        what = "robot.stopped" if one.stopped else "robot.resumed"
        self._tell(WebhookTopic.STOPS, one.robot, what, data, one.at_ns)

    def _see_presence(self, robot: RobotId, *, stood_still: bool) -> None:
        online = self._rooms.linker.presence(robot).online
        if online is False and self._online.get(robot) is not False and stood_still:
            return  # what it said meanwhile is not read yet
        if robot not in self._online:
            self._tell(WebhookTopic.ROBOTS, robot, "robot.added", {})
        elif online is False and self._online[robot] is not False:
            self._tell(WebhookTopic.ROBOTS, robot, "robot.offline", {})
        elif online and self._online[robot] is False:
            self._tell(WebhookTopic.ROBOTS, robot, "robot.online", {})
        self._online[robot] = online

    def _see_alarm(self, robot: RobotId, text: str, begins: bool) -> None:
        self._tell(
            WebhookTopic.ALERTS,
            robot,
            "alert.raised" if begins else "alert.over",
            {"text": str(text)},
        )

    def _say(self, shown: str, reached: bool) -> None:
        if reached:
            text = said("{where} takes what happens here again.", where=shown)
        else:
            text = said(
                "{where} has taken nothing of what happens here for ten minutes. I go on trying "
                "for a day, and keep the newest. The log says why.",
                where=shown,
            )
        self._reach.tell(self._admins(), text)

    # ---- gateway.order_watchers.OrderObserver ----

    def accepted(self, order: Order) -> None:
        """Tell that an order is on disk, and waits for its robot."""
        self._tell(WebhookTopic.ORDERS, order.robot, "order.accepted", self._order(order))

    def reported(self, order: Order, report: StageReport) -> None:
        """Steps are for whoever listens to events."""

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Tell how an order ended."""
        how = {"state": outcome.ending.value, "note": str(outcome.note), "code": outcome.code}
        self._tell(WebhookTopic.ORDERS, order.robot, "order.ended", self._order(order) | how)

    def _order(self, order: Order) -> dict[str, Any]:
        skill, vocabulary = order.skill.id, self._rooms.vocabulary
        return {
            "order": order_id(order.cid),
            "skill": skill,
            "n": order.n,
            "sent": str(order.words),
            "arguments": vocabulary.declared(order.robot, skill, order.arguments),
        }

    def _tell(
        self,
        topic: WebhookTopic,
        robot: RobotId,
        what: str,
        data: dict[str, Any],
        at_ns: int | None = None,
    ) -> None:
        at = moment(self._clock.wall_ns() if at_ns is None else at_ns)
        event = WebhookEvent(what, at, {"robot": robot, **data})
        for delivery in self.deliveries:
            if topic in delivery.settings.topics:
                delivery.put(robot, event)
