"""Rules about what robots report: who is told, what is run, and what was seen."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.contracts.messenger import watch_reactions
from rosic.features.alerts.actions import ActionQueries, AlertActions
from rosic.features.alerts.active_alerts import ALARM, MUTE, RUN, TOLD
from rosic.features.alerts.commands import AlertCommands, AlertReactions
from rosic.features.alerts.evaluator import AlertEvaluator, read_rules
from rosic.features.alerts.offline_notices import OfflineNotices, StopViolations
from rosic.features.alerts.recipients import Recipients
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.core.language import VocabularyHolder
    from rosic.core.records import Fact
    from rosic.gateway.feature import Kernel
    from rosic.gateway.robot_registry import AddedRobot

__all__ = ["AlertFeature", "read_rules", "setup"]

NEEDS: Final = ("alert_tasks",)
PROVIDES: Final = ("alerts",)


class AlertFeature(Feature):
    """Follows the rules of all robots.

    Attributes:
        alerting: Looks and tells.
        reacting: Takes reactions to alarms for what they say.
        absences: Says which robots at work are not there any more.
        broken_stops: Says which stopped robots move all the same.
    """

    def __init__(
        self,
        alerting: AlertEvaluator,
        reacting: AlertReactions,
        absences: OfflineNotices,
        broken_stops: StopViolations,
        vocabularies: VocabularyHolder,
    ) -> None:
        self.alerting, self.reacting = alerting, reacting
        self.absences, self.broken_stops = absences, broken_stops
        self._vocabularies = vocabularies

    async def run(self) -> None:
        """Follow the rules until cancelled."""
        await asyncio.gather(self.alerting.run(), self.absences.run(), self.broken_stops.run())

    async def close(self) -> None:
        """Follow them no more, and write down what is open."""
        await self.reacting.close()
        await self.alerting.close()

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Follow the rules of one more robot."""
        self.alerting.add_robot(*read_rules((newcomer.profile,), self._vocabularies.current))


def setup(kernel: Kernel) -> AlertFeature:
    """Read the rules, go on with what earlier runs have raised, and take the commands."""
    rooms, orders, clock = kernel.rooms, kernel.orders, kernel.clock
    changes, reach = kernel.changes, kernel.reach
    circles = Recipients(rooms.authoriser, rooms.organiser)
    alerting = AlertEvaluator(rooms, changes, reach, clock, circles, kernel.assessment.presence)
    reach.again.bind(alerting.again)
    alerting.news.connect(kernel.shared.alarm_news.emit)
    for kind in (ALARM, MUTE, RUN):
        kernel.keep(kind, alerting.book.restore, alerting.book.apply)
    changes.keep(TOLD, _so_already)
    _follow(kernel, alerting)
    reacting = AlertReactions(alerting, rooms.authoriser.directory, reach)
    for messenger in kernel.messengers:
        watch_reactions(messenger, partial(reacting.reacted, messenger))
    absences = OfflineNotices(rooms, kernel.pipeline.executor, reach, clock)
    kernel.pipeline.executor.watching.still_moves.connect(absences.still_moves)
    kernel.shared.alerts.provide(alerting)
    AlertCommands(alerting, rooms, changes).register(kernel.commands)
    broken_stops = StopViolations(rooms, orders.reach, clock, circles)
    return AlertFeature(alerting, reacting, absences, broken_stops, rooms.vocabularies)


def _follow(kernel: Kernel, alerting: AlertEvaluator) -> None:
    rooms, named = kernel.rooms, kernel.site.named
    running = AlertActions(
        rooms,
        kernel.orders,
        kernel.changes,
        kernel.clock,
        alerting.book,
        ActionQueries(lambda name: named.get(name.casefold()), kernel.shared.alert_tasks.find()),
    )
    alerting.follow(*read_rules(rooms.profiles.values(), rooms.vocabulary), running)
    open_now = {
        following.rule.key: following.alarm
        for row in alerting.following.values()
        for following in row
        if following.alarm is not None
    }
    told = kernel.memory.facts.get(TOLD, ())
    alerting.write(alerting.telling.placed.restore(told, open_now))


def _so_already(_fact: Fact) -> None:
    """Which message tells of what is known before it is written."""
