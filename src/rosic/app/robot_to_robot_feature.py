"""Puts together what goes beyond single messages: groups, their topics, menus of commands."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rosic.config.translations import LANGUAGES, catalogue
from rosic.contracts.messenger import menus_of, watch_chats
from rosic.core.policy.scope import FLEET
from rosic.features.groups.channels import ChannelDisplays
from rosic.features.groups.membership import KIND as DEAF
from rosic.features.groups.membership import GroupMembership, GroupQueries
from rosic.features.groups.topic_binding import KIND as TOPIC
from rosic.features.groups.topic_binding import TopicBindings
from rosic.gateway.commands import CommandMenus

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.app.gateway import Gateway
    from rosic.app.policy import PolicyService
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Passing
    from rosic.core.records import Memory
    from rosic.gateway import Pipeline
    from rosic.gateway.delivery.sender import ChatSender


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
        vocabulary, profiles = rooms.vocabulary, rooms.profiles
        self.topics = TopicBindings(
            rooms.organiser,
            changes,
            lambda name: (name,) if name in profiles else vocabulary.members(name),
        )
        rooms.container.here = self.topics.of
        pipeline.reception.office.employ("topic", self.topics.topic)
        directory = rooms.authoriser.directory
        others = {code: found for code in LANGUAGES if (found := catalogue(code)) is not None}
        admins = partial(_admins, authority, around.clock)
        self.windows: ChannelDisplays | None = None
        self.menus = CommandMenus(
            directory, admins, others, around.teller.languages.chosen, around.clock
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

    def _passed(self, messenger: Messenger, passing: Passing) -> None:
        if not passing.chat.id:  # it listens, so it can be reached
            self.menus.look()
        self.groups.passed(messenger, passing)
        if self.windows is not None:
            self.windows.passed(messenger, passing)


def gathering_of(gateway: Gateway, teller: ChatSender, clock: Clock, place: str) -> GroupsFeature:
    """Make it for a gateway whose rooms are furnished."""
    furnishing, pipeline = gateway.furnishing, gateway.pipeline
    around = GroupQueries(
        rooms=gateway.rooms, audience=pipeline.audience, teller=teller, reach=furnishing.reach,
        changes=gateway.access.changes, archive=gateway.holding.archive, clock=clock, place=place,
        admins=furnishing.admins, cards=furnishing.live_cards,
    )  # fmt: skip
    gathering = GroupsFeature(pipeline, gateway.authority, around)
    gathering.windows = ChannelDisplays(
        furnishing.live_cards, gateway.rooms, gateway.access.changes, furnishing.reach
    )
    gathering.windows.employ(pipeline.reception.office)
    return gathering


def _admins(authority: PolicyService, clock: Clock) -> list[PrincipalId]:
    """Return who looks after people here: who may let them in, or gives them rights."""
    rights, roster = authority.rights, authority.roster
    now_ns = clock.wall_ns()
    return sorted(
        who
        for who in roster.everybody()
        if any(rights.holds(who, FLEET, verb, now_ns) for verb in ("people", "grant"))
    )
