"""Puts robots among themselves together: who speaks, what they share, who reads along."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.config.validation import ValidationFinding
from rosic.contracts.among import PeerRobot
from rosic.core.identity import ROBOT
from rosic.errors import ConfigurationError
from rosic.features.fleet.assisting import AssistCommands
from rosic.features.robot_to_robot.commands import RobotToRobotCommands
from rosic.features.robot_to_robot.context import RobotToRobotContext
from rosic.features.robot_to_robot.digest import ConversationDigests
from rosic.features.robot_to_robot.guard import LoopGuard
from rosic.features.robot_to_robot.help_service import HelpService
from rosic.features.robot_to_robot.permissions import PeerPermissions
from rosic.features.robot_to_robot.service import PeerGroup, RobotMessaging
from rosic.features.robot_to_robot.shared_state import SharedState
from rosic.features.robot_to_robot.strategies import Strategies
from rosic.features.robot_to_robot.subscriptions import Subscriptions

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosic.app.gateway import Gateway, GatewayParts
    from rosic.config.gateway_file import ConfigFile
    from rosic.core.records import Memory
    from rosic.core.robot.profile import Profile
    from rosic.gateway.delivery.sender import ChatSender


def fellowship_of(
    gateway: Gateway, parts: GatewayParts, teller: ChatSender, memory: Memory
) -> RobotMessaging:
    """Make it for a gateway whose rooms are furnished, and have its robots meet.

    Raises:
        ConfigurationError: A messenger speaks for robots, so anybody there could be one.
    """
    if any(messenger.platform == ROBOT for messenger in parts.messengers):
        raise ConfigurationError(f"No messenger may be called {ROBOT!r}: robots' addresses are.")
    rooms, changes, reach = gateway.rooms, gateway.access.changes, gateway.furnishing.reach
    clock, entropy = parts.clock, parts.entropy
    rights, guard = PeerPermissions(rooms), LoopGuard()
    board = SharedState(clock.wall_ns)
    post = Subscriptions(rights, board, guard, clock)
    fleet = gateway.furnishing.fleet
    book = fleet.help_book
    around = RobotToRobotContext(rights, rooms, changes, reach, post, parts.store, clock, entropy)
    circle = PeerGroup(
        around,
        board,
        guard,
        HelpService(book, around),
        Strategies(around),
        ConversationDigests(post, rights, rooms.authoriser, teller, reach.messengers),
    )
    fellowship = RobotMessaging(circle)
    fellowship.restore(memory.facts)
    RobotToRobotCommands(fellowship, rooms).employ(gateway.pipeline.reception.office)
    circle.desk.tasks = AssistCommands(rooms, fleet.dispatching, fleet.watching)
    gateway.holding.also_ends.append(post.end_all)
    gateway.holding.also_ended.append(fleet.dispatching.ended)
    for robot, adapter in gateway.robots.items():
        if isinstance(adapter, PeerRobot):
            fellowship.join(robot, adapter)
    return fellowship


def robot_findings(file: ConfigFile, robots: Iterable[Profile]) -> Iterator[ValidationFinding]:
    """Find principals that are robots which are not there."""
    known = {profile.id for profile in robots}
    for index, person in enumerate(file.principal):
        for address in (person.address, *person.addresses):
            platform, _, robot = address.partition(":")
            if platform == ROBOT and robot not in known:
                yield ValidationFinding(
                    ("principal", index),
                    f"{person.name} is to be the robot {robot}, and there is no such [[robot]].",
                    f"There are: {', '.join(sorted(known)) or 'none'}.",
                )
