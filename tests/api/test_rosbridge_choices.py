"""Services and actions whose fields a choice decides, called by clients of rosbridge."""

from __future__ import annotations

from math import cos, pi, sin
from typing import TYPE_CHECKING, Any

import msgspec
import pytest
from msgspec.structs import replace

from rosic.config.profiles import known_units, read_profile, shipped_profiles
from rosic.robots.ros2.profile import Ros2Skill
from tests.api.bridge_client import bridge
from tests.api.served import served

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile

LIGHT = {
    "id": "light",
    "class": "task",
    "parameters": {
        "state": {
            "choices": {"on": [], "off": [], "warm": []},
            "means": {
                "on": {"value": True, "kelvin": 5000.0, "name": "day", "rgb": [1.0, 1.0]},
                "off": {"value": False, "kelvin": 0.0, "name": "", "rgb": [0.0, 0.0]},
                "warm": {"value": True, "kelvin": 2700.0, "name": "sun", "rgb": [1.0, 0.5]},
            },
        }
    },
}
SIMPLE = {"data": "$state.value"}
WHOLE = SIMPLE | {"kelvin": "$state.kelvin", "name": "$state.name", "rgb": "$state.rgb"}


def shipped(name: str) -> Profile:
    read = read_profile(shipped_profiles()[name], known_units(), link="simulated")
    assert read.profile is not None
    return read.profile


def lit(request: dict[str, str]) -> Profile:
    """Return omni with a light that is switched by a service."""
    service = {"name": "/omni/light", "type": "std_srvs/srv/SetBool", "request": request}
    light = msgspec.convert(LIGHT | {"service": service}, Ros2Skill)
    omni = shipped("omni")
    return replace(omni, skills=dict(omni.skills) | {"light": light})


async def called(profile: Profile, args: dict[str, Any]) -> tuple[bool, Any, list[Any]]:
    """Call the light; return whether that did, what was answered, and what was ordered."""
    async with (
        served(profiles=(profile,)) as place,
        bridge(place, await place.key("operator")) as client,
    ):
        await client.say("call_service", service="/omni/light", args=args, id=1)
        answer = await client.op("service_response")
        ordered = [one.arguments for one in place.server.context.feed.newest()]
        return answer["result"], answer["values"], ordered


@pytest.mark.parametrize(
    ("request_of", "args", "state"),
    [
        (SIMPLE, {"data": False}, "off"),
        (WHOLE, {"data": True, "kelvin": 2700, "name": "sun", "rgb": [1, 0.5]}, "warm"),
        (WHOLE, {"data": False}, "off"),
    ],
)
async def test_a_field_is_read_back_into_the_choice_that_means_it(
    request_of: dict[str, str], args: dict[str, Any], state: str
) -> None:
    good, _, ordered = await called(lit(request_of), args)
    assert (good, ordered) == (True, [{"state": state}])


@pytest.mark.parametrize(
    ("request_of", "args", "sentence"),
    [
        (
            SIMPLE,
            {"data": True},
            "data stands for each of these: on, warm. Give it as an order, or in a chat.",
        ),
        (SIMPLE, {"data": 1}, "data stands for none of these: on, off, warm."),
        (SIMPLE, {}, "state has to be said, too."),
        (
            WHOLE,
            {"data": True, "kelvin": 5000, "name": "day"},
            "data, kelvin, name, rgb stands for none of these: on, off, warm.",
        ),
        (SIMPLE, {"data": False, "more": 1}, "more must be 0 here."),
    ],
)
async def test_what_stands_for_no_choice_or_for_several_is_refused_in_a_sentence(
    request_of: dict[str, str], args: dict[str, Any], sentence: str
) -> None:
    good, values, ordered = await called(lit(request_of), args)
    assert (good, ordered) == (False, [])
    assert sentence in values


def pose(x: float, y: float, yaw_rad: float) -> dict[str, Any]:
    """Return a goal of Nav2, as panels send it."""
    turned = {"x": 0.0, "y": 0.0, "z": round(sin(yaw_rad / 2), 5), "w": round(cos(yaw_rad / 2), 5)}
    return {
        "pose": {
            "header": {"frame_id": "map", "stamp": {"sec": 0, "nanosec": 0}},
            "pose": {"position": {"x": x, "y": y, "z": 0.0}, "orientation": turned},
        },
        "behavior_tree": "",
    }


@pytest.mark.parametrize(
    ("skill", "goal", "arguments"),
    [
        ("visit", pose(-2.5, 1.5, 1.57), {"place": "door"}),
        ("visit", pose(-2.5, 1.5, 1.57 - 2 * pi), {"place": "door"}),
        ("goto", pose(1.0, 2.0, 0.5), {"x": 1.0, "y": 2.0, "yaw": pytest.approx(0.5, abs=1e-4)}),
        ("goto", pose(-0.6, 0.5, -0.5), {"x": -0.6, "y": 0.5, "yaw": pytest.approx(-0.5, 1e-3)}),
    ],
)
async def test_a_pose_of_nav2_is_read_back_into_the_place_or_the_heading_that_it_means(
    skill: str, goal: dict[str, Any], arguments: dict[str, Any]
) -> None:
    rover = replace(shipped("omni"), skills={skill: shipped("rover").skills[skill]})
    async with (
        served(profiles=(rover,)) as place,
        bridge(place, await place.key("operator")) as client,
    ):
        tilted = goal | {"pose": goal["pose"] | {"pose": {"orientation": {"x": 1.0}}}}
        for asked in (goal, tilted):
            await client.say(
                "send_action_goal", action="/rover/navigate_to_pose", args=asked, feedback=True
            )
        refused = await client.op("action_result")
        assert refused["values"] == "pose.pose.orientation must be an upright orientation here."
        await place.until(lambda: list(place.server.context.feed.newest()))
        [order] = place.server.context.feed.newest()
        assert order.arguments == arguments
