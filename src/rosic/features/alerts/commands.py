"""``/alerts``, ``/seen``, ``/mute`` and ``/unmute``: what people say about alarms."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.contracts.messenger import reactions_of
from rosic.core.i18n import joined, said
from rosic.core.language import clean
from rosic.core.language.command import Command, HelpEntry, HelpPage
from rosic.core.language.time_tokens import length_said
from rosic.core.message import Button
from rosic.core.messages import by_whom, no_robot
from rosic.core.records import Decided
from rosic.core.time_units import DAY_S, HOUR_S
from rosic.errors import MessengerFault, NotPermitted, NotUnderstood, OutOfBounds
from rosic.features.alerts import grouped_messages
from rosic.features.alerts import messages as words
from rosic.features.alerts.active_alerts import Silence
from rosic.features.alerts.evaluator import LISTED_AT_MOST
from rosic.features.alerts.notifications import MANY
from rosic.gateway.commands import Reply, check_length

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Iterator, Sequence

    from rosic.authoriser.directory import Directory
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Reaction
    from rosic.core.robot.profile import RobotId
    from rosic.features.alerts.evaluator import ActiveRule, AlertEvaluator
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.transactions import Transactions

COMMANDS: Final = (
    Command(
        name="alerts",
        observes=True,
        aliases=("alarme",),
        typed=said("/alerts"),
        summary=said("What is wrong now, and what was"),
        help=HelpEntry(HelpPage.ALARMS, 10),
    ),
    Command(
        name="seen",
        summary="that one has seen an alarm",
    ),
    Command(
        name="mute",
        aliases=("stumm",),
        typed=said("/mute"),
        summary=said("Hear nothing of an alarm for a while"),
        explained=True,
        help=HelpEntry(HelpPage.ALARMS, 20),
    ),
    Command(
        name="unmute",
        summary="hear of an alarm again",
    ),
)


# ---- ``/alerts``, ``/seen``, ``/mute`` and ``/unmute`` ----

USUAL_S = float(HOUR_S)
SHORTEST_S = 60.0
LONGEST_S = 30.0 * DAY_S
ALL = "all"
LONGEST_LINE = 200


class AlertTarget(NamedTuple):
    """What somebody speaks of: a robot, those of its rules, and a length of time if one is said."""

    robot: RobotId
    rules: list[ActiveRule]
    seconds: float | None


class AlertCommands:
    """Answers about alarms; reads only what its asker may see."""

    def __init__(self, alerting: AlertEvaluator, rooms: Components, changes: Transactions) -> None:
        self._alerting = alerting
        self._rooms = rooms
        self._changes = changes

    def register(self, commands: CommandRegistry) -> None:
        """Take the commands."""
        commands.register("alerts", self.list)
        commands.register("seen", self.seen)
        commands.register("mute", self.mute)
        commands.register("unmute", self.unmute)

    async def list(self, asked: CommandContext) -> Reply:
        """Show what is open and what is muted, on every robot one may see, or on one.

        Raises:
            NotUnderstood: No such robot.
        """
        who = asked.caller.principal
        every = asked.rest.strip().casefold() == ALL and ALL not in self._visible(who)
        named = asked.rest.strip() and not every
        rules = self._target(who, asked.rest).rules if named else list(self._all(who))
        opened = [following for following in rules if following.watch.announced]
        muted = list(self._muted(who, rules))
        if len(opened) > LISTED_AT_MOST:
            return self._many(who, opened, muted, every=every)
        lines = [self._line(following) for following in opened]
        rows = tuple(
            self._alerting.buttons(following.rule)
            for following in opened
            if following.unseen and self._answers(who, following.rule.robot)
        )
        return (
            Reply(joined("\n", lines + muted), rows) if lines + muted else Reply(words.none_open())
        )

    def _many(
        self, who: PrincipalId, opened: Sequence[ActiveRule], muted: Sequence[str], *, every: bool
    ) -> Reply:
        """Return many alarms by what is wrong, the worst first; each robot named if all is asked.

        What is muted is said where all is asked.
        """
        rules, shown = [following.rule for following in opened], self._alerting.shown
        if every:
            lines = grouped_messages.lines(rules, shown, named=len(rules), most=len(rules))
            return Reply(joined("\n", [*lines, *muted]))
        unseen = any(f.unseen and self._answers(who, f.rule.robot) for f in opened)
        see = (Button(grouped_messages.SEEN_ALL, "/seen"),) if unseen else ()
        row = (*see, Button(grouped_messages.SHOW_ALL, f"/alerts {ALL}"))
        return Reply(grouped_messages.alarms(rules, shown), (row,))

    def _muted(self, who: PrincipalId, rules: Iterable[ActiveRule]) -> Iterator[str]:
        now_ns = self._rooms.organiser.wall_ns()
        for following in rules:
            mute = self._alerting.book.muted(following.rule.key, now_ns)
            if mute is not None:
                yield self._muted_line(following, mute, who)

    def _line(self, following: ActiveRule) -> str:
        rule, alarm = following.rule, following.alarm
        presence = self._rooms.linker.presence(rule.robot)
        by = self._name(alarm.by) if alarm is not None and alarm.by else ""
        return words.one(rule, self._alerting.shown(rule), following.now(presence), by)

    def _muted_line(self, following: ActiveRule, mute: Silence, who: PrincipalId) -> str:
        rule = following.rule
        until = self._rooms.organiser.moment(who, mute.until_ns)
        return words.muted_line(
            rule, self._alerting.shown(rule), by_whom(mute.by, who, self._name), until
        )

    async def seen(self, asked: CommandContext) -> Reply:
        """Say that one has seen alarms: all that are open, a robot's, or one.

        Raises:
            NotUnderstood: No such robot or rule, or nothing is open.
            NotPermitted: Not theirs to answer.
        """
        who, rest = asked.caller.principal, asked.rest.strip()
        if rest.startswith(MANY) and rest not in self._visible(who):
            meant = self._of_list(who, rest)
        elif rest:
            target = self._target(who, asked.rest)
            self._check(who, target.robot)
            meant = target.rules
        else:
            meant = [f for f in self._all(who) if self._answers(who, f.rule.robot)]
        fresh = [following for following in meant if self._alerting.seen(following, who)]
        if fresh:
            return Reply(self._alerting.noted(fresh))
        before = [f for f in meant if f.alarm is not None and f.alarm.by]
        if not before:
            raise NotUnderstood(words.nothing_to_see())
        return Reply(self._alerting.seen_before(before[0]))

    async def mute(self, asked: CommandContext) -> Reply:
        """Let rules of a robot be silent for a while.

        Raises:
            NotUnderstood, OutOfBounds: No such robot, rule or length of time.
            NotPermitted: Not theirs to answer.
        """
        who = asked.caller.principal
        if not asked.rest.strip():
            raise NotUnderstood(words.how_to_mute())
        target = self._target(who, asked.rest)
        self._check(who, target.robot)
        lasts_s = USUAL_S if target.seconds is None else target.seconds
        if not SHORTEST_S <= lasts_s <= LONGEST_S:
            raise OutOfBounds(words.too_long(int(LONGEST_S)))
        now_ns = self._rooms.organiser.wall_ns()
        mute = Silence(who, now_ns + int(lasts_s * 1e9))
        book = self._alerting.book
        async with self._changes.turn() as turn:
            for following in target.rules:
                key = following.rule.key
                decided = Decided(act="alarm-mute", by=who, about=key, at_ns=now_ns)
                await turn.act((decided, book.mute(key, mute)))
                following.watch.hush()
        self._tell_others(target, who, mute)
        shown = self._rooms.profiles[target.robot].shown
        until = self._rooms.organiser.moment(who, mute.until_ns)
        return Reply(words.muted(shown, [f.rule for f in target.rules], until))

    def _tell_others(self, target: AlertTarget, who: PrincipalId, mute: Silence) -> None:
        """Tell whoever was told of what is open that it falls silent."""
        shown, name = self._rooms.profiles[target.robot].shown, self._name(who)
        for following in target.rules:
            alarm = following.alarm
            for other in alarm.told if alarm is not None else ():
                if other != who:
                    until = self._rooms.organiser.moment(other, mute.until_ns)
                    text = words.was_muted(shown, [following.rule], name, until)
                    self._alerting.tell(following.rule, (other,), text)

    async def unmute(self, asked: CommandContext) -> Reply:
        """Let rules of a robot tell again.

        Raises:
            NotUnderstood: No such robot or rule.
            NotPermitted: Not theirs to answer.
        """
        who = asked.caller.principal
        target = self._target(who, asked.rest)
        self._check(who, target.robot)
        now_ns, book = self._rooms.organiser.wall_ns(), self._alerting.book
        async with self._changes.turn() as turn:
            for following in target.rules:
                key = following.rule.key
                decided = Decided(act="alarm-unmute", by=who, about=key, at_ns=now_ns)
                await turn.write((decided, book.unmute(key)))
        shown = self._rooms.profiles[target.robot].shown
        return Reply(words.unmuted(shown, [f.rule for f in target.rules]))

    # ---- what is meant ----

    def _target(self, who: PrincipalId, typed: str) -> AlertTarget:
        line = clean(typed)
        check_length(line, LONGEST_LINE)
        first, *rest = line.casefold().split() or [""]
        if first not in self._rooms.organiser.visible(who):
            raise NotUnderstood(no_robot(first or "?"))
        rules = self._alerting.following.get(first, [])
        if not rules:
            raise NotUnderstood(words.no_rules(self._rooms.profiles[first].shown))
        named, seconds = _tail(rest)
        exact = [f for f in rules if f.rule.alert.name == named]
        meant = exact or [f for f in rules if f.called(named)] if named else rules
        if not meant:
            raise NotUnderstood(words.no_such_rule(named, [f.rule.alert.name for f in rules]))
        return AlertTarget(first, meant, seconds)

    def _all(self, who: PrincipalId) -> Iterator[ActiveRule]:
        for robot in sorted(self._rooms.organiser.visible(who)):
            yield from self._alerting.following.get(robot, ())

    def _answers(self, who: PrincipalId, robot: RobotId) -> bool:
        return self._alerting.circles.may_acknowledge(who, robot)

    def _check(self, who: PrincipalId, robot: RobotId) -> None:
        if not self._answers(who, robot):
            raise NotPermitted(words.may_not(self._rooms.profiles[robot].shown))

    def _of_list(self, who: PrincipalId, key: str) -> Sequence[ActiveRule]:
        """Return which alarms of a message of many are theirs to answer."""
        told = self._alerting.telling.list_of(key)
        if not told:
            raise NotUnderstood(grouped_messages.forgotten())
        seen = self._visible(who)
        return [
            following
            for following in self._alerting.meant(told)
            if following.rule.robot in seen and self._answers(who, following.rule.robot)
        ]

    def _visible(self, who: PrincipalId) -> Container[RobotId]:
        return self._rooms.organiser.visible(who)

    def _name(self, who: PrincipalId) -> str:
        return self._rooms.organiser.name_of(who)


def _tail(typed: list[str]) -> tuple[str, float | None]:
    """Split a rule's name from how long: ``battery low for 1 h``."""
    for at in range(len(typed)):
        seconds, used = length_said(typed[at:])
        if used and used == len(typed) - at:
            named = typed[: at - 1] if at and typed[at - 1] == "for" else typed[:at]
            return "_".join(named), seconds
    return "_".join(typed), None


