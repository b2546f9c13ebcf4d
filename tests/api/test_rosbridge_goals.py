"""Goals of clients of rosbridge: how long they are followed, how many, and which is cancelled."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from rosic.api.order_feed import KEPT
from rosic.api.rosbridge.calls import GOALS_AT_MOST, TOO_MANY
from rosic.app.demo import fleet
from rosic.core.rate_limit import RateLimit
from rosic.core.robot.profile import Busy
from tests.api.bridge_client import bridge, later
from tests.api.served import served

if TYPE_CHECKING:
    import pytest

    from rosic.api.order_feed import OrderFeed
    from rosic.core.order import Order, Outcome, StageReport

FAR = {"direction": "left", "distance_m": 5.0, "speed_m_s": 0.05}
FAR_AWAY = 3_700.0


class AcceptedOrders(list["Order"]):
    """Observes orders, and keeps them."""

    def accepted(self, order: Order) -> None:
        self.append(order)

    def reported(self, order: Order, report: StageReport) -> None:
        """It is of no interest here."""

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Neither is this."""


def crowd_out(feed: OrderFeed, order: Order) -> None:
    """Let the feed take in so many orders that this one is none of its newest."""
    for number in range(KEPT):
        feed.accepted(replace(order, cid=number.to_bytes(16, "big")))


async def test_a_goal_that_takes_longer_than_an_hour_is_followed_to_its_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with served() as place, bridge(place, await place.key("operator")) as client:
        await client.say("send_action_goal", action="/omni/move", args=FAR, id="g")
        await place.until(lambda: place.gateway.rooms.linker.presence("omni").doing)
        later(monkeypatch, FAR_AWAY)
        await client.say("call_service", service="/rosapi/get_time", id="an hour later")
        await client.op("service_response")
        await client.say("cancel_action_goal", action="/omni/move", id="g")
        result = await client.op("action_result")
        assert (result["id"], result["status"]) == ("g", 5)


async def test_a_goal_is_followed_to_its_end_however_many_orders_come_after_it() -> None:
    orders = AcceptedOrders()
    async with served() as place, bridge(place, await place.key("operator")) as client:
        place.gateway.kernel.pipeline.executor.watching.observe(orders)
        await client.say("send_action_goal", action="/omni/move", args=FAR, id="g")
        await place.until(lambda: orders)
        await client.say("call_service", service="/rosapi/get_time", id="it is followed by now")
        await client.op("service_response")
        crowd_out(place.server.context.feed, orders[0])
        await client.say("cancel_action_goal", action="/omni/move", id="g")
        result = await client.op("action_result")
        assert (result["id"], result["status"]) == ("g", 5)


async def test_goals_without_an_id_are_told_apart_by_their_action() -> None:
    async with served() as place, bridge(place, await place.key("operator")) as client:
        linker = place.gateway.rooms.linker
        await client.say("send_action_goal", action="/omni/move", args=FAR)
        await place.until(lambda: linker.presence("omni").doing)
        await client.say("send_action_goal", action="/kuka1/release", args={})
        assert (await client.op("action_result"))["action"] == "/kuka1/release"
        await client.say("cancel_action_goal", action="/kuka1/release")
        assert await client.status() == "You have no such goal under way."
        await client.say("cancel_action_goal", action="omni/move")
        result = await client.op("action_result")
        assert (result["action"], result["status"]) == ("/omni/move", 5)


async def test_goals_count_until_they_are_over() -> None:
    queueing = tuple(
        replace(each, busy=Busy.QUEUE, queue_length=2 * GOALS_AT_MOST) for each in fleet()
    )
    async with (
        served(profiles=queueing, limit=RateLimit(burst=1e3, per_s=1e3)) as place,
        bridge(place, await place.key("operator")) as client,
    ):

        async def send(known: int) -> None:
            await client.say(
                "send_action_goal",
                action="/omni/move",
                args=FAR,
                id=known,
                feedback=known == GOALS_AT_MOST,
            )

        for known in range(GOALS_AT_MOST):
            await send(known)
        orders = place.server.context.feed
        await place.until(lambda: len(list(orders.newest())) == GOALS_AT_MOST)
        await send(GOALS_AT_MOST)
        refused: dict[str, Any] = await client.op("action_result")
        assert (refused["id"], refused["values"]) == (GOALS_AT_MOST, TOO_MANY)
        await client.say("cancel_action_goal", action="/omni/move", id=0)
        over = {(await client.op("action_result"))["id"] for _ in range(GOALS_AT_MOST)}
        assert over == set(range(GOALS_AT_MOST))
        await send(GOALS_AT_MOST)
        assert (await client.op("action_feedback"))["id"] == GOALS_AT_MOST
