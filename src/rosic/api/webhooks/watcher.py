"""What webhooks are told of: orders, stops, alarms, robots that come, go and come back."""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from rosic.api.order_feed import order_id
from rosic.api.schemas import moment
from rosic.api.webhooks.delivery import WebhookDelivery, WebhookEvent
from rosic.api.webhooks.settings import WebhookTopic
from rosic.core.i18n import said

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.api.webhooks.settings import WebhookSettings
    from rosic.core.order import Order, Outcome, StageReport
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.feature import Kernel

LOOK_S: Final = 0.5
CHUNK: Final = 200

log = logging.getLogger("rosic.webhooks")


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
        self._stops = {robot: entry.generation for robot, entry in self._rooms.stops.items()}
        self._online: dict[RobotId, bool | None] = dict.fromkeys(self._rooms.profiles)
        for delivery in self.deliveries:
            delivery.news.connect(partial(self._say, delivery.shown))
            delivery.put("", WebhookEvent("gateway.started", moment(self._clock.wall_ns()), {}))
        kernel.pipeline.executor.watching.observe(self)
        kernel.shared.alarm_news.connect(self._see_alarm)

    async def run(self) -> None:
        """Look at robots until cancelled. What fails is logged, and looked at again."""
        try:
            while True:
                try:
                    await self._look()
                except Exception:
                    log.exception("webhooks could not be told how robots are")
                await asyncio.sleep(LOOK_S)
        finally:
            for delivery in self.deliveries:
                await delivery.close()

    async def _look(self) -> None:
        for number, robot in enumerate(tuple(self._rooms.profiles)):
            if number % CHUNK == CHUNK - 1:
                await asyncio.sleep(0)
            self._see_stop(robot)
            self._see_presence(robot)

    def _see_stop(self, robot: RobotId) -> None:
        entry = self._rooms.stops[robot]
        if self._stops.setdefault(robot, entry.generation) != entry.generation:
            self._stops[robot] = entry.generation
            by = self._rooms.authoriser.directory.name(entry.by) if entry.by else ""
            self._tell(
                WebhookTopic.STOPS, robot, "robot.stopped", {"by": by, "stopped": entry.latched}
            )

    def _see_presence(self, robot: RobotId) -> None:
        online = self._rooms.linker.presence(robot).online
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
        return {
            "order": order_id(order.cid),
            "skill": order.skill.id,
            "n": order.n,
            "sent": str(order.words),
            "arguments": order.arguments,
        }

    def _tell(self, topic: WebhookTopic, robot: RobotId, what: str, data: dict[str, Any]) -> None:
        event = WebhookEvent(what, moment(self._clock.wall_ns()), {"robot": robot, **data})
        for delivery in self.deliveries:
            if topic in delivery.settings.topics:
                delivery.put(robot, event)
