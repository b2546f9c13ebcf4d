"""Publishers and subscriptions without quality-of-service events.

Left alone, rclpy makes an event for each, to log incompatible quality of service. Under the
executor driven by events (rclpy 9.1) such an event ends the process with a segmentation fault, so
that any node with an odd setting could take the gateway down. `meeting` says the same, by looking.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject


@cache
def publisher_events() -> RosObject:
    """Return the ``event_callbacks`` of a publisher that has none."""
    return _module().PublisherEventCallbacks(use_default_callbacks=False)


@cache
def subscription_events() -> RosObject:
    """Return the ``event_callbacks`` of a subscription that has none."""
    return _module().SubscriptionEventCallbacks(use_default_callbacks=False)


def _module() -> RosObject:
    try:
        return import_module("rclpy.event_handler")
    except ImportError:  # until Humble
        return import_module("rclpy.qos_event")