# ---- reactions to alarms ----

SEEN: Final = frozenset({"👍", "👌", "👀", "🫡", "🆒"})
"""Any other says something else, or nothing: a thumb down is no acknowledgement."""
NOTED: Final = "👌"
_COLOURED: Final = "\ufe0f"

log = logging.getLogger("rosic.alerts")


class AlertReactions:
    """Follows reactions. They are asked of nobody, so what means nothing is met with silence."""

    def __init__(self, alerting: AlertEvaluator, directory: Directory, reach: Notifier) -> None:
        self._alerting = alerting
        self._directory = directory
        self._reach = reach
        self._tasks: BackgroundTasks[None] = BackgroundTasks()

    def reacted(self, messenger: Messenger, reaction: Reaction) -> None:
        """Take an emoji beside an alarm that is open for what it says. Returns at once."""
        if SEEN.isdisjoint(emoji.replace(_COLOURED, "") for emoji in reaction.emoji):
            return
        found = self._directory.at(reaction.who) if reaction.who is not None else None
        placed, circles = self._alerting.telling.placed, self._alerting.circles
        told = placed.of(messenger, reaction.chat, reaction.message)
        if found is None or not told:
            return
        who = found[0].id
        meant = [f for f in self._alerting.meant(told) if circles.may_hear(who, f.rule.robot)]
        if not meant:
            return
        # Answered once, whatever else is put there: nobody is to be talked at for their thumbs.
        self._alerting.write(placed.answered(messenger, reaction.chat, reaction.message))
        theirs = [f for f in meant if circles.may_acknowledge(who, f.rule.robot)]
        fresh = [f for f in theirs if self._alerting.seen(f, who)]
        if not theirs:
            self._reach.tell((who,), words.may_not(self._alerting.shown(meant[0].rule)))
        elif fresh:
            self._confirm(messenger, reaction, who, fresh)
        else:
            self._reach.tell((who,), self._alerting.seen_before(theirs[0]))

    def _confirm(
        self, messenger: Messenger, reaction: Reaction, who: PrincipalId, fresh: list[ActiveRule]
    ) -> None:
        text = self._alerting.noted(fresh)
        self._tasks.begin(self._nod(messenger, reaction, who, text))

    async def _nod(
        self, messenger: Messenger, reaction: Reaction, who: PrincipalId, otherwise: str
    ) -> None:
        """Answer with a sign as quick as theirs; in words where that cannot be."""
        react = reactions_of(messenger)
        try:
            if react is not None:
                await react(reaction.chat, reaction.message, NOTED)
                return
        except MessengerFault as fault:
            log.info("said in words, as a reaction was not taken: %s", fault)
        self._reach.tell((who,), otherwise)

    async def close(self) -> None:
        """Follow nothing any more."""
        for task in self._tasks:
            task.cancel()
