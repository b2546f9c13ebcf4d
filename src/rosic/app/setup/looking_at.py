"""A short look at robots that were found: where they stand, so that a draft begins there."""

from __future__ import annotations

from math import atan2
from typing import TYPE_CHECKING, Any, Final

from rosic.app.setup.profile_draft import BATTERY, JOINTS, LOCATED, ODOMETRY, SeenRobot
from rosic.app.setup.profile_draft_nav2 import FOLLOW, NAVIGATE, ArmDraft, NavigatorDraft
from rosic.errors import RosicError
from rosic.robots.ros2.client.topics import TopicQos

if TYPE_CHECKING:
    from rosic.robots.ros2.client.runtime import RosRuntime

GET_PARAMETERS: Final = "rcl_interfaces/srv/GetParameters"
TYPES: Final = (BATTERY, LOCATED, JOINTS, ODOMETRY, GET_PARAMETERS)
HEARD_WITHIN_S: Final = 1.5
KEPT: Final = TopicQos(reliable=True, latched=True, depth=1)
VOLATILE: Final = TopicQos(reliable=False, depth=1)
STRING_ARRAY: Final = 9


async def looked_at(runtime: RosRuntime, seen: SeenRobot) -> SeenRobot:
    """Return a robot with where it stands, as far as it says so within a moment."""
    kinds = set(seen.actions.values())
    if NAVIGATE in kinds:
        seen = seen._replace(stand=await _stand(runtime, seen))
    if FOLLOW in kinds:
        seen = seen._replace(limbs=await _limbs(runtime, seen))
    return seen


async def _stand(runtime: RosRuntime, seen: SeenRobot) -> NavigatorDraft | None:
    located = await _heard(runtime, seen, LOCATED)
    if located is None:
        return None
    pose = located.pose.pose
    yaw = 2 * atan2(pose.orientation.z, pose.orientation.w)
    return NavigatorDraft(pose.position.x, pose.position.y, yaw, located.header.frame_id or "map")


async def _limbs(runtime: RosRuntime, seen: SeenRobot) -> dict[str, ArmDraft]:
    state = await _heard(runtime, seen, JOINTS)
    if state is None:
        return {}
    topic = _topic(seen, JOINTS)
    positions = dict(zip(state.name, map(float, state.position), strict=False))
    found = {}
    for action, kind in sorted(seen.actions.items()):
        if kind == FOLLOW:
            names = await _controlled(runtime, action) or list(positions)
            if set(names) <= positions.keys():
                found[action] = ArmDraft(topic, {name: positions[name] for name in names})
    return found


async def _controlled(runtime: RosRuntime, action: str) -> list[str]:
    """Return the joints that a controller says are its own; nothing if it does not say."""
    controller = action.rpartition("/")[0]
    link = await runtime.service(f"{controller}/get_parameters", GET_PARAMETERS)
    try:
        answer = await link.call(
            {"names": ["joints"]}, timeout_s=HEARD_WITHIN_S, found_within_s=HEARD_WITHIN_S
        )
    except RosicError:
        return []
    finally:
        await link.close()
    values = [value for value in answer.values if value.type == STRING_ARRAY]
    return [str(name) for value in values for name in value.string_array_value]


async def _heard(runtime: RosRuntime, seen: SeenRobot, kind: str) -> Any:  # noqa: ANN401 - a message
    topic = _topic(seen, kind)
    if not topic:
        return None
    # What is kept for whoever comes later, and what is said again and again, take two ears.
    for quality in (KEPT, VOLATILE):
        latest = await runtime.latest(topic, kind, quality)
        try:
            await latest.newer(0, timeout_s=HEARD_WITHIN_S)
            return latest.message()
        except (TimeoutError, RosicError):
            continue
        finally:
            await latest.close()
    return None


def _topic(seen: SeenRobot, kind: str) -> str:
    return min((name for name, found in seen.said.items() if found == kind), default="")
