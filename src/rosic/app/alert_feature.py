"""Puts the rules about alarms in their place: read once, with who stands for each."""

from __future__ import annotations

import asyncio
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, cast

from rosic.app.people import ConfiguredPerson, named_in_file
from rosic.contracts.file_rules import ValidationFinding
from rosic.contracts.messenger import watch_reactions
from rosic.core.alerts.rule import read_run, rules_of
from rosic.features.alerts.actions import AlertActions
from rosic.features.alerts.active_alerts import ALARM, MUTE, RUN, TOLD
from rosic.features.alerts.commands import AlertCommands, AlertReactions
from rosic.features.alerts.evaluator import AlertEvaluator
from rosic.features.alerts.offline_notices import OfflineNotices
from rosic.features.alerts.recipients import Recipients
from rosic.features.alerts.stop_violations import StopViolations
from rosic.features.media.commands import register_commands, view_buttons
from rosic.features.media.context import MediaContext, MediaQueries
from rosic.features.media.render_queue import RenderQueue
from rosic.features.media.telemetry_buffer import TelemetrySampler

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from rosic.app.access import AccessFeature
    from rosic.config.gateway_file import ConfigFile
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.renderer import Renderer
    from rosic.core.alerts.rule import AlertRule
    from rosic.core.identity import PrincipalId
    from rosic.core.language import Do, Vocabulary
    from rosic.core.records import Fact, Memory
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.core.robot.view import Drawing, Scene, Subject
    from rosic.gateway import Pipeline
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.sender import ChatSender
    from rosic.gateway.feature import RobotAssessment
    from rosic.gateway.order_services import OrderServices
    from rosic.gateway.robot_registry import AddedRobot


# ---- alert rules ----


class AlertFeature:
    """What follows the rules of one gateway.

    Attributes:
        alerting: Looks and tells.
        reacting: Takes reactions to alarms for what they say.
        running: Gives the orders of rules.
        absences: Says which robots at work are not there any more.
        broken_stops: Says which stopped robots move all the same.
    """

    def __init__(
        self,
        rooms: Components,
        access: AccessFeature,
        clock: Clock,
        hands: OrderServices,
        assessment: RobotAssessment,
    ) -> None:
        self._rooms = rooms
        self._access = access
        circles = Recipients(rooms.authoriser, rooms.organiser)
        self.alerting = AlertEvaluator(
            rooms, access.changes, hands.reach, clock, circles, assessment.presence
        )
        hands.reach.again.bind(self.alerting.again)
        self.reacting = AlertReactions(self.alerting, rooms.authoriser.directory, hands.reach)
        self.absences = OfflineNotices(rooms, hands.reach, clock)
        self.broken_stops = StopViolations(rooms, hands.reach, clock, circles)
        self._hands, self._clock = hands, clock

    def set_up(
        self, pipeline: Pipeline, memory: Memory, people: Iterable[ConfiguredPerson]
    ) -> None:
        """Read the rules, take over what earlier runs have raised, and take the commands."""
        rooms, changes, book = self._rooms, self._access.changes, self.alerting.book
        for kind in (ALARM, MUTE, RUN):
            book.restore(memory.facts.get(kind, ()))
            changes.keep(kind, book.apply)
        changes.keep(TOLD, _so_already)
        rules, lines = read_rules(rooms.profiles.values(), rooms.vocabulary)
        named = named_in_file(people, memory, rooms.authoriser)
        self.running = AlertActions(
            rooms, self._hands, changes, self._clock, book, lambda name: named.get(name.casefold())
        )
        self.alerting.follow(rules, lines, self.running)
        open_now = {
            following.rule.key: following.alarm
            for row in self.alerting.following.values()
            for following in row
            if following.alarm is not None
        }
        told = memory.facts.get(TOLD, ())
        self.alerting.write(self.alerting.telling.placed.restore(told, open_now))
        pipeline.executor.watch_orders(self.absences)
        AlertCommands(self.alerting, rooms, changes).register(pipeline.hooks.commands)

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Follow the rules of one more robot."""
        self.alerting.add_robot(*read_rules((newcomer.profile,), self._rooms.vocabulary))

    async def run(self) -> None:
        """Follow the rules until cancelled."""
        await asyncio.gather(self.alerting.run(), self.absences.run(), self.broken_stops.run())

    def watch(self, messengers: Iterable[Messenger]) -> None:
        """Hear of reactions, where people react."""
        for messenger in messengers:
            watch_reactions(messenger, partial(self.reacting.reacted, messenger))

    async def close(self) -> None:
        """Follow them no more, and write down what is open."""
        await self.reacting.close()
        await self.alerting.close()


def _so_already(_fact: Fact) -> None:
    """Which message tells of what is known before it is written."""


def read_rules(
    profiles: Iterable[Profile], vocabulary: Vocabulary
) -> tuple[list[AlertRule], dict[str, Do | None]]:
    """Return the rules of robots, and what those run that run something, by the rule's key."""
    rules = [rule for profile in profiles for rule in rules_of(profile, vocabulary.units)]
    return rules, {rule.key: read_run(rule, vocabulary) for rule in rules if rule.alert.run}


