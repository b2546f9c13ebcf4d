from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.client.graph import (
    GraphSnapshot,
    GraphTopic,
    OfferedEndpoint,
    snapshot,
    wait_for,
)
from rosic.robots.ros2.errors import BadName, NotSent
from rosic.robots.ros2.messages.names import is_under

if TYPE_CHECKING:
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.testing.ros2.graph import RosProcess

TRIGGER = "std_srvs/srv/Trigger"


@pytest.mark.usefixtures("mover")
async def test_a_robot_is_seen_with_all_it_offers(runtime: RosRuntime) -> None:
    seen = await wait_for(
        runtime,
        lambda now: len(now.services) >= 5 and bool(now.actions and now.nodes),
        namespace="/omni",
        timeout_s=60,
    )
    assert seen.complete
    assert seen.nodes == ("/omni/robot",)
    assert GraphTopic("/omni/cmd_vel", ("geometry_msgs/msg/Twist",), 0, 1) in seen.topics
    assert GraphTopic("/omni/count", ("std_msgs/msg/Int32",), 1, 0) in seen.topics
    assert set(seen.services) == {
        OfferedEndpoint("/omni/code", ("action_msgs/srv/CancelGoal",)),
        OfferedEndpoint("/omni/latch", ("std_srvs/srv/SetBool",)),
        OfferedEndpoint("/omni/slow", ("std_srvs/srv/SetBool",)),
        OfferedEndpoint("/omni/stop", (TRIGGER,)),
        OfferedEndpoint("/omni/take", ("diagnostic_msgs/srv/AddDiagnostics",)),
    }
    assert seen.actions == (OfferedEndpoint("/omni/move", ("rosic_interfaces/action/Move",)),)


@pytest.mark.usefixtures("interfaces")
async def test_our_own_ends_are_not_a_robot(runtime: RosRuntime) -> None:
    await runtime.latest("/omni/count", "std_msgs/msg/Int32")
    await runtime.publisher("/omni/cmd_vel", "geometry_msgs/msg/Twist")
    await runtime.service("/omni/stop", TRIGGER)
    await runtime.action("/omni/move", "rosic_interfaces/action/Move")
    assert (await snapshot(runtime)).empty


async def test_a_robot_that_is_gone_is_gone_from_the_graph(
    runtime: RosRuntime, peer: RosProcess
) -> None:
    await runtime.latest("/omni/count", "std_msgs/msg/Int32")
    await wait_for(runtime, lambda now: bool(now.topics), namespace="/omni", timeout_s=60)
    assert peer.stop() == 0
    await wait_for(runtime, lambda now: now.empty, namespace="/omni", timeout_s=60)


async def test_waiting_is_bounded(runtime: RosRuntime) -> None:
    looks: list[GraphSnapshot] = []

    def never(now: GraphSnapshot) -> bool:
        looks.append(now)
        return False

    with pytest.raises(NotSent, match="did not appear"):
        await wait_for(runtime, never, timeout_s=0.2)
    assert len(looks) > 1
    assert all(look.empty for look in looks), looks


async def test_a_namespace_that_is_none_is_refused(runtime: RosRuntime) -> None:
    with pytest.raises(BadName):
        await snapshot(runtime, "/omni *")


@pytest.mark.parametrize(
    ("name", "namespace", "inside"),
    [
        ("/kuka1/stop", "/kuka1", True),
        ("/kuka10/stop", "/kuka1", False),
        ("/kuka1", "/kuka1", True),
        ("/anything", "/", True),
    ],
)
def test_a_namespace_ends_at_a_slash(name: str, namespace: str, *, inside: bool) -> None:
    assert is_under(name, namespace) is inside
