"""A goal does not outlive a break of ours (I6): the gateway is frozen while its robot moves.

The robot is one that knows nothing of gateways: it does what it was told until it is called off.
"""

from __future__ import annotations

import signal
import time
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2 import goal_watch
from rosic.testing.ros2.graph import RosGraph
from tests.pace import pace
from tests.real.ros2.test_robot_bindings import PEER

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rosic.testing.ros2.graph import RosProcess

FREEZE, GO_ON = signal.SIGSTOP, signal.SIGCONT
DISTANCE_M = 2.0
METRE_S = 6.0 * pace()
"""So slow that nothing but being called off ends it before the test does."""
FROZEN_S = 2.0 + goal_watch.LOOK_EVERY_S
WITHIN_S = 60.0 * pace()


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RosGraph]:
    with RosGraph(tmp_path_factory.mktemp("frozen")) as graph:
        yield graph


@pytest.fixture(scope="module")
def peer(graph: RosGraph, interfaces: Path) -> RosProcess:
    peer = graph.start(PEER, interfaces)
    peer.say(f"dawdle {METRE_S}")
    return peer


@pytest.fixture
def gateway(graph: RosGraph, peer: RosProcess) -> Iterator[RosProcess]:
    """One whose robot has begun to move."""
    gateway = graph.start("-m", "tests.real.ros2.goal_driver")
    gateway.say(f"drive {DISTANCE_M}")
    peer.expect("goal forward", timeout_s=WITHIN_S)
    gateway.expect("driving", timeout_s=WITHIN_S)
    gateway.expect("note rolling", timeout_s=WITHIN_S)
    yield gateway
    gateway.stop()


def test_a_goal_of_a_gateway_that_was_frozen_is_called_off(
    peer: RosProcess, gateway: RosProcess
) -> None:
    gateway.process.send_signal(FREEZE)
    time.sleep(FROZEN_S)
    gateway.process.send_signal(GO_ON)
    ended = gateway.expect("ended", timeout_s=WITHIN_S)
    assert not ended.startswith("done"), ended
    assert "broken off because ROSIC itself stood still for " in ended
    peer.expect("called off after", timeout_s=WITHIN_S)


def test_a_stop_that_waited_for_a_frozen_gateway_ends_its_goal(
    peer: RosProcess, gateway: RosProcess
) -> None:
    gateway.process.send_signal(FREEZE)
    gateway.say("stop")
    time.sleep(FROZEN_S)
    gateway.process.send_signal(GO_ON)
    peer.expect("called off after", timeout_s=WITHIN_S)
    assert not gateway.expect("ended", timeout_s=WITHIN_S).startswith("done")


def test_a_goal_that_was_accepted_while_its_gateway_was_frozen_is_called_off(
    peer: RosProcess, gateway: RosProcess
) -> None:
    gateway.say("stop")
    told: set[str] = set()
    while not {"ended", "rest"} <= told:
        told.add(gateway.expect("", timeout_s=WITHIN_S).split()[0])
    peer.expect("called off after", timeout_s=WITHIN_S)
    gateway.say("resume")
    peer.say("hesitate")
    gateway.say(f"drive {DISTANCE_M}")
    peer.expect("goal forward", timeout_s=WITHIN_S)
    gateway.process.send_signal(FREEZE)
    time.sleep(FROZEN_S)
    gateway.process.send_signal(GO_ON)
    ended = gateway.expect("ended", timeout_s=WITHIN_S)
    assert not ended.startswith("done"), ended
    # DDS may drop an acceptance that comes to a client which its server has not found yet.
    assert "ROSIC itself stood still for " in ended or "has not answered for" in ended
    peer.expect("called off after", timeout_s=WITHIN_S)
