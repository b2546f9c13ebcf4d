"""Groups, their topics, channels, and the menus that messengers show."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.contracts.messenger import menus_of, watch_chats
from rosic.core.policy.scope import FLEET
from rosic.features.groups.channels import ChannelDisplays
from rosic.features.groups.membership import KIND as DEAF
from rosic.features.groups.membership import GroupMembership, GroupQueries
from rosic.features.groups.topic_binding import KIND as TOPIC
from rosic.features.groups.topic_binding import TopicBindings
from rosic.gateway.command_menus import CommandMenus
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import ChatEvent
    from rosic.gateway.feature import Kernel

__all__ = ["GroupsFeature", "setup"]

NEEDS: Final = ("dashboards",)


class GroupsFeature(Feature):
    """Follows what messengers say of their chats.

    Attributes:
        groups: Follows what happens to chats.
        topics: What topics are about.
        menus: What people are offered while they type.
        windows: What channels show.
    """

    def __init__(
        self,
        groups: GroupMembership,
        topics: TopicBindings,
        menus: CommandMenus,
        windows: ChannelDisplays,
    ) -> None:
        self.groups, self.topics, self.menus, self.windows = groups, topics, menus, windows

    def passed(self, messenger: Messenger, passing: ChatEvent) -> None:
        """Follow what has happened to a chat. Returns at once."""
        if not passing.chat.id:  # it listens, so it can be reached
            self.menus.look()
        self.groups.passed(messenger, passing)
        self.windows.passed(messenger, passing)


def setup(kernel: Kernel) -> GroupsFeature:
    """Take over what topics are about, and follow groups, channels and menus from now on."""
    rooms, changes, orders = kernel.rooms, kernel.changes, kernel.orders
    vocabularies, profiles = rooms.vocabularies, rooms.profiles
    groups = GroupMembership(
        GroupQueries(
            rooms=rooms,
            followers=kernel.pipeline.followers,
            chat_sender=orders.chat_sender,
            reach=kernel.reach,
            changes=changes,
            archive=kernel.archive,
            clock=kernel.machine_clock,
            place=kernel.site.name,
            admins=kernel.admins,
            cards=kernel.shared.dashboards.get(),
        )
    )
    groups.restore(kernel.memory.facts.get(DEAF, ()))
    topics = TopicBindings(
        rooms.organiser,
        changes,
        lambda name: (name,) if name in profiles else vocabularies.current.members(name),
    )
    topics.restore(kernel.memory.facts.get(TOPIC, ()))
    rooms.container.here.bind(topics.of)
    kernel.commands.register("topic", topics.topic)
    languages = orders.chat_sender.languages
    menus = CommandMenus(
        rooms.authoriser.directory,
        partial(_admins, kernel),
        languages.catalogues(),
        languages.chosen,
        kernel.machine_clock,
        rooms.vocabulary.commands,
    )
    changes.after(menus.look)
    windows = ChannelDisplays(
        kernel.shared.dashboards.get(), rooms, changes, kernel.reach, kernel.machine_clock
    )
    windows.register(kernel.commands)
    feature = GroupsFeature(groups, topics, menus, windows)
    for messenger in kernel.messengers:
        watch_chats(messenger, partial(feature.passed, messenger))
        if (set_menus := menus_of(messenger)) is not None:
            menus.show_on(messenger.platform, set_menus)
    return feature


def _admins(kernel: Kernel) -> list[PrincipalId]:
    """Return who looks after people here: who may let them in, or gives them rights."""
    rights, grants_book = kernel.enforcer.policy.rights, kernel.enforcer.policy.grants_book
    now_ns = kernel.machine_clock.wall_ns()
    return sorted(
        who
        for who in grants_book.everybody()
        if any(rights.holds(who, FLEET, verb, now_ns) for verb in ("people", "grant"))
    )