def author_findings(file: ConfigFile, robots: Iterable[Profile]) -> Iterator[ValidationFinding]:
    """Find rules that run something as somebody whom the configuration does not name."""
    known = {person.name.casefold() for person in file.principal}
    for index, profile in enumerate(robots):
        for alert in profile.alerts:
            if alert.author and alert.author.casefold() not in known:
                yield ValidationFinding(
                    ("robot", index, "profile"),
                    f"The rule {alert.name!r} of {profile.id} runs as {alert.author}, and nobody "
                    "here is called so.",
                    "Give 'as' the name of a [[principal]].",
                )


# ---- pictures ----


def renderer() -> Renderer | None:
    """Return who draws; None where Pillow is not installed.

    Nothing of it is loaded before the first picture is drawn.
    """
    return None if find_spec("PIL") is None else _draw


def _draw(subject: Subject, *, low: bool = False, say: Callable[[str], str] = str) -> Drawing:
    draw = cast("Renderer", import_module("rosic.rendering.draw").draw)
    return draw(subject, low=low, say=say)


def jpeg_drawer() -> Callable[[Scene], bytes] | None:
    """Return what draws the frames of simulated cameras; None where Pillow is not installed."""
    return None if renderer() is None else lambda scene: _draw(scene, low=True).content


def set_up_media(
    rooms: Components,
    pipeline: Pipeline,
    chat_sender: ChatSender,
    draws: Renderer | None,
    clock: Clock,
) -> MediaContext:
    """Let people look at robots that they may read."""
    organiser, profiles = rooms.organiser, rooms.profiles

    def may_see(principal: PrincipalId, robot: RobotId) -> bool:
        return principal not in organiser.locked and robot in organiser.visible(principal)

    render_queue = RenderQueue(
        draws,
        chat_sender,
        clock,
        may_see=may_see,
        issue=rooms.authoriser.buttons.issue,
        shown=lambda robot: profiles[robot].shown,
    )
    media_feature = MediaContext(
        vocabularies=rooms.vocabularies,
        profiles=profiles,
        sides=MediaQueries(visible=organiser.visible, selected=rooms.container.selected),
        linker=rooms.linker,
        render_queue=render_queue,
        sampler=TelemetrySampler(rooms.linker, clock),
        clock=clock,
    )
    register_commands(pipeline.hooks.commands, media_feature)
    pipeline.hooks.view_buttons.bind(partial(view_buttons, media_feature))
    for profile in profiles.values():
        add_seen(media_feature, pipeline, profile)
    return media_feature


def robot_seen(media_feature: MediaContext, pipeline: Pipeline, newcomer: AddedRobot) -> None:
    """Let one more robot be looked at."""
    add_seen(media_feature, pipeline, newcomer.profile)


def add_seen(media_feature: MediaContext, pipeline: Pipeline, profile: Profile) -> None:
    """Sample what a robot reports, and follow where it goes if it says so."""
    media_feature.sampler.add_robot(profile)
    if profile.pose is not None:
        pipeline.executor.watch_orders(media_feature.sampler)
