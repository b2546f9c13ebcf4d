"""Orders that are steered from a connection: placed like any other, then their controls taken."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.api.order_feed import order_id
from rosic.core.message import AnswerState
from rosic.gateway.requests import line_id

if TYPE_CHECKING:
    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.api.order_feed import OrderEntry
    from rosic.core.message import Outbound
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.live_control import LiveInput
    from rosic.messengers.program.calls import ToolCall


class LiveOrders:
    """Places them for callers."""

    def __init__(self, context: ApiContext) -> None:
        self._context = context
        self._accepted: dict[str, asyncio.Event] = {}
        context.feed.changed.connect(self._note)

    def _note(self, entry: OrderEntry) -> None:
        accepted = self._accepted.get(entry.id)
        if accepted is not None:
            accepted.set()

    async def open(
        self, caller: ApiCaller, robot: RobotId, skill: str, *, within_s: float
    ) -> LiveInput | Outbound | None:
        """Place a live order, and take its controls as soon as it is on disk.

        Returns:
            The controls; or what was said instead, that it is refused or somebody is asked first;
            or None: nothing was said within so many seconds.

        Raises:
            Refusal: It cannot be steered, or its caller waits for too much. Nothing was done.
            MessengerFault: Nobody listens. Nothing was done.
        """
        context, live = self._context, self._context.kernel.pipeline.live
        messenger = context.messenger(caller)
        inbound = replace(messenger.inbound(caller.address, live.line(robot, skill)), live=True)
        call = context.begin(caller, inbound, robot)
        cid = line_id(inbound, 0)
        accepted = self._accepted[order_id(cid)] = asyncio.Event()
        try:
            said = await _said_instead(call, accepted, within_s)
        finally:
            del self._accepted[order_id(cid)]
            messenger.calls.close(call)
        return live.open(cid, caller.principal) if accepted.is_set() else said


async def _said_instead(
    call: ToolCall, accepted: asyncio.Event, within_s: float
) -> Outbound | None:
    """Wait until an order is accepted; return what is said if it is not, if anything is."""
    hearing = asyncio.create_task(_said(call))
    waiting = asyncio.create_task(accepted.wait())
    both = (hearing, waiting)
    try:
        await asyncio.wait(both, timeout=within_s, return_when=asyncio.FIRST_COMPLETED)
        return hearing.result() if hearing.done() else None
    finally:
        for task in both:
            task.cancel()
        await asyncio.gather(*both, return_exceptions=True)


async def _said(call: ToolCall) -> Outbound:
    while True:
        _, outbound = await call.news()
        if outbound.state is not AnswerState.GOES_ON:
            return outbound
