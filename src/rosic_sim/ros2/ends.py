"""Publishers and subscriptions of a simulated robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.robots.ros2.client.qos import publisher_events, subscription_events

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.robots.ros2.client.rclpy_import import RosObject

DEPTH = 10


def publisher(node: RosObject, kind: RosObject, topic: str, quality: object = DEPTH) -> RosObject:
    """Open a publisher; reliable unless ``quality`` says otherwise."""
    return node.create_publisher(kind, topic, quality, event_callbacks=publisher_events())


def subscribe(
    node: RosObject,
    kind: RosObject,
    topic: str,
    heard: Callable[[RosObject], None],
    quality: object = DEPTH,
) -> None:
    """Open a subscription, which the node keeps."""
    events = subscription_events()
    node.create_subscription(kind, topic, heard, quality, event_callbacks=events)
