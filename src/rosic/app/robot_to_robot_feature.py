"""Puts together what goes beyond single messages: groups, their topics, menus of commands."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rosic.config.translations import LANGUAGES, catalogue
from rosic.contracts.file_rules import ValidationFinding
from rosic.contracts.messenger import menus_of, watch_chats
from rosic.contracts.robot import PeerRobot
from rosic.core.identity import ROBOT
from rosic.core.policy.scope import FLEET
from rosic.errors import ConfigurationError
from rosic.features.fleet.integration import AssistCommands
from rosic.features.groups.channels import ChannelDisplays
from rosic.features.groups.membership import KIND as DEAF
from rosic.features.groups.membership import GroupMembership, GroupQueries
from rosic.features.groups.topic_binding import KIND as TOPIC
from rosic.features.groups.topic_binding import TopicBindings
from rosic.features.robot_to_robot.commands import RobotToRobotCommands
from rosic.features.robot_to_robot.context import RobotToRobotContext
from rosic.features.robot_to_robot.digest import ConversationDigests
from rosic.features.robot_to_robot.help_service import HelpService
from rosic.features.robot_to_robot.inbox import LoopGuard
from rosic.features.robot_to_robot.permissions import PeerPermissions
from rosic.features.robot_to_robot.service import PeerGroup, RobotMessaging
from rosic.features.robot_to_robot.shared_state import SharedState
from rosic.features.robot_to_robot.strategies import Strategies
from rosic.features.robot_to_robot.subscriptions import Subscriptions
from rosic.gateway.command_menus import CommandMenus

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosic.app.gateway_parts import RunningGateway
    from rosic.app.policy import PolicyService
    from rosic.app.settings import GatewayParts
    from rosic.config.gateway_file import ConfigFile
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import ChatEvent
    from rosic.core.records import Memory
    from rosic.core.robot.profile import Profile
    from rosic.gateway import Pipeline
    from rosic.gateway.delivery.sender import ChatSender


# ---- groups, topics and menus ----


class GroupsFeature:
    """Groups, topics and menus of one gateway.

    Attributes:
        groups: Follows what happens to chats.
        topics: What topics are about.
        menus: What people are offered while they type.
        windows: What channels show, where that is possible.
    """

    def __init__(
        self,
        pipeline: Pipeline,
        authority: PolicyService,
        around: GroupQueries,
    ) -> None:
        rooms, changes = around.rooms, around.changes
        self.groups = GroupMembership(around)
        vocabularies, profiles = rooms.vocabularies, rooms.profiles
        self.topics = TopicBindings(
            rooms.organiser,
            changes,
            lambda name: (name,) if name in profiles else vocabularies.current.members(name),
        )
        rooms.container.here.bind(self.topics.of)
        pipeline.hooks.commands.register("topic", self.topics.topic)
        directory = rooms.authoriser.directory
        others = {code: found for code in LANGUAGES if (found := catalogue(code)) is not None}
        admins = partial(_admins, authority, around.clock)
        self.windows: ChannelDisplays | None = None
        self.menus = CommandMenus(
            directory,
            admins,
            others,
            around.chat_sender.languages.chosen,
            around.clock,
            rooms.vocabulary.commands,
        )
        changes.after(self.menus.look)

    def gather(self, messengers: Iterable[Messenger], memory: Memory) -> None:
        """Take over what was, and follow what happens from now on."""
        self.groups.restore(memory.facts.get(DEAF, ()))
        self.topics.restore(memory.facts.get(TOPIC, ()))
        for messenger in messengers:
            watch_chats(messenger, partial(self._passed, messenger))
            if (set_menus := menus_of(messenger)) is not None:
                self.menus.show_on(messenger.platform, set_menus)

    def _passed(self, messenger: Messenger, passing: ChatEvent) -> None:
        if not passing.chat.id:  # it listens, so it can be reached
            self.menus.look()
        self.groups.passed(messenger, passing)
        if self.windows is not None:
            self.windows.passed(messenger, passing)


def groups_of(
    gateway: RunningGateway, chat_sender: ChatSender, clock: Clock, place: str
) -> GroupsFeature:
    """Make it for a gateway whose rooms are set up."""
    features, pipeline = gateway.features, gateway.pipeline
    around = GroupQueries(
        rooms=gateway.rooms,
        followers=pipeline.followers,
        chat_sender=chat_sender,
        reach=features.reach,
        changes=gateway.access.changes,
        archive=gateway.data_feature.archive,
        clock=clock,
        place=place,
        admins=features.admins,
        cards=features.live_cards,
    )
    groups_feature = GroupsFeature(pipeline, gateway.authority, around)
    groups_feature.windows = ChannelDisplays(
        features.live_cards, gateway.rooms, gateway.access.changes, features.reach
    )
    groups_feature.windows.register(pipeline.hooks.commands)
    return groups_feature


def _admins(authority: PolicyService, clock: Clock) -> list[PrincipalId]:
    """Return who looks after people here: who may let them in, or gives them rights."""
    rights, grants_book = authority.rights, authority.grants_book
    now_ns = clock.wall_ns()
    return sorted(
        who
        for who in grants_book.everybody()
        if any(rights.holds(who, FLEET, verb, now_ns) for verb in ("people", "grant"))
    )


# ---- robots among themselves ----


def messaging_of(
    gateway: RunningGateway, parts: GatewayParts, chat_sender: ChatSender, memory: Memory
) -> RobotMessaging:
    """Make it for a gateway whose rooms are set up, and have its robots meet.

    Raises:
        ConfigurationError: A messenger speaks for robots, so anybody there could be one.
    """
    if any(messenger.platform == ROBOT for messenger in parts.messengers):
        raise ConfigurationError(f"No messenger may be called {ROBOT!r}: robots' addresses are.")
    rooms, changes, reach = gateway.rooms, gateway.access.changes, gateway.features.reach
    clock, entropy = parts.clock, parts.entropy
    rights, guard = PeerPermissions(rooms), LoopGuard()
    board = SharedState(clock.wall_ns)
    post = Subscriptions(rights, board, guard, clock)
    fleet = gateway.features.fleet
    book = fleet.help_book
    around = RobotToRobotContext(rights, rooms, changes, reach, post, parts.store, clock, entropy)
    circle = PeerGroup(
        around,
        board,
        guard,
        HelpService(book, around, AssistCommands(rooms, fleet.dispatching, fleet.watching)),
        Strategies(around),
        ConversationDigests(post, rights, rooms.authoriser, chat_sender, reach.messengers),
    )
    messaging = RobotMessaging(circle)
    messaging.restore(memory.facts)
    RobotToRobotCommands(messaging, rooms).register(gateway.pipeline.hooks.commands)
    gateway.data_feature.also_ends.append(post.end_all)
    gateway.data_feature.also_ended.append(fleet.dispatching.ended)
    for robot, adapter in gateway.robots.items():
        if isinstance(adapter, PeerRobot):
            messaging.join(robot, adapter)
    return messaging


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
