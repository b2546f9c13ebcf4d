"""Looks at what robots report, a second at a time, and tells whom a rule means."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.alerts.rule import read_run, rules_of
from rosic.core.alerts.state import AlertEvent, AlertWatch
from rosic.core.records import Decided
from rosic.core.signal import Signal
from rosic.core.time_units import SECOND_NS
from rosic.errors import Refusal, RosicError
from rosic.features.alerts import grouped_messages
from rosic.features.alerts import messages as words
from rosic.features.alerts.active_alerts import ActiveAlert, AlertLog, AlertOccurrence, unpacked
from rosic.features.alerts.notifications import AlertNotifications
from rosic.features.alerts.recipients import AlertNews, NewsKind
from rosic.gateway.observed_state import OpenAlert
from rosic.gateway.scheduling import go_round
from rosic.gateway.transactions import WriteBehind
from rosic.organiser.calendar_messages import length

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

    from rosic.contracts.clock import Clock
    from rosic.core.alerts.rule import AlertRule
    from rosic.core.identity import PrincipalId
    from rosic.core.language import Do, Vocabulary
    from rosic.core.message import Button
    from rosic.core.records import Record
    from rosic.core.robot.profile import Presence, Profile, RobotId
    from rosic.features.alerts.actions import AlertActions
    from rosic.features.alerts.recipients import Recipients
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notification, Notifier
    from rosic.gateway.transactions import Transactions


# ---- one rule ----


class ActiveRule:
    """A rule, where it is, and the alarm it has raised.

    Attributes:
        alarm: What is open now; None: nobody was told of anything.
    """

    __slots__ = ("alarm", "rule", "watch")

    def __init__(self, rule: AlertRule) -> None:
        self.rule = rule
        self.watch = AlertWatch(rule.pace)
        self.alarm: AlertOccurrence | None = None

    def now(self, presence: Presence) -> str:
        """Return what is measured, as people read it."""
        return words.value(self.rule.condition, self.rule.condition.value(presence))

    def raised(self, alarm: AlertOccurrence, people: Iterable[PrincipalId]) -> AlertOccurrence:
        """It is open, as high as it is by now, and these are told. Return it as it is now."""
        told = tuple(dict.fromkeys((*alarm.told, *people)))
        self.alarm = replace(alarm, told=told, level=self.watch.level)
        return self.alarm

    def cleared(self) -> AlertOccurrence | None:
        """It is over. Return what was open."""
        alarm, self.alarm = self.alarm, None
        return alarm

    def seen(self, by: PrincipalId) -> AlertOccurrence | None:
        """Somebody has seen it. Return it as it is now; None: it is over, or was seen."""
        if self.alarm is None or not self.unseen or not self.watch.acknowledge():
            return None
        self.alarm = replace(self.alarm, by=by)
        return self.alarm

    def restore(self, alarm: AlertOccurrence, now_ns: int) -> None:
        """It was open already when this run began."""
        self.alarm = alarm
        self.watch.restore(now_ns, acknowledged=bool(alarm.by), level=alarm.level)

    @property
    def unseen(self) -> bool:
        """Whether it is open, and nobody has said that they saw it."""
        return self.watch.announced and self.alarm is not None and not self.alarm.by

    def called(self, named: str) -> bool:
        """Whether somebody means it: by its name, its beginning, or what it measures."""
        rule = self.rule
        return rule.alert.name.startswith(named) or rule.condition.name == named


def read_rules(
    profiles: Iterable[Profile], vocabulary: Vocabulary
) -> tuple[list[AlertRule], dict[str, Do | None]]:
    """Return the rules of robots, and what those run that run something, by the rule's key."""
    rules = [rule for profile in profiles for rule in rules_of(profile, vocabulary.units)]
    return rules, {rule.key: read_run(rule, vocabulary) for rule in rules if rule.alert.run}


# ---- evaluating all rules ----

# Robots report some times a second; a rule counts in seconds.
EVERY_S = 0.5
WRITTEN_WITHIN_S = 0.3
LISTED_AT_MOST = 12
"""More alarms than this are told by what is wrong, and not each by itself."""

log = logging.getLogger("rosic.alerts")


