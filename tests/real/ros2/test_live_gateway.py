"""A whole gateway has a robot on a ROS 2 graph driven live, from the message to its wheels."""

from __future__ import annotations

import asyncio
import time
from contextlib import asynccontextmanager
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.app.admin.api import AdminVerb
from rosic.app.gateway import Gateway, GatewayParts, GatewaySettings
from rosic.config.profiles import known_units
from rosic.core.identity import Address
from rosic.core.message import Chat, Inbound
from rosic.core.order import OrderEnding
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.core.rate_limit import RateLimit
from rosic.core.sample_gate import CONTROLS_SILENT
from rosic.errors import Expired
from rosic.gateway.live_topics import live_topic
from rosic.gateway.requests import line_id
from rosic.messengers.memory import MemoryMessenger
from rosic.robots.ros2.robot import Ros2Robot
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import MemoryLatch
from rosic.system import SystemClock, SystemEntropy
from rosic.testing.ros2.graph import RosGraph
from tests.gateway.place import ADA, BO, PEOPLE, ask_as_operator
from tests.pace import patience
from tests.real.ros2.base_profile import WATCHDOG_S, base_profile
from tests.real.ros2.simulated import until
from tests.real.ros2.stream_site import velocities_in

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

    from rosic.gateway.live_control import LiveInput

HERE = Path(__file__).parent
BASE = "base"
JUNIOR = Role(scopes=("*:*",), limits=("linear <= 0.1 m/s",))


class Driven:
    """A gateway, and the base that it drives."""

    def __init__(self, graph: RosGraph, folder: Path) -> None:
        self.file = folder / "velocities"
        self.base = graph.start(HERE / "base_node.py", self.file, BASE)
        self.clock = SystemClock()
        self.chat = MemoryMessenger("memory", clock=self.clock)
        settings = GatewaySettings(
            profiles=(base_profile(),),
            people=PEOPLE,
            limit=RateLimit(burst=1e6, per_s=1e6),
            lease_idle_s=30.0,
            rulebook=RoleRules(roles={**DEFAULT_ROLES, "junior": JUNIOR}),
        )
        parts = GatewayParts(
            messengers=(self.chat,),
            robot_factory=lambda _kind: Ros2Robot,
            store=MemoryStore(),
            latch=MemoryLatch(),
            clock=self.clock,
            entropy=SystemEntropy(),
            units=known_units(),
            face=lambda _ns: "12:00:00",
        )
        self.gateway = Gateway(settings, parts)
        self.numbers = count(1)
        self._held: asyncio.Task[None] | None = None

    @asynccontextmanager
    async def open(self) -> AsyncIterator[Driven]:
        """Run it until the end of the block."""
        await self.gateway.open()
        running = asyncio.create_task(self.gateway.run())
        try:
            await until(lambda: self.gateway.robots[BASE].presence().at_rest is True)
            yield self
        finally:
            self.fall_silent()
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
            await self.gateway.close()

    def who(self, account: str) -> str:
        """Return who somebody is."""
        known = self.gateway.rooms.authoriser.directory.at(Address("memory", account))
        assert known is not None
        return known[0].id

    def said(self) -> str:
        """Return everything that was told."""
        return "\n".join(told.outbound.text for told in self.chat.told)

    async def begin(self, account: str) -> LiveInput:
        """Order it to be driven live, and take the controls."""
        live, now_ns = self.gateway.pipeline.live, self.clock.wall_ns()
        topic = live_topic([self.gateway.rooms.profiles[BASE]], "/base/cmd_vel")
        assert topic is not None
        inbound = Inbound(
            sender=Address("memory", account),
            chat=Chat("memory", account),
            message=f"live-{now_ns}",
            text=live.line(BASE, topic.skill),
            sent_ns=now_ns,
            received_ns=now_ns,
            live=True,
        )
        await self.gateway.pipeline.receive(self.chat, inbound)
        return live.open(line_id(inbound, 0), self.who(account))

    def hold(self, controls: LiveInput, m_s: float) -> None:
        """Hold a stick from now on: what a client of the topic would publish."""
        topic = live_topic([self.gateway.rooms.profiles[BASE]], "/base/cmd_vel")
        assert topic is not None
        self.fall_silent()
        message = {"linear": {"x": m_s, "y": 0.0}, "angular": {"z": 0.0}}
        values = topic.values(message)

        async def hold() -> None:
            while True:
                controls.put_si(values, time.time_ns(), next(self.numbers))
                await asyncio.sleep(0.02)

        self._held = asyncio.create_task(hold())

    def fall_silent(self) -> None:
        """Send nothing any more."""
        if self._held is not None:
            self._held.cancel()
        self._held = None

    async def reaches(self, m_s: float) -> None:
        """Wait until the base was told to be so fast."""
        await until(lambda: any(v.m_s == m_s for v in velocities_in(self.file)[-3:]))

    async def speed(self) -> float:
        """Ask the base how fast it is."""
        self.base.say("speed")
        return float(await asyncio.to_thread(self.base.expect, "speed"))

    async def rests_within(self, seconds: float) -> None:
        """See that the base's side says that it rests, in time, and goes on resting."""
        begun_s = time.monotonic()
        while await self.speed():
            assert time.monotonic() - begun_s < seconds * patience(), "it moves on"
            await asyncio.sleep(0.01)
        await asyncio.sleep(0.5)
        assert not await self.speed()


