"""What the parts of robot messaging share."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.store import Store
    from rosic.features.robot_to_robot.permissions import PeerPermissions
    from rosic.features.robot_to_robot.subscriptions import Subscriptions
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.transactions import Transactions


class RobotToRobotContext(NamedTuple):
    """Who may what, how it changes, how it is told, and what time it is."""

    rights: PeerPermissions
    rooms: Components
    changes: Transactions
    reach: Notifier
    post: Subscriptions
    store: Store
    clock: Clock
    entropy: Entropy
