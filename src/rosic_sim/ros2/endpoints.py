"""Publishers and subscriptions of a simulated robot, and who opens them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from rosic.robots.ros2.client.qos import publisher_events, subscription_events

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.robots.machines.stepped_machine import SteppedMachine

DEPTH = 10


class SimulatedRobotNode(Protocol):
    """A node that carries one machine, as its actions and its faults see it.

    Attributes:
        id: Of the robot.
        node: The node itself, of rclpy.
        model: Which sort of robot it is.
        machine: What moves.
        linked: False while its radio is cut on purpose.
    """

    id: str
    node: RosObject
    model: str
    machine: SteppedMachine
    linked: bool

    def now_s(self) -> float:
        """Return the present on the machine's clock."""
        ...

    def start_s(self, stamp: RosObject) -> float | None:
        """Return a common start on the machine's clock; None when none was given."""
        ...

    def began(self, skill: str, goal: str) -> None:
        """Take down that the machine begins to act."""
        ...


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