@pytest.fixture
def driven(tmp_path: Path) -> Iterator[Driven]:
    with RosGraph(tmp_path) as graph:
        yield Driven(graph, tmp_path)


async def test_it_follows_the_hand_until_that_lets_go(driven: Driven) -> None:
    async with driven.open():
        controls = await driven.begin(ADA)
        for m_s in (0.2, -0.3):
            driven.hold(controls, m_s)
            await driven.reaches(m_s)
        await until(lambda: "received" in driven.said())
        with pytest.raises(Expired):
            await driven.begin(BO)
        controls.release()
        outcome = await controls.ended()
        assert outcome.ending is OrderEnding.DONE, outcome
        assert "by its odometry" in outcome.note
        assert not await driven.speed()
        assert "Base: drive, live" in driven.said()


async def test_silence_brings_it_to_rest(driven: Driven) -> None:
    async with driven.open():
        controls = await driven.begin(ADA)
        driven.hold(controls, 0.2)
        await driven.reaches(0.2)
        driven.fall_silent()
        await driven.rests_within(WATCHDOG_S + 0.3)
        assert (await controls.ended()).code == CONTROLS_SILENT


async def test_whoever_is_revoked_is_brought_to_rest(driven: Driven) -> None:
    async with driven.open():
        controls = await driven.begin(BO)
        driven.hold(controls, 0.2)
        await driven.reaches(0.2)
        await ask_as_operator(driven.gateway, AdminVerb.REVOKE, "Bo")
        await driven.rests_within(WATCHDOG_S + 0.3)
        assert (await controls.ended()).ending is OrderEnding.CANCELLED


async def test_other_limits_reach_the_wheels(driven: Driven) -> None:
    async with driven.open():
        controls = await driven.begin(BO)
        driven.hold(controls, 0.2)
        await driven.reaches(0.2)
        policy = driven.gateway.authority
        policy.grants_book.set_roles(driven.who(BO), ("junior",))
        policy.renew(driven.who(BO))
        await until(lambda: 0.09 < velocities_in(driven.file)[-1].m_s < 0.11)
        assert controls.outcome is None
        policy.grants_book.set_roles(driven.who(BO), ("viewer",))
        policy.renew(driven.who(BO))
        await driven.rests_within(WATCHDOG_S + 0.3)
        outcome = await controls.ended()
        assert outcome.note.startswith("it may not go on: "), outcome


async def test_a_stop_in_the_chat_ends_it(driven: Driven) -> None:
    async with driven.open():
        controls = await driven.begin(ADA)
        driven.hold(controls, 0.2)
        await driven.reaches(0.2)
        driven.chat.say("stop")
        await driven.rests_within(WATCHDOG_S + 0.3)
        assert (await controls.ended()).ending is OrderEnding.CANCELLED
        assert "Base at rest" in driven.said()
