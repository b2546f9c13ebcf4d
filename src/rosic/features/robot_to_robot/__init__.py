"""Robots among themselves: what they share, ask, answer, and help each other with."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.contracts.robot import PeerRobot
from rosic.core.identity import ROBOT
from rosic.errors import ConfigurationError
from rosic.features.robot_to_robot.commands import RobotToRobotCommands
from rosic.features.robot_to_robot.context import RobotToRobotContext
from rosic.features.robot_to_robot.digest import ConversationDigests
from rosic.features.robot_to_robot.help_requests import HelpRequests
from rosic.features.robot_to_robot.help_service import HelpService
from rosic.features.robot_to_robot.inbox import LoopGuard
from rosic.features.robot_to_robot.permissions import PeerPermissions
from rosic.features.robot_to_robot.service import PeerGroup, RobotMessaging
from rosic.features.robot_to_robot.shared_state import SharedState
from rosic.features.robot_to_robot.strategies import Strategies
from rosic.features.robot_to_robot.subscriptions import Subscriptions
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.gateway.feature import Kernel
    from rosic.gateway.robot_registry import AddedRobot

__all__ = ["RobotToRobotFeature", "setup"]

PROVIDES: Final = ("engaged",)


class RobotToRobotFeature(Feature):
    """The robots of one gateway among themselves.

    Attributes:
        messaging: Carries what they say.
    """

    def __init__(self, messaging: RobotMessaging) -> None:
        self.messaging = messaging

    async def run(self) -> None:
        """Carry it until cancelled."""
        await self.messaging.run()

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Let one more robot meet the others."""
        self.messaging.robot_added(newcomer)


def setup(kernel: Kernel) -> RobotToRobotFeature:
    """Have the robots meet that speak with others, and take over what they had shared.

    Raises:
        ConfigurationError: A messenger speaks for robots, so anybody there could be one.
    """
    if any(messenger.platform == ROBOT for messenger in kernel.messengers):
        raise ConfigurationError(f"No messenger may be called {ROBOT!r}: robots' addresses are.")
    rooms, changes, reach = kernel.rooms, kernel.changes, kernel.reach
    clock, entropy = kernel.machine_clock, kernel.entropy
    rights, guard = PeerPermissions(rooms), LoopGuard()
    shared_state = SharedState(clock.wall_ns)
    post = Subscriptions(rights, shared_state, guard, clock)
    book = HelpRequests(kernel.clock.wall_ns)
    around = RobotToRobotContext(rights, rooms, changes, reach, post, kernel.store, clock, entropy)
    chat_sender = kernel.orders.chat_sender
    circle = PeerGroup(
        around,
        shared_state,
        guard,
        HelpService(book, around, kernel.shared.robot_tasks.find),
        Strategies(around),
        ConversationDigests(post, rights, rooms.authoriser, chat_sender, reach),
    )
    messaging = RobotMessaging(circle)
    messaging.restore(kernel.memory.facts)
    RobotToRobotCommands(messaging, rooms).register(kernel.commands)
    kernel.shared.engaged.provide(book.engages)
    kernel.erasure.join(records=post.end_all)
    for robot, adapter in kernel.robots.items():
        if isinstance(adapter, PeerRobot):
            messaging.join(robot, adapter)
    return RobotToRobotFeature(messaging)
