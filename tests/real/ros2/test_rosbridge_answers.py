"""What robots answer to clients of rosbridge: in the types of their own actions and services."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from rosic.robots.ros2.interfaces.cache import KNOWN, ensure_built, make_importable
from rosic.testing.ros2.graph import RosGraph
from tests.api.bridge_client import bridge
from tests.api.served import ServedGateway, served
from tests.real.ros2.simulated import profile_of, shipped, simulated, until

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

PEER = Path(__file__).with_name("peer.py")
GOAL = "/rover/navigate_to_pose"
ASKING = profile_of(
    id="asking",
    link={"kind": "ros2", "namespace": "/omni"},
    skills={
        name: {
            "class": "observe",
            "service": {
                "name": "/omni/code",
                "type": "action_msgs/srv/CancelGoal",
                "request": {"goal_info.stamp.sec": code},
                "success": "return_code",
                "good": 0,
            },
        }
        for name, code in (("good", 0), ("bad", 2))
    },
)

pytestmark = pytest.mark.limit(240)


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory, interfaces: object) -> Iterator[RosGraph]:  # noqa: ARG001 - built before
    for package in KNOWN.values():
        ensure_built(package)
        make_importable(package)
    folder = tmp_path_factory.mktemp("answers")
    with RosGraph(folder) as graph, simulated(graph, folder, "rover"):
        graph.start(PEER)
        yield graph


@pytest.fixture
async def place(graph: RosGraph) -> AsyncIterator[ServedGateway]:  # noqa: ARG001 - joined by its variables
    async with served(profiles=(shipped("rover"), ASKING)) as place:
        await until(lambda: place.gateway.rooms.linker.presence("rover").online is True)
        yield place


def goal(x_m: float, y_m: float) -> dict[str, Any]:
    """Return a goal of Nav2, as its clients send it."""
    turned = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    place = {"position": {"x": x_m, "y": y_m, "z": 0.0}, "orientation": turned}
    return {"pose": {"header": {"frame_id": "map"}, "pose": place}, "behavior_tree": ""}


async def test_a_goal_is_fed_back_and_answered_in_the_type_of_its_action(
    place: ServedGateway,
) -> None:
    async with bridge(place, await place.key("operator")) as client:
        for (x_m, y_m), status in (((-0.6, 0.5), 4), ((1.2, 0.0), 6)):
            client.told.clear()
            await client.say(
                "send_action_goal",
                action=GOAL,
                action_type="nav2_msgs/action/NavigateToPose",
                args=goal(x_m, y_m),
                feedback=True,
                id=status,
            )
            result = await client.op("action_result")
            assert (result["id"], result["status"], result["result"]) == (status, status, True)
            assert result["values"].keys() == {"error_code", "error_msg"}
            assert bool(result["values"]["error_code"]) is (status == 6)
            fed = [told["values"] for told in client.told if told["op"] == "action_feedback"]
            assert bool(fed) is (status == 4)
            for told in fed:
                assert isfinite(told["current_pose"]["pose"]["position"]["x"])
                assert told["distance_remaining"] >= 0
                assert "fraction" not in told


async def test_a_goal_that_is_cancelled_is_answered_in_the_type_of_its_action(
    place: ServedGateway,
) -> None:
    async with bridge(place, await place.key("operator")) as client:
        args = goal(-4.0, 3.0)
        await client.say("send_action_goal", action=GOAL, args=args, feedback=True, id="far")
        await client.op("action_feedback")  # so it was accepted
        await client.say("cancel_action_goal", action=GOAL, id="far")
        result = await client.op("action_result")
        assert (result["status"], result["result"]) == (5, True)
        assert result["values"].keys() == {"error_code", "error_msg"}


async def test_a_service_is_answered_in_its_own_type(place: ServedGateway) -> None:
    async with bridge(place, await place.key("operator")) as client:
        for code in (0, 2):
            args = {"goal_info": {"stamp": {"sec": code}}}
            await client.say("call_service", service="/omni/code", args=args, id=code)
            answer = await client.op("service_response")
            assert answer["result"] is True, answer
            assert answer["values"] == {"return_code": code, "goals_canceling": []}
