"""Puts together what goes beyond single messages: groups, their topics, menus of commands."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rosic.app.languages import LANGUAGES, catalogue
from rosic.contracts.messenger import menus_of, watch_chats
from rosic.core.reach import FLEET
from rosic.pipeline.groups import KIND as DEAF
from rosic.pipeline.groups import Groups, Surroundings
from rosic.pipeline.menus import Menus
from rosic.pipeline.topics import KIND as TOPIC
from rosic.pipeline.topics import Topics
from rosic.pipeline.windows import Windows

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.app.gateway import Gateway
    from rosic.app.placing.authority import Authority
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Passing
    from rosic.core.record import Memory
    from rosic.pipeline import Pipeline
    from rosic.pipeline.telling import Teller


class Gathering:
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
        authority: Authority,
        around: Surroundings,
    ) -> None:
        rooms, changes = around.rooms, around.changes
        self.groups = Groups(around)
        vocabulary, profiles = rooms.vocabulary, rooms.profiles
        self.topics = Topics(
            rooms.organiser,
            changes,
            lambda name: (name,) if name in profiles else vocabulary.members(name),
        )
        rooms.container.here = self.topics.of
        pipeline.reception.office.employ("topic", self.topics.topic)
        directory = rooms.authoriser.directory
        others = {code: found for code in LANGUAGES if (found := catalogue(code)) is not None}
        admins = partial(_admins, authority, around.clock)
        self.windows: Windows | None = None
        self.menus = Menus(directory, admins, others, around.teller.languages.chosen, around.clock)
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


def gathering_of(gateway: Gateway, teller: Teller, clock: Clock, place: str) -> Gathering:
    """Make it for a gateway whose rooms are furnished."""
    furnishing, pipeline = gateway.furnishing, gateway.pipeline
    around = Surroundings(
        rooms=gateway.rooms, audience=pipeline.audience, teller=teller, reach=furnishing.reach,
        changes=gateway.access.changes, archive=gateway.holding.archive, clock=clock, place=place,
        admins=furnishing.admins, cards=furnishing.live_cards,
    )  # fmt: skip
    gathering = Gathering(pipeline, gateway.authority, around)
    gathering.windows = Windows(
        furnishing.live_cards, gateway.rooms, gateway.access.changes, furnishing.reach
    )
    gathering.windows.employ(pipeline.reception.office)
    return gathering


def _admins(authority: Authority, clock: Clock) -> list[PrincipalId]:
    """Return who looks after people here: who may let them in, or gives them rights."""
    rights, roster = authority.rights, authority.roster
    now_ns = clock.wall_ns()
    return sorted(
        who
        for who in roster.everybody()
        if any(rights.holds(who, FLEET, verb, now_ns) for verb in ("people", "grant"))
    )
