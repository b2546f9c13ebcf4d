"""Robots' own ROS 2 nodes, in another process, share, ask, answer and are told how to work."""

from __future__ import annotations

import asyncio
import json
import time
from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from msgspec.structs import replace

from rosic.errors import ConfigurationError
from rosic.features.robot_to_robot.inbox import PACE
from rosic.robots.ros2.profile import Ros2Link, Ros2Profile
from rosic.robots.ros2.robot import Ros2Robot
from tests.features.robot_to_robot.peers import CAREFUL, PeerRobots
from tests.features.robot_to_robot.test_storm import RealClock
from tests.gateway.place import BO
from tests.pace import pace
from tests.real.ros2.simulated import shipped, simulated, until

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.robot.profile import Profile
    from rosic.testing.ros2.graph import RosGraph, RosProcess

PEER = Path(__file__).with_name("fellow_peer.py")
PATIENCE_S = 30.0 * pace()


def peer(name: str) -> Profile:
    link = Ros2Link(kind="ros2", namespace=f"/{name}", among=True)
    return Ros2Profile(id=name, link=link, strategies={"careful": CAREFUL})


class OnRos(PeerRobots):
    """omni and cf1, reached over ROS 2."""

    kind = Ros2Robot

    def __init__(self, *fleet: Profile) -> None:
        fleet = fleet or (peer("omni"), peer("cf1"), peer("cf2"))
        super().__init__(clock=RealClock(), fleet=fleet)


class Brain:
    """One robot's own node."""

    def __init__(self, process: RosProcess, robot: str) -> None:
        self.process = process
        self.robot = robot
        self._heard: deque[dict[str, Any]] = deque()

    async def do(self, verb: str, rest: str = "-") -> None:
        self.process.say(f"{verb} {self.robot} {rest}")
        while await self._listen() != f"ok {verb}":
            pass

    async def say(self, kind: str, **said: object) -> None:
        await self.do("say", json.dumps({"kind": kind, **said}))

    async def heard(self, kind: str) -> dict[str, Any]:
        """Wait for the next of a kind, which may have come before what was done was confirmed."""
        while True:
            while not self._heard:
                await self._listen()
            found = self._heard.popleft()
            if found["kind"] == kind:
                return found

    async def _listen(self) -> str:
        """Return the next line, and keep what it says was heard."""
        line = await asyncio.to_thread(self.process.expect, "", timeout_s=PATIENCE_S)
        if line.startswith(beginning := f"heard {self.robot} "):
            self._heard.append(json.loads(line.removeprefix(beginning)))
        return line


async def brains(graph: RosGraph) -> tuple[Brain, Brain]:
    """Return the nodes of omni and cf1, in a process each, heard by ROSIC."""
    found = []
    for robot in ("omni", "cf1"):
        brain = Brain(await asyncio.to_thread(graph.start, PEER, robot), robot)
        await brain.do("meet")
        found.append(brain)
    return found[0], found[1]


async def test_they_share_ask_help_answer_and_take_on_a_strategy(graph: RosGraph) -> None:
    async with OnRos().open() as here:
        omni, cf1 = await brains(graph)
        await cf1.say("follow", robot="omni", topic="road", ref="f")
        assert (await cf1.heard("result"))["ok"] is True
        await omni.say("share", topic="road", data={"wet": True}, ref="s")
        assert (await omni.heard("result"))["ok"] is True
        shared = await cf1.heard("shared")
        assert (shared["from"], shared["topic"], shared["data"]) == ("omni", "road", {"wet": True})
        await cf1.say("get", robot="omni", ref="g")
        got = await cf1.heard("result")
        assert (got["found"], got["data"], got["age_s"] < PATIENCE_S) == (True, {"wet": True}, True)

        await omni.say("help", what="stuck at aisle 4")
        request = await cf1.heard("help")
        await cf1.say("accept", id=request["id"])
        assert (await omni.heard("helped"))["by"] == "cf1"
        await until(lambda: any("cf1 helps omni" in t.outbound.text for t in here.chat.told))

        await omni.say("tell", to="cf1", data="where are you?")
        told = await cf1.heard("told")
        await cf1.say("tell", to="omni", data=[1.5, 2.5], re=told["id"])
        assert (await omni.heard("told"))["data"] == [1.5, 2.5]

        here.chat.say("/strategy omni careful speed=0.1 now", account=BO, chat=BO)
        strategy = await omni.heard("strategy")
        assert strategy["values"] == {"speed": 0.1, "spacing": 1.0}
        await omni.say("ack", id=strategy["id"], ok=True)
        await until(lambda: any("omni has taken on" in t.outbound.text for t in here.chat.told))