class AlertEvaluator:
    """Follows every rule of every robot. A robot without rules costs nothing.

    What is to be told does not wait for the disk; what a rule runs does.

    Attributes:
        book: What the record keeps.
        circles: Who is around a robot.
        following: The rules, by robot.
        telling: Says it.
        news: Tells of every alarm that begins and ends: its robot, its words, whether it begins.

    Args:
        assess: Adds to what a robot reports how it does against its benchmarks.
    """

    def __init__(
        self,
        rooms: Components,
        changes: Transactions,
        reach: Notifier,
        clock: Clock,
        circles: Recipients,
        assess: Callable[[RobotId, Presence], Presence],
    ) -> None:
        self.book = AlertLog()
        self.circles = circles
        self.following: dict[RobotId, list[ActiveRule]] = {}
        self.news: Signal[[RobotId, str, bool]] = Signal()
        self.telling = AlertNotifications(rooms, reach, clock, circles, self.write)
        self._by_key: dict[str, ActiveRule] = {}
        self._assess = assess
        self._lines: dict[str, Do | None] = {}
        self._running: AlertActions | None = None
        self._rooms = rooms
        self._clock = clock
        self._behind = WriteBehind(changes)
        self._tasks: BackgroundTasks[None] = BackgroundTasks()
        self._some = asyncio.Event()

    def follow(
        self, rules: Iterable[AlertRule], lines: Mapping[str, Do | None], running: AlertActions
    ) -> None:
        """Say which rules there are, and go on with what an earlier run has raised.

        Args:
            rules: All of them.
            lines: What those run that run something, understood, by the rule's key.
            running: Gives their orders.
        """
        self._running = running
        self.add_robot(rules, lines)
        known = self._by_key
        self.write([self.book.cleared(key) for key in self.book.alarms if key not in known])

    def add_robot(self, rules: Iterable[AlertRule], lines: Mapping[str, Do | None]) -> None:
        """Follow more rules, from the next round on; see `follow`."""
        self._lines.update(lines)
        now_ns = self._clock.monotonic_ns()
        for rule in rules:
            following = ActiveRule(rule)
            self.following.setdefault(rule.robot, []).append(following)
            self._by_key[rule.key] = following
            alarm = self.book.alarms.get(rule.key)
            if alarm is not None:
                following.restore(alarm, now_ns)
            self._some.set()

    async def run(self) -> None:
        """Look until cancelled. What fails is logged, and looked at again."""
        await go_round(self._clock, EVERY_S, self.following, self.look, self._some)

    async def close(self) -> None:
        """Write down what is open, within bounds; what is being asked of a robot is given up."""
        for task in self._tasks:
            task.cancel()
        self.telling.close()
        await self._behind.written(WRITTEN_WITHIN_S)

    def look(self, robots: Iterable[RobotId]) -> None:
        """Look once at these robots, which have rules, and tell what was gathered meanwhile."""
        self.telling.look()
        for robot in robots:
            try:
                presence = self._assess(robot, self._rooms.linker.presence(robot))
                for following in self.following[robot]:
                    self._feed(following, presence)
            except Exception:
                log.exception("the rules of %s could not be followed", robot)

    def _feed(self, following: ActiveRule, presence: Presence) -> None:
        rule, clock = following.rule, self._clock
        muted = self.book.muted(rule.key, clock.wall_ns()) is not None
        reading = rule.condition.reading(presence)
        event = following.watch.feed(reading, clock.monotonic_ns(), muted=muted)
        if event is AlertEvent.CLEARED:
            self._cleared(following, following.now(presence), muted=muted)
        elif event is not None:
            self._raised(following, following.now(presence), event)

    # ---- telling ----

    def _raised(self, following: ActiveRule, now: str, event: AlertEvent) -> None:
        rule = following.rule
        alarm = following.alarm or AlertOccurrence(self._clock.wall_ns())
        people = self.circles.of(rule.robot, rule.alert.tell, following.watch.level)
        text = self._text(rule, now, event, alarm.at_ns)
        alarmed = ActiveAlert(rule.key, alarm.at_ns)
        self.telling.tell(people, AlertNews(NewsKind.ALARM, rule, text, alarmed))
        self.news.emit(rule.robot, str(text), True)
        if not people:
            log.warning("nobody may be told of the rule %s", rule.key)
        self.write([self.book.raised(rule.key, following.raised(alarm, people))])
        if event is AlertEvent.RAISED and rule.alert.run:
            self._spawn(following)

    def _text(self, rule: AlertRule, now: str, event: AlertEvent, at_ns: int) -> str:
        shown = self.shown(rule)
        text = words.raised(rule, shown, now, again=event is AlertEvent.AGAIN)
        if event is AlertEvent.ESCALATED:
            past_s = max(0, self._clock.wall_ns() - at_ns) // SECOND_NS
            text = words.escalated(text, length(past_s))
        if event is AlertEvent.RAISED and rule.alert.run:
            text = words.with_run(text, rule.alert.run, rule.alert.author)
        return text

    def _cleared(self, following: ActiveRule, now: str, *, muted: bool) -> None:
        rule, alarm = following.rule, following.cleared()
        self.write([self.book.cleared(rule.key), *self.telling.placed.over(rule.key)])
        text = words.cleared(rule, self.shown(rule), now)
        self.news.emit(rule.robot, str(text), False)
        if alarm is not None and not muted:
            self._tell(NewsKind.OVER, rule, alarm.told, text)

    def _tell(
        self,
        sort: NewsKind,
        rule: AlertRule,
        people: Iterable[PrincipalId],
        text: str,
        by: str = "",
    ) -> None:
        self.telling.tell(people, AlertNews(sort, rule, text, by=by))

    def tell(self, rule: AlertRule, people: Iterable[PrincipalId], text: str) -> None:
        """Tell those of them who may see the robot now what came of an alarm."""
        self._tell(NewsKind.NOTE, rule, people, text)

    def buttons(self, rule: AlertRule) -> tuple[Button, ...]:
        """Return what whoever may operate the robot taps."""
        return self.telling.buttons(rule)

    def shown(self, rule: AlertRule) -> str:
        """Return how people read the robot of a rule."""
        return self.telling.shown(rule)

    def meant(self, occurrences: Iterable[ActiveAlert]) -> list[ActiveRule]:
        """Return those alarms of a message that are not over; a later one is another."""
        found = []
        for key, at_ns in occurrences:
            following = self._by_key.get(key)
            alarm = None if following is None else following.alarm
            if following is not None and alarm is not None and alarm.at_ns == at_ns:
                found.append(following)
        return found

    def again(self, who: PrincipalId, matter: bytes) -> Notification | None:
        """Return what goes under alarms that a later run says again; None if all are over."""
        try:
            told = unpacked(matter)
        except msgspec.MsgspecError:
            log.warning("of which alarms a message told cannot be read; it offers nothing")
            return None
        meant = [(following.rule, of) for of in told for following in self.meant((of,))]
        return self.telling.again(who, meant) if meant else None

    # ---- seen ----

    def seen(self, following: ActiveRule, by: PrincipalId) -> bool:
        """Somebody has seen it: all who were told hear of it. Return False if it was seen."""
        alarm = following.seen(by)
        if alarm is None:
            return False
        rule, name = following.rule, self._rooms.organiser.name_of(by)
        decided = Decided(act="alarm-seen", by=by, about=rule.key, at_ns=self._clock.wall_ns())
        self.write([decided, self.book.raised(rule.key, alarm)])
        others = [who for who in alarm.told if who != by]
        self._tell(NewsKind.SEEN, rule, others, words.seen_by(rule, self.shown(rule), name), name)
        return True

    def noted(self, fresh: Sequence[ActiveRule]) -> str:
        """Return what somebody reads who has seen these; at least one."""
        rules = [following.rule for following in fresh]
        if len(rules) > LISTED_AT_MOST:
            return grouped_messages.you_saw(rules, self.shown)
        return words.you_saw([words.one(rule, self.shown(rule), "", "") for rule in rules])

    def open_now(self, robots: Collection[RobotId]) -> tuple[OpenAlert, ...]:
        """Return the open alarms of some robots, the newest first."""
        found = []
        for robot in robots:
            for following in self.following.get(robot, ()):
                if (alarm := following.alarm) is not None:
                    now = following.now(self._assess(robot, self._rooms.linker.presence(robot)))
                    name, said = following.rule.alert.name, words.what(following.rule)
                    found.append(OpenAlert(robot, name, said, alarm.at_ns, now, alarm.by))
        return tuple(sorted(found, key=lambda alert: -alert.at_ns))

    def seen_before(self, following: ActiveRule) -> str:
        """Return that somebody else was faster, who has seen it."""
        rule, alarm = following.rule, following.alarm
        name = self._rooms.organiser.name_of(alarm.by if alarm is not None else "")
        return words.seen_before(words.one(rule, self.shown(rule), "", ""), name)

    # ---- writing and running ----

    def write(self, records: Iterable[Record]) -> None:
        """Write down what is so already; in order, one batch after another."""
        self._behind.write(records)

    def _spawn(self, following: ActiveRule) -> None:
        self._tasks.begin(self._run_for(following))

    async def _run_for(self, following: ActiveRule) -> None:
        """Let the robot do what the rule says, and tell whoever heard of it if it cannot."""
        rule, alarm = following.rule, following.alarm
        if self._running is None or alarm is None:
            return
        try:
            await self._running.run(rule, self._lines[rule.key], alarm.at_ns)
        except Refusal as refusal:
            self.tell(rule, alarm.told, words.not_run(rule, self.shown(rule), refusal.sentence))
        except (RosicError, Exception):
            log.exception("the rule %s could not be run", rule.key)
            self.tell(rule, alarm.told, words.not_run(rule, self.shown(rule), words.fault()))
        else:
            if self._lines[rule.key] is None:
                self.tell(rule, alarm.told, words.acted(rule, self.shown(rule)))
