"""Algorithm 8: words to a robot and words from it, the link verified by a greeting."""

from __future__ import annotations

import asyncio
import logging
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.order import OrderEnding, OrderStage, Outcome, StageReport, Stop
from rosic.errors import RobotOffline
from rosic.robots.ros2.bindings.dialogue import GREETING
from rosic.robots.ros2.profile import Ros2Link
from rosic.system import SystemClock
from tests.pace import patience
from tests.real.ros2.simulated import opened, shipped, until

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile
    from rosic.testing.ros2.graph import RosGraph

PEER = Path(__file__).with_name("peer.py")


@pytest.fixture
def clock() -> SystemClock:
    return SystemClock()


@pytest.fixture
def talker() -> Profile:
    """The profile that ships, pointed at the peer, which echoes what it hears."""
    link = Ros2Link(kind="ros2", namespace="/omni", dialogue=True)
    return replace(shipped("talker"), link=link)


async def test_the_greeting_is_answered_and_words_go_both_ways(
    graph: RosGraph, clock: SystemClock, talker: Profile, caplog: pytest.LogCaptureFixture
) -> None:
    robot_process = graph.start(PEER)
    said: list[str] = []
    told: list[StageReport] = []
    with caplog.at_level(logging.INFO, "rosic"):
        async with opened(talker, clock, said.append) as robot:
            assert robot.presence().online is None
            await until(lambda: said == [f"heard: {GREETING}"])
            assert robot.presence().online is True
            order = robot.order("say", {"text": "turn\x00 le\u202eft \ud83d"})
            assert await robot.execute(order, told.append) == Outcome(OrderEnding.SENT)
            assert [report.stage for report in told] == [OrderStage.SENT]
            await until(lambda: len(said) == 2)
            robot_process.say("texts 3")
            await until(lambda: len(said) == 5)
    assert said[1:] == ["heard: turn  left \ufffd", "1", "2", "3"]
    assert f"Sending to robot: {len(GREETING)} characters, to Talker" in caplog.text
    assert "Sending to robot: 12 characters, to Talker" in caplog.text
    assert "Received from robot: 19 characters, from Talker" in caplog.text
    for words in (GREETING, "turn", "left", "heard"):
        assert words not in caplog.text


async def test_a_greeting_without_an_answer_is_said_and_shown(
    graph: RosGraph, clock: SystemClock, talker: Profile
) -> None:
    said: list[str] = []
    async with opened(talker, clock, said.append) as robot:
        await until(lambda: said == ["robot not reachable"])
        assert robot.presence().online is False
        with pytest.raises(RobotOffline, match="Talker is not there"):
            await robot.do("say", {"text": "anybody?"})

        process = graph.start(PEER)
        await until(lambda: robot.presence().online is True)
        assert said[1:] == [f"heard: {GREETING}"]
        process.stop()
        await until(lambda: robot.presence().online is False)


async def test_a_stop_is_spoken_and_never_called_rest(
    graph: RosGraph, clock: SystemClock, talker: Profile
) -> None:
    graph.start(PEER)
    said: list[str] = []
    async with opened(talker, clock, said.append) as robot:
        await until(lambda: len(said) == 1)
        rest = await asyncio.wait_for(robot.stop(Stop("talker", 1)), 2.0 * patience())
        assert not rest.confirmed
        await until(lambda: said[1:] == ["heard: stop"])