async def test_a_robot_cannot_speak_for_another_and_10_mb_are_refused(graph: RosGraph) -> None:
    async with OnRos().open() as here:
        omni, _cf1 = await brains(graph)
        await omni.do("large", "10000000")
        refused = await omni.heard("result")
        assert (refused["ok"], refused["code"]) == (False, "out-of-bounds")
        assert "at most 64 KiB" in refused["why"]
        await omni.say("share", topic="road", data=1, **{"from": "cf1"})
        assert (await omni.heard("result"))["code"] == "not-understood"
        shared_state = here.messaging.circle.shared_state
        assert (shared_state.of("omni"), shared_state.of("cf1")) == ((), ())


async def test_a_node_that_shares_10_000_times_a_second_hinders_nobody(
    graph: RosGraph, record_property: Callable[[str, object], None]
) -> None:
    async with OnRos().open() as here:
        omni, cf1 = await brains(graph)
        inbox, opened_s = (
            here.messaging.inboxes["omni"],
            time.monotonic(),
        )
        storm = asyncio.create_task(omni.do("flood", "2"))
        await until(lambda: inbox.dropped > 0)
        seconds: list[float] = []
        here.chat.say("stop cf1", account=BO, chat=BO)
        begun = time.perf_counter()
        await until(lambda: here.gateway.robots["cf1"].gate.latched)
        stopped_s = time.perf_counter() - begun
        while not storm.done():
            begun = time.perf_counter()
            await cf1.say("get", robot="omni", ref="g")
            assert (await cf1.heard("result"))["ok"] is True
            seconds.append(time.perf_counter() - begun)
            await asyncio.sleep(0.1)
        await storm
        shared_state = here.messaging.circle.shared_state
        await until(lambda: any(s.data == b'"last"' for s in shared_state.of("omni")))
        taken, dropped = inbox.taken, inbox.dropped
        said = f"{taken} taken, {dropped} dropped; others {max(seconds):.3f} s"
        said = f"{said}, a stop {stopped_s:.3f} s"
        record_property("storm", said)
        assert stopped_s < 5.0, said
        past_s = time.monotonic() - opened_s
        assert taken <= PACE.burst + PACE.per_s * past_s, said
        assert dropped > taken
        assert sorted(seconds)[len(seconds) // 2] < 5.0, said


async def test_a_robot_that_ships_takes_on_a_strategy(
    graph: RosGraph, interfaces: Path, tmp_path: Path
) -> None:
    assert interfaces.name
    with simulated(graph, tmp_path, "omni"):
        async with OnRos(shipped("omni")).open() as here:
            robot = here.gateway.robots["omni"]
            await until(lambda: robot.presence().online is True, timeout_s=PATIENCE_S)
            await until(lambda: bool(robot.hear(b"{}")), timeout_s=PATIENCE_S)  # type: ignore[attr-defined]
            here.chat.say("/strategy omni careful speed=0.1 now", account=BO, chat=BO)
            await until(
                lambda: any(
                    "omni has taken on: Careful" in t.outbound.text for t in here.chat.told
                ),
                timeout_s=PATIENCE_S,
            )


async def test_a_profile_without_a_namespace_is_refused(graph: RosGraph) -> None:
    assert graph is not None
    lonely = replace(peer("omni"), link=Ros2Link(kind="ros2", among=True))
    place = PeerRobots(fleet=(lonely,))
    with pytest.raises(ConfigurationError, match="among needs a namespace"):
        Ros2Robot(lonely, place.gateway, place.clock)  # type: ignore[arg-type]
