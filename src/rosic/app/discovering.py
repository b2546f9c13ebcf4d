"""Looking at the live ROS 2 graph, and drafting a profile for every robot that is seen there."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

from rosic.app.drafting import Seen, drafted, robot_id
from rosic.errors import ConfigurationError, RosicError
from rosic.robots.ros2.graph import Snapshot, snapshot
from rosic.robots.ros2.registry import TypeRegistry
from rosic.robots.ros2.runtime import RosRuntime

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosic.contracts.clock import Clock

NODE = "rosic_discover"
OURS = frozenset({"chat_interface", NODE})
TELLING = ("/cmd_vel", "/odom", "/joint_states", "/to_robot_topic")


async def discover(clock: Clock, *, seconds: float) -> dict[str, str]:
    """Look at the graph for a while. Return a profile for each robot, by its id.

    Raises:
        RosMissing: There is no ROS 2 here.
        ConfigurationError: Nobody is on the graph.
    """
    runtime = await RosRuntime.open(TypeRegistry(()), node_name=NODE)
    try:
        await clock.sleep(seconds)
        found = await snapshot(runtime)
    finally:
        await runtime.close()
    robots = robots_in(found)
    if not robots:
        raise ConfigurationError(
            f"No robot was seen on the ROS 2 graph within {seconds:g} s.",
            hint="Check ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE, or look for longer.",
        )
    return {robot_id(seen.namespace): drafted(seen, goal_fields) for seen in robots}


def robots_in(found: Snapshot) -> list[Seen]:
    """Sort what is on the graph by its first name; what can neither move nor tell is left out."""
    spaces: defaultdict[str, tuple[dict[str, str], ...]] = defaultdict(lambda: ({}, {}, {}, {}))
    for topic in found.topics:
        space = spaces[_space(topic.name)]
        if topic.subscribers:
            space[0][topic.name] = topic.types[0]
        if topic.publishers:
            space[1][topic.name] = topic.types[0]
    for offers, at in ((found.services, 2), (found.actions, 3)):
        for offer in offers:
            spaces[_space(offer.name)][at][offer.name] = offer.types[0]
    seen = [Seen(name, *parts) for name, parts in sorted(spaces.items())]
    return [robot for robot in seen if robot.actions or _tells(robot.heard) or _tells(robot.said)]


def goal_fields(kind: str) -> Mapping[str, str] | None:
    """Return the fields of an action's goal; None when its type is not installed here."""
    try:
        action = TypeRegistry((kind,)).action(kind)
    except RosicError:
        return None
    fields: Mapping[str, str] = action.Goal.get_fields_and_field_types()
    return fields


def _space(name: str) -> str:
    parts = name.split("/")
    return f"/{parts[1]}" if len(parts) > 2 else ""  # noqa: PLR2004 - "", space, name


def _tells(topics: Iterable[str]) -> bool:
    return any(name.endswith(TELLING) for name in topics)
