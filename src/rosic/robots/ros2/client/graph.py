"""Who is on the graph now: for presence, and for drafting a profile from a live robot."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rosic.robots.ros2.errors import NotSent
from rosic.robots.ros2.messages.names import check_graph_name, is_under

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime

MAX_ENTRIES = 1024
EVERYWHERE = "/"

# Every node has these; they say nothing about a robot.
_OF_EVERY_NODE = frozenset({"/parameter_events", "/rosout"})
_OF_EVERY_NODE_ENDINGS = (
    "/describe_parameters",
    "/get_parameter_types",
    "/get_parameters",
    "/get_type_description",
    "/list_parameters",
    "/set_parameters",
    "/set_parameters_atomically",
)


@dataclass(frozen=True)
class GraphTopic:
    """A topic, and how many others publish and subscribe to it. Our own ends are not counted.

    Attributes:
        latched: How many of the publishers keep what they said for whoever comes later.
    """

    name: str
    types: tuple[str, ...]
    publishers: int
    subscribers: int
    latched: int = 0


@dataclass(frozen=True)
class OfferedEndpoint:
    """A service or an action that somebody offers."""

    name: str
    types: tuple[str, ...]


@dataclass(frozen=True)
class GraphSnapshot:
    """What was on the graph at one moment.

    Attributes:
        nodes: Full names. A node can be absent for a moment while its endpoints are there.
        topics: With at least one end that is not ours.
        services: With a server; those that every node has are left out.
        actions: With a server.
        complete: False when there was more than fits.
    """

    nodes: tuple[str, ...]
    topics: tuple[GraphTopic, ...]
    services: tuple[OfferedEndpoint, ...]
    actions: tuple[OfferedEndpoint, ...]
    complete: bool

    @property
    def empty(self) -> bool:
        """Whether nobody is there."""
        return not (self.nodes or self.topics or self.services or self.actions)


async def snapshot(runtime: RosRuntime, namespace: str = EVERYWHERE) -> GraphSnapshot:
    """Look at the graph once.

    Args:
        runtime: Whose own endpoints are left out.
        namespace: Only what lies below it; ``/kuka1`` does not contain ``/kuka10``.

    Raises:
        BadName: That is no namespace.
        NotSent: The link is closed.
    """
    below = EVERYWHERE if namespace == EVERYWHERE else check_graph_name(namespace)
    return await runtime.thread.run(lambda: _look(runtime, below))


async def wait_for(
    runtime: RosRuntime,
    condition: Callable[[GraphSnapshot], bool],
    *,
    namespace: str = EVERYWHERE,
    timeout_s: float,
    every_s: float = 0.05,
) -> GraphSnapshot:
    """Look again and again until ``condition`` holds; what joins is seen after up to 2 s.

    Raises:
        NotSent: It has not come to hold in time, or the link is closed.
    """
    try:
        async with asyncio.timeout(timeout_s):
            # The graph tells nobody when it changes: it has to be looked at.
            while not condition(seen := await snapshot(runtime, namespace)):  # noqa: ASYNC110
                await asyncio.sleep(every_s)
    except TimeoutError:
        raise NotSent(f"What was expected under {namespace} did not appear on the graph.") from None
    return seen


def _look(runtime: RosRuntime, namespace: str) -> GraphSnapshot:
    """Ask rclpy; on the ROS thread. A graph of 200 names takes a few milliseconds."""
    node, own = runtime.thread.node, runtime.node_name
    listed = (
        node.get_topic_names_and_types(),
        node.get_service_names_and_types(),
        runtime.ros.action.get_action_names_and_types(node),
    )
    topics, services, actions = (
        [
            (name, tuple(types))
            for name, types in entries
            if is_under(name, namespace) and "/_" not in name  # hidden: the insides of an action
        ]
        for entries in listed
    )
    keeps = runtime.ros.qos.DurabilityPolicy.TRANSIENT_LOCAL
    seen = (
        GraphTopic(
            name,
            types,
            len(publishers := _others(node.get_publishers_info_by_topic, name, own)),
            len(_others(node.get_subscriptions_info_by_topic, name, own)),
            sum(end.qos_profile.durability == keeps for end in publishers),
        )
        for name, types in topics[:MAX_ENTRIES]
        if name not in _OF_EVERY_NODE
    )
    return GraphSnapshot(
        nodes=_nodes(node, namespace)[:MAX_ENTRIES],
        topics=tuple(topic for topic in seen if topic.publishers or topic.subscribers),
        services=tuple(
            OfferedEndpoint(name, types)
            for name, types in services[:MAX_ENTRIES]
            if not name.endswith(_OF_EVERY_NODE_ENDINGS) and node.count_services(name)
        ),
        actions=tuple(
            OfferedEndpoint(name, types)
            for name, types in actions[:MAX_ENTRIES]
            if node.count_services(f"{name}/_action/send_goal")
        ),
        complete=max(map(len, (topics, services, actions))) <= MAX_ENTRIES,
    )


def _nodes(node: RosObject, namespace: str) -> tuple[str, ...]:
    own = node.get_fully_qualified_name()
    names = {f"{space.rstrip('/')}/{name}" for name, space in node.get_node_names_and_namespaces()}
    return tuple(sorted(name for name in names - {own} if is_under(name, namespace)))


def _others(ends: Callable[[str], list[RosObject]], topic: str, own: str) -> list[RosObject]:
    """Return the ends that belong to other nodes: a robot that is gone leaves only ours."""
    return [end for end in ends(topic) if end.node_name != own]
