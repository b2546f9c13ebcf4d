"""Webhooks against a real server that takes, refuses, moves away, is slow or hangs."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import hmac
import json
import socket
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest
from aiohttp import web

from rosic.api.schemas import moment
from rosic.api.webhooks.delivery import (
    FIRST_PAUSE_S,
    TOLD_AFTER_S,
    TRIED_FOR_S,
    NotTaken,
    WebhookDelivery,
    WebhookEvent,
)
from rosic.api.webhooks.settings import WebhookSettings, WebhookTopic, check_url, is_private, key_of
from rosic.api.webhooks.watcher import WebhookWatcher
from rosic.core.history import HistoryQuery
from rosic.core.policy.roles import SkillPrecondition
from rosic.core.secret import Secret
from rosic.robots.memory import MemoryRobot
from rosic.stores.memory import MemoryStore
from rosic.system import SystemClock
from rosic.testing.factories import a_claim
from tests.api.served import served
from tests.gateway.test_rights import rules
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

KEY = bytes(range(32))
SECRET = Secret(f"whsec_{base64.b64encode(KEY).decode()}")


class HurriedClock(SystemClock):
    """Pauses are a hundredth, and remembered."""

    def __init__(self) -> None:
        super().__init__()
        self.paused: list[float] = []
        self.later_ns = 0

    def monotonic_ns(self) -> int:
        return super().monotonic_ns() + self.later_ns

    async def sleep(self, seconds: float) -> None:
        self.paused.append(seconds)
        await super().sleep(seconds / 100)


class Taken(NamedTuple):
    headers: dict[str, str]
    body: dict[str, Any]


class Receiver:
    """What is posted to; `answers` says what becomes of the next ones, then all are taken."""

    def __init__(self) -> None:
        self.asked: list[Taken] = []
        self.taken: list[Taken] = []
        self.answers: list[int] = []
        self.led_elsewhere = 0
        self.refuses: Callable[[dict[str, Any]], bool] = lambda _: False
        self.hang = asyncio.Event()
        self.hang.set()

    def of_robots(self) -> list[Taken]:
        """Return what was taken of robots; that the gateway has started is of none."""
        return [each for each in self.taken if each.body["data"]]

    async def take(self, request: web.Request) -> web.Response:
        raw = await request.read()
        got = Taken({k.lower(): v for k, v in request.headers.items()}, json.loads(raw))
        check_signature(got.headers, raw)
        self.asked.append(got)
        await self.hang.wait()
        if self.answers and (status := self.answers.pop(0)) != 200:
            where = {"Location": "/elsewhere"} if status in {302, 307} else {}
            return web.Response(status=status, headers=where)
        if self.refuses(got.body):
            return web.Response(status=500)
        self.taken.append(got)
        return web.Response(status=204)

    async def lead_elsewhere(self, _request: web.Request) -> web.Response:
        self.led_elsewhere += 1
        return web.Response(status=204)


def check_signature(headers: dict[str, str], raw: bytes) -> None:
    """As Standard Webhooks says it, worked out here anew."""
    text = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + raw
    digest = base64.b64encode(hmac.new(KEY, text, hashlib.sha256).digest()).decode()
    assert headers["webhook-signature"] == f"v1,{digest}"


@asynccontextmanager
async def receiving() -> AsyncIterator[tuple[Receiver, str]]:
    receiver, app = Receiver(), web.Application()
    app.router.add_post("/hook", receiver.take)
    app.router.add_route("*", "/elsewhere", receiver.lead_elsewhere)
    runner = web.AppRunner(app, access_log=None, shutdown_timeout=0.1)
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", 0).start()
    try:
        yield receiver, f"http://127.0.0.1:{runner.addresses[0][1]}/hook"
    finally:
        receiver.hang.set()
        await runner.cleanup()


def hook(url: str, **besides: Any) -> WebhookSettings:  # noqa: ANN401
    return WebhookSettings(url=url, secret=SECRET, **({"private": True} | besides))


def event(number: int, robot: str = "omni") -> WebhookEvent:
    return WebhookEvent("test", "2026-01-01T00:00:00.000Z", {"robot": robot, "number": number})


async def until(holds: Callable[[], object]) -> None:
    async with asyncio.timeout(60 * pace()):
        while not holds():  # noqa: ASYNC110 - nobody is told
            await asyncio.sleep(0.01)


@asynccontextmanager
async def delivering(
    url: str,
    *,
    within_s: float = 10.0,
    at_most: int = 1_000,
    **besides: Any,  # noqa: ANN401
) -> AsyncIterator[WebhookDelivery]:
    how = {"within_s": within_s, "at_most": at_most}
    delivery = WebhookDelivery(hook(url, **besides), HurriedClock(), "run", **how)  # type: ignore[arg-type]
    try:
        yield delivery
    finally:
        await delivery.close()


async def test_orders_and_stops_of_a_gateway_are_told_signed_and_in_order() -> None:
    async with receiving() as (receiver, url), served() as place:
        watcher = WebhookWatcher(place.gateway.kernel, (hook(url),))
        running = asyncio.create_task(watcher.run())
        hal = await place.program("operator")
        order = {"skill": "turn", "arguments": {"angle": 5}, "wait_s": 30}
        answer = (await hal.post("/v1/robots/omni/orders", json=order)).json()
        await hal.post("/v1/stop", json={"robots": ["omni"]})
        await until(lambda: len(receiver.taken) == 4)
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        taken = receiver.of_robots()
        assert [each.body["type"] for each in taken] == [
            "order.accepted",
            "order.ended",
            "robot.stopped",
        ]
        ended = taken[1].body["data"]
        assert (ended["order"], ended["robot"], ended["state"]) == (answer["id"], "omni", "done")
        assert ended["arguments"] == {"angle": 5, "direction": "left"}
        assert taken[2].body["data"] == {"robot": "omni", "by": "Hal", "stopped": True}
        assert len({each.headers["webhook-id"] for each in receiver.taken}) == 4


async def test_a_stop_is_told_at_once_of_its_moment_and_before_the_order_that_it_ended() -> None:
    async with receiving() as (receiver, url), served() as place:
        watcher = WebhookWatcher(place.gateway.kernel, (hook(url),))  # which never looks
        hal = await place.program("operator", "senior")
        order = {"skill": "move", "arguments": {"distance": 5}}
        await hal.post("/v1/robots/omni/orders", json=order)
        await place.until(lambda: place.gateway.rooms.linker.presence("omni").doing)
        await hal.post("/v1/stop", json={"robots": ["omni"]})
        stopped = place.gateway.rooms.stops["omni"]
        since = moment(stopped.at_ns)
        place.gateway.rooms.stops.resume("omni", stopped.generation - 1)
        place.gateway.rooms.stops.resume("omni", stopped.generation)
        await until(lambda: len(receiver.of_robots()) == 4)
        for delivery in watcher.deliveries:
            await delivery.close()
        taken = [each.body for each in receiver.of_robots()]
        assert [each["type"] for each in taken] == [
            "order.accepted",
            "robot.stopped",
            "order.ended",
            "robot.resumed",
        ]
        assert taken[1]["timestamp"] == since


async def test_what_a_killed_run_left_is_told_with_the_hold_of_its_robot() -> None:
    store = MemoryStore()
    await store.open()
    left = a_claim("an order of a run that died")
    await store.write(left)
    async with receiving() as (receiver, url), served(store=store) as place:
        watcher = WebhookWatcher(place.gateway.kernel, (hook(url),))
        await until(lambda: len(receiver.of_robots()) == 2)
        for delivery in watcher.deliveries:
            await delivery.close()
    taken = [each.body for each in receiver.of_robots()]
    assert [each["type"] for each in taken] == ["robot.stopped", "order.ended"]
    assert taken[0]["data"] == {"robot": "omni", "by": "", "stopped": True}
    assert taken[1]["data"] == {
        "robot": "omni",
        "order": left.cid.hex(),
        "skill": "move",
        "state": "unknown",
        "note": "",
        "code": "",
    }


async def test_after_a_standstill_robots_are_looked_at_once_more_before_one_is_gone() -> None:
    async with receiving() as (receiver, url), served(robots_of=lambda _kind: MemoryRobot) as place:
        watcher = WebhookWatcher(place.gateway.kernel, (hook(url),))
        await watcher._look(stood_still=False)
        robot = place.gateway.rooms.linker._robots["omni"]
        assert isinstance(robot, MemoryRobot)
        robot.online = False
        await watcher._look(stood_still=True)
        robot.online = True
        await watcher._look(stood_still=False)
        robot.online = False
        await watcher._look(stood_still=False)
        await until(receiver.of_robots)
        for delivery in watcher.deliveries:
            await delivery.close()
        assert [each.body["type"] for each in receiver.of_robots()] == ["robot.offline"]


@pytest.mark.parametrize("who", ["on the page", "a program"])
async def test_an_order_that_was_agreed_to_is_named_by_one_id_everywhere(who: str) -> None:
    care = rules(SkillPrecondition(scopes=("omni:*",), confirm=True))
    async with receiving() as (receiver, url), served(rules=care) as place:
        watcher = WebhookWatcher(place.gateway.kernel, (hook(url),))
        asks = await (place.person("Ada") if who == "on the page" else place.program("operator"))
        order = {"skill": "move", "arguments": {"distance": 0.1, "direction": "left"}}
        asked = (await asks.post("/v1/robots/omni/orders", json=order)).json()
        assert asked["state"] == "asked"
        if who == "on the page":
            shown = (await asks.get("/v1/chat")).json()[-1]
            tapped = {"message": shown["id"], "button": shown["buttons"][0][0]["nonce"]}
            await asks.post("/v1/chat", json=tapped | {"wait_s": 0})
        else:
            await place.until(lambda: place.chat.told)
            question = place.chat.told[-1]
            yes = question.outbound.buttons[0][0]
            place.chat.tap(yes, under=question.message, account=question.outbound.chat.id)
        over = (await asks.get(f"/v1/orders/{asked['id']}?wait_s=30")).json()
        assert (over["state"], over["id"]) == ("done", asked["id"])
        await until(lambda: len(receiver.of_robots()) == 2)
        told = [(each.body["type"], each.body["data"]["order"]) for each in receiver.of_robots()]
        assert told == [("order.accepted", asked["id"]), ("order.ended", asked["id"])]
        reader = place.gateway.kernel.shared.history.get()
        [line] = await reader.read(HistoryQuery(cid=bytes.fromhex(asked["id"]), limit=1))
        assert (line.entry.kind, line.entry.outcome) == ("claimed", "done")
        for delivery in watcher.deliveries:
            await delivery.close()


async def test_alarms_are_told_and_whoever_looks_after_people_hears_what_is_not_taken() -> None:
    async with receiving() as (receiver, url), served() as place:
        watcher = WebhookWatcher(place.gateway.kernel, (hook(url),))
        running = asyncio.create_task(watcher.run())
        news = place.gateway.kernel.shared.alarm_news
        news.emit("omni", "omni: battery 18 %", True)
        news.emit("omni", "omni: battery 40 %", False)
        await until(lambda: len(receiver.of_robots()) == 2)
        assert [(each.body["type"], each.body["data"]) for each in receiver.of_robots()] == [
            ("alert.raised", {"robot": "omni", "text": "omni: battery 18 %"}),
            ("alert.over", {"robot": "omni", "text": "omni: battery 40 %"}),
        ]
        where = watcher.deliveries[0].shown
        watcher.deliveries[0].news.emit(False)
        lead = f"{where} has taken nothing of what happens here for ten minutes."
        told = place.chat.told
        await until(lambda: any(each.outbound.text.startswith(lead) for each in told))
        assert {each.outbound.chat.id for each in told} == {"ada"}
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        news.emit("omni", "omni: nobody is told any more", True)
        assert watcher.deliveries[0].waiting == 0


async def test_who_takes_nothing_for_ten_minutes_is_named_once_and_once_more_when_it_does() -> None:
    async with receiving() as (receiver, url), delivering(url) as delivery:
        news: list[bool] = []
        delivery.news.connect(news.append)
        receiver.refuses = lambda _: True
        delivery.put("omni", event(1))
        await until(lambda: len(receiver.asked) > 1)
        assert not news
        clock = delivery._clock
        assert isinstance(clock, HurriedClock)
        clock.later_ns = int((TOLD_AFTER_S + 1) * 1e9)
        await until(lambda: news)
        asked = len(receiver.asked)
        await until(lambda: len(receiver.asked) > asked + 1)
        assert news == [False]
        receiver.refuses = lambda _: False
        await until(lambda: receiver.taken)
        await until(lambda: len(news) > 1)
        assert news == [False, True]


async def test_what_nobody_wants_is_not_told() -> None:
    async with receiving() as (receiver, url), served() as place:
        watcher = WebhookWatcher(
            place.gateway.kernel, (hook(url, topics=frozenset({WebhookTopic.STOPS})),)
        )
        running = asyncio.create_task(watcher.run())
        hal = await place.program("operator")
        order = {"skill": "move", "arguments": {"distance": 0.1}, "wait_s": 30}
        await hal.post("/v1/robots/omni/orders", json=order)
        await hal.post("/v1/stop", json={"robots": ["omni"]})
        await until(receiver.of_robots)
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        assert [each.body["type"] for each in receiver.of_robots()] == ["robot.stopped"]


@pytest.mark.parametrize("status", [500, 404, 302, 307, 410])
async def test_what_is_not_taken_is_told_again_with_the_same_id_and_longer_pauses(
    status: int,
) -> None:
    async with receiving() as (receiver, url), delivering(url) as delivery:
        receiver.answers = [status] * 4
        delivery.put("omni", event(1))
        await until(lambda: receiver.taken or receiver.led_elsewhere)
        assert not receiver.led_elsewhere
        assert len(receiver.asked) == 5
        assert len({got.headers["webhook-id"] for got in receiver.asked}) == 1
        clock = delivery._clock
        assert isinstance(clock, HurriedClock)
        expected = [FIRST_PAUSE_S * 2**n for n in range(4)]
        assert clock.paused == pytest.approx(expected, rel=0.26)


async def test_each_robot_keeps_its_order_and_none_waits_for_another() -> None:
    async with receiving() as (receiver, url), delivering(url) as delivery:
        receiver.refuses = lambda body: body["data"]["robot"] == "kuka1"
        for number in range(5):
            delivery.put("kuka1", event(number, "kuka1"))
            delivery.put("omni", event(number))
        await until(lambda: len(receiver.taken) == 5)
        assert [taken.body["data"]["number"] for taken in receiver.taken] == list(range(5))
        receiver.refuses = lambda _: False
        await until(lambda: len(receiver.taken) == 10)
        assert [taken.body["data"]["number"] for taken in receiver.taken[5:]] == list(range(5))


async def test_whoever_hangs_holds_up_nobody_and_is_given_up_for_now() -> None:
    async with receiving() as (receiver, url), delivering(url, within_s=0.2) as delivery:
        receiver.hang.clear()
        with pytest.raises(NotTaken, match=r"within 0\.2 s"):
            await delivery.post("msg_1", event(1))


async def test_too_much_loses_the_oldest_and_says_how_much_is_missing() -> None:
    async with receiving() as (receiver, url), delivering(url, at_most=20) as delivery:
        receiver.hang.clear()
        for number in range(20 + 50):
            delivery.put("omni", event(number))
        assert delivery.waiting == 20
        await until(lambda: receiver.asked)
        receiver.hang.set()
        await until(lambda: len(receiver.taken) == 20)
        assert sum(taken.body["lost"] for taken in receiver.taken) == 50
        assert receiver.taken[-1].body["data"]["number"] == 20 + 49


async def test_after_a_day_an_event_is_given_up_and_the_next_says_so() -> None:
    async with receiving() as (receiver, url), delivering(url) as delivery:
        receiver.refuses = lambda body: body["data"]["number"] == 1
        delivery.put("omni", event(1))
        await until(lambda: len(receiver.asked) > 1)
        clock = delivery._clock
        assert isinstance(clock, HurriedClock)
        clock.later_ns = int((TRIED_FOR_S + 1) * 1e9)
        delivery.put("omni", event(2))
        await until(lambda: receiver.taken)
        assert receiver.taken[0].body == {
            "type": "test",
            "timestamp": "2026-01-01T00:00:00.000Z",
            "data": {"robot": "omni", "number": 2},
            "lost": 1,
        }


async def test_a_name_that_leads_into_the_private_network_too_is_not_asked() -> None:
    async with receiving() as (receiver, url), delivering(url, private=False) as delivery:
        loop = asyncio.get_running_loop()
        looked_up = loop.getaddrinfo
        public = (socket.AF_INET, socket.SOCK_STREAM, 6, "", ("8.8.8.8", 0))

        async def both(*asked: Any, **how: Any) -> list[Any]:  # noqa: ANN401
            return [public, *await looked_up(*asked, **how)]

        loop.getaddrinfo = both  # type: ignore[method-assign]
        try:
            with pytest.raises(NotTaken, match="private network"):
                await delivery.post("msg_1", event(1))
        finally:
            loop.getaddrinfo = looked_up  # type: ignore[method-assign]
        assert not receiver.asked


async def test_what_is_asked_is_the_address_that_was_looked_at_under_the_configured_name() -> None:
    async with receiving() as (receiver, url):
        named = url.replace("127.0.0.1", "localhost")
        async with delivering(named) as delivery:
            await delivery.post("msg_1", event(1))
        assert receiver.taken[0].headers["host"] == named.split("/")[2]


async def test_this_machine_is_told_nothing_unless_that_is_said() -> None:
    async with receiving() as (receiver, url):
        for where in (url, url.replace("127.0.0.1", "localhost")):
            with pytest.raises(NotTaken, match="private network"):
                async with delivering(where, private=False) as delivery:
                    await delivery.post("msg_1", event(1))
        assert not receiver.asked


@pytest.mark.parametrize(
    "address",
    [
        "127.0.0.1",
        "10.1.2.3",
        "192.168.0.9",
        "169.254.169.254",
        "::1",
        "fe80::1%eth0",
        "::ffff:10.0.0.1",
        "64:ff9b::7f00:1",
        "2002:7f00:1::",
        "224.0.0.1",
        "0.0.0.0",  # noqa: S104 - an address to refuse
    ],
)
def test_which_addresses_are_private(address: str) -> None:
    assert is_private((address,))
    assert is_private(("8.8.8.8", address))
    assert not is_private(("8.8.8.8", "2606:4700::1111", "64:ff9b::808:808", "::ffff:8.8.8.8"))


@pytest.mark.parametrize("text", ["hunter2", "whsec_", "whsec_c2hvcnQ=", "whsec_!!!!"])
def test_what_is_no_secret_is_said_and_not_repeated(text: str) -> None:
    with pytest.raises(ValueError, match="A secret of a webhook is whsec_") as wrong:
        key_of(Secret(text))
    assert "hunter2" not in str(wrong.value)


@pytest.mark.parametrize(
    "url", ["", "example.org", "ftp://example.org/", "https://a b/", "https://"]
)
def test_what_is_no_address_is_said(url: str) -> None:
    with pytest.raises(ValueError, match="no address to which something can be posted"):
        check_url(url)
