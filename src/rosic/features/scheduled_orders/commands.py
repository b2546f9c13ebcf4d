"""``/at``, ``/in``, ``/every``: plan orders. ``/planned``, ``/unplan``: see and take them back."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from typing import TYPE_CHECKING, Final, NamedTuple

from msgspec.structs import replace

from rosic.contracts.clock import passed_ns, reading
from rosic.core.i18n import in_language, joined, plain, said
from rosic.core.identity import DIGEST_BYTES, REQUEST_ID_BYTES
from rosic.core.language import clean
from rosic.core.language.command import Command, HelpEntry, HelpNeed, HelpPage
from rosic.core.policy.scope import FLEET
from rosic.core.records import Decided
from rosic.core.time_units import MINUTE_NS
from rosic.errors import Expired, NotPermitted, NotUnderstood, OutOfBounds, TooManyRequests
from rosic.features.scheduled_orders import messages as words
from rosic.features.scheduled_orders.schedule import (
    IN_ALL_AT_MOST,
    OF_ONE_AT_MOST,
    ScheduledOrder,
    ScheduledText,
    fact_of,
)
from rosic.gateway.commands import Reply, asks_first
from rosic.gateway.replies import LEAVE

if TYPE_CHECKING:
    from collections.abc import Collection

    from rosic.contracts.clock import Clock, ClockReading, Entropy
    from rosic.core.identity import PrincipalId
    from rosic.core.language import Do
    from rosic.core.message import Button
    from rosic.core.robot.profile import RobotId
    from rosic.features.scheduled_orders.order_plan import OrderPlan, OrderPlanReader
    from rosic.features.scheduled_orders.runs import ScheduledRuns
    from rosic.features.scheduled_orders.schedule import OrderSchedule, ScheduledTime
    from rosic.gateway.agreement import Agreements
    from rosic.gateway.commands import CommandContext, CommandHandler, CommandRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.transactions import Transactions

ASSIGN: Final = "assign"
ASKED_FOR_NS: Final = 5 * MINUTE_NS
ASKED_AT_MOST: Final = 500
BUTTONS_AT_MOST: Final = 8

COMMANDS: Final = (
    Command(
        name="schedule",
        aliases=("um", "at"),
        typed=said("/at"),
        summary=said("Let a robot do something at a time"),
        explained=True,
        cancelled_by="planned",
        help=HelpEntry(HelpPage.MOVE, 90, HelpNeed.MOTION),
        timed=True,
    ),
    Command(
        name="in",
        summary="let a robot do something after a while",
        explained=True,
        cancelled_by="planned",
        page=HelpPage.MOVE,
    ),
    Command(
        name="every",
        aliases=("jeden", "jede"),
        summary="let a robot do something again and again",
        explained=True,
        cancelled_by="planned",
        page=HelpPage.MOVE,
    ),
    Command(
        name="planned",
        aliases=("geplant",),
        typed=said("/planned"),
        summary=said("What you have planned, and take it back"),
        verbs={"abbrechen": "cancel", "absagen": "cancel", "weiter": "go"},
        cancelled_by="planned",
        help=HelpEntry(HelpPage.MOVE, 91, HelpNeed.MOTION),
    ),
    Command(name="unplan", summary="take back what you have planned", page=HelpPage.MOVE),
)


class PendingPlan(NamedTuple):
    """A plan that was shown to somebody, and does not stand yet."""

    who: PrincipalId
    plan: OrderPlan
    text: ScheduledText
    asked: ClockReading


class PlanningParts(NamedTuple):
    """What planning works with."""

    schedule: OrderSchedule
    runs: ScheduledRuns
    reader: OrderPlanReader
    agreements: Agreements


class ScheduledOrderCommands:
    """The handler of orders that wait for their time."""

    def __init__(
        self,
        rooms: Components,
        changes: Transactions,
        parts: PlanningParts,
        reach: Notifier,
        clock: Clock,
        entropy: Entropy,
    ) -> None:
        self._rooms = rooms
        self._changes = changes
        self._schedule, self._runs, self._reader, self._agreements = parts
        self._reach = reach
        self._clock = clock
        self._entropy = entropy
        self._proposed: OrderedDict[str, PendingPlan] = OrderedDict()

    def register(self, commands: CommandRegistry) -> None:
        """Take these commands."""
        for verb in ("schedule", "in", "every"):
            commands.register(verb, self._planner(verb))
        commands.register("planned", self.planned)
        commands.register("unplan", self._unplan)

    # ---- planning ----

    def _planner(self, verb: str) -> CommandHandler:
        async def propose(asked: CommandContext) -> Reply:
            return await self._propose(verb, asked)

        return propose

    async def _propose(self, verb: str, asked: CommandContext) -> Reply:
        """Show a plan; it stands only once its button is tapped.

        Raises:
            Refusal: Nothing of the kind can be planned; in a group only if it was meant for us.
        """
        if not asked.rest.strip():
            return Reply(joined("\n", (words.HOW_TO, *self._lines(asked.caller.principal))))
        try:
            plan = await self._reader.read(verb, asked)
        except (NotUnderstood, OutOfBounds):
            if not self._reader.meant(verb, asked):
                return Reply("")
            raise
        who = asked.caller.principal
        self._check_room(who)
        key = self._entropy.token(REQUEST_ID_BYTES).hex()
        steps = tuple(map(_named, plan.lines))
        typed = f"{verb} {clean(asked.rest)}"
        text = ScheduledText(asked.messenger.name, asked.inbound.chat, steps, typed)
        self._proposed[key] = PendingPlan(who, plan, text, reading(self._clock))
        if len(self._proposed) > ASKED_AT_MOST:
            self._proposed.popitem(last=False)
        shown = [act.shown for act in plan.acts]
        now_ns = self._rooms.organiser.wall_ns()
        question = words.plan(self._when(who, plan.when, now_ns), plan.when.zone, shown, plan.note)
        return asks_first(question, words.plan_buttons(key, LEAVE))

    def _check_room(self, who: PrincipalId) -> None:
        """See that somebody may plan one more.

        Raises:
            TooManyRequests: They have planned as many as one may, or everybody together.
        """
        if len(self._schedule.of(who)) >= OF_ONE_AT_MOST:
            raise TooManyRequests(words.too_many(OF_ONE_AT_MOST), retry_after_s=60.0)
        if len(self._schedule.orders) >= IN_ALL_AT_MOST:
            raise TooManyRequests(words.full(IN_ALL_AT_MOST), retry_after_s=60.0)

    async def _keep(self, asked: CommandContext, key: str) -> Reply:
        """Let a plan stand, as it was shown.

        Raises:
            NotPermitted: It was typed, and not tapped.
            Expired: It was settled, is somebody else's, or would be something else by now.
            OutOfBounds: Its time is over.
            TooManyRequests: They have planned as much as one may.
        """
        who = asked.caller.principal
        if asked.inbound.nonce is None:
            raise NotPermitted(words.ONLY_BY_TAP)
        proposed = self._proposed.get(key)
        if proposed is None or proposed.who != who:
            raise Expired(words.SETTLED)
        del self._proposed[key]  # single use, whatever comes of it
        if passed_ns(self._clock, proposed.asked) > ASKED_FOR_NS:
            raise Expired(words.SETTLED)
        plan = proposed.plan
        await self._check_current(asked, plan)
        now_ns = self._rooms.organiser.wall_ns()
        if plan.when.after(now_ns) is None:
            raise OutOfBounds(words.OVER)
        order = self._order(who, plan, now_ns)
        decided = Decided(act="schedule", by=who, about=key, at_ns=now_ns, digest=asked.cid)
        async with self._changes.turn() as turn:
            self._check_room(who)
            number = self._schedule.next_key()
            fact = fact_of(number, order, proposed.text)
            await turn.write((replace(decided, about=number), fact))
        self._schedule.look()
        text = words.planned(number, self._when(who, plan.when, now_ns))
        return Reply(text, (words.cancel_button(number),))

    async def _check_current(self, asked: CommandContext, plan: OrderPlan) -> None:
        """See that every step is what was shown, under the same rules (I16).

        Raises:
            Expired: One is not.
        """
        rooms = self._rooms
        policy, vocabulary = rooms.organiser.rights.policy, rooms.vocabulary
        for act, line in zip(plan.acts, plan.lines, strict=True):
            await asyncio.sleep(0)  # each may be for many robots: a stop does not wait for twenty
            if not self._agreements.is_current(act, line, asked.caller):
                raise Expired(words.CHANGED)
        if rooms.organiser.rights.policy != policy or rooms.vocabulary is not vocabulary:
            raise Expired(words.CHANGED)

    def _order(self, who: PrincipalId, plan: OrderPlan, now_ns: int) -> ScheduledOrder:
        robots = {part.robot for act in plan.acts for part in act.parts}
        return ScheduledOrder(
            author=who,
            when=plan.when,
            after_ns=now_ns,
            given_ns=now_ns,
            lives_ns=min(skill.order_lifetime_ns for skill in plan.lines[0].skills),
            digests=tuple(act.digest[:DIGEST_BYTES] for act in plan.acts),
            generations=self._generations(robots),
        )

    def _generations(self, robots: Collection[RobotId]) -> dict[RobotId, int]:
        stops = self._rooms.stops
        return {robot: stops[robot].generation for robot in sorted(robots) if robot in stops}

    def _when(self, who: PrincipalId, when: ScheduledTime, after_ns: int) -> str:
        at_ns = when.after(after_ns)
        moment = self._rooms.organiser.moment(who, at_ns or after_ns)
        return moment if when.first is None else words.again(when, moment)

    async def withdraw(self, who: PrincipalId, robots: Collection[RobotId]) -> str:
        """Let nothing begin any more that somebody has under way or was asked about.

        What waits for its time goes on waiting: that is taken back by its number.
        """
        self._runs.cancel(who, robots)
        for key in [key for key, one in self._proposed.items() if one.who == who]:
            del self._proposed[key]
        return ""

    # ---- what is planned ----

    async def planned(self, asked: CommandContext) -> Reply:
        """List what somebody has planned, or do something with one.

        Raises:
            NotUnderstood: Nothing of theirs is called so.
            NotPermitted: It is somebody else's.
        """
        verb, _, rest = asked.rest.strip().partition(" ")
        verb = self._rooms.vocabulary.commands.verb("planned", verb.casefold())
        if verb == "keep" and rest:
            return await self._keep(asked, rest.strip())
        if verb == "cancel":
            return await self._cancel(asked, rest.strip())
        if verb == "go" and rest:
            return await self._go(asked, rest.strip())
        return self._list(asked.caller.principal)

    def _list(self, who: PrincipalId, keys: tuple[str, ...] = (), head: str = "") -> Reply:
        keys = keys or self._schedule.of(who)
        if not keys:
            return Reply(words.NONE)
        lines = [head, *(self._line(who, key) for key in keys)]
        rows = tuple(words.cancel_button(key, numbered=True) for key in keys[:BUTTONS_AT_MOST])
        resting = [key for key in keys if self._rests(key)][:BUTTONS_AT_MOST]
        going: tuple[tuple[Button, ...], ...] = tuple(
            words.go_on_button(key)[0][:1] for key in resting
        )
        return Reply(joined("\n", filter(None, lines)), (*rows, *going))

    def _lines(self, who: PrincipalId) -> list[str]:
        return [self._line(who, key) for key in self._schedule.of(who)]

    def _line(self, who: PrincipalId, key: str) -> str:
        order, text = self._schedule.orders[key], self._schedule.texts[key]
        when = self._when(who, order.when, order.begun_ns - 1 if order.begun_ns else order.after_ns)
        return words.one(key, when, text.steps, rests=self._rests(key))

    def _rests(self, key: str) -> bool:
        agreed = self._schedule.orders[key].generations
        return agreed != self._generations(agreed)

    async def _unplan(self, asked: CommandContext) -> Reply:
        return await self._cancel(asked, asked.rest.strip())

    async def _cancel(self, asked: CommandContext, said_so: str) -> Reply:
        """Take one back, by its number or by words of it.

        Raises:
            NotUnderstood: Nothing of theirs is called so.
            NotPermitted: It is somebody else's.
        """
        who = asked.caller.principal
        if not said_so:
            return self._list(who, head=words.WHICH)
        keys = self._meant(who, said_so)
        if len(keys) > 1:
            return self._list(who, keys, words.several(said_so))
        [key] = keys
        async with self._changes.turn() as turn:
            order, text = self._found(asked, key)
            now_ns = self._rooms.organiser.wall_ns()
            decided = Decided(act="unschedule", by=who, about=key, at_ns=now_ns, digest=asked.cid)
            await turn.write((decided, self._schedule.end(key)))
        self._runs.cancel_one(key)
        if order.author != who:
            name = self._rooms.organiser.name_of(who)
            self._reach.tell((order.author,), words.cancelled_by(name, key, text.steps))
        return Reply(words.cancelled(key, text.steps))

    def _meant(self, who: PrincipalId, said_so: str) -> tuple[str, ...]:
        """Return what is meant by a number, or by words that all stand in it."""
        if said_so.isdecimal():
            return (said_so,)
        sought = [word for word in said_so.casefold().split() if word not in words.NO_SIGN]
        found = tuple(
            key for key in self._schedule.of(who) if sought and self._has(who, key, sought)
        )
        if not found:
            raise NotUnderstood(words.no_such(said_so), offers=("/planned",))
        return found

    def _has(self, who: PrincipalId, key: str, sought: Collection[str]) -> bool:
        """Whether every one of some words stands in what was said, or in how it is shown."""
        line = self._line(who, key)
        ways = plain(line), in_language(line, self._reach.read_by(who))
        text = " ".join((self._schedule.texts[key].typed, *ways)).casefold()
        return all(word in text for word in sought)

    def _found(self, asked: CommandContext, key: str) -> tuple[ScheduledOrder, ScheduledText]:
        """Return one that somebody may take back.

        Raises:
            NotUnderstood: Nothing has that number, as far as they may know.
            NotPermitted: It is somebody else's.
        """
        organiser, who = self._rooms.organiser, asked.caller.principal
        order = self._schedule.orders.get(key)
        if order is None:
            raise NotUnderstood(words.no_such(key), offers=("/planned",))
        assigns = organiser.rights.holds(who, FLEET, ASSIGN, organiser.wall_ns())
        if order.author != who and not assigns:
            raise NotPermitted(words.not_yours(organiser.name_of(order.author)))
        return order, self._schedule.texts[key]

    async def _go(self, asked: CommandContext, key: str) -> Reply:
        """Let one go on although a robot of it was stopped meanwhile.

        Raises:
            NotUnderstood: Nothing of theirs has that number, or it does not rest.
        """
        who = asked.caller.principal
        async with self._changes.turn() as turn:
            order = self._schedule.orders.get(key)
            if order is None or order.author != who:
                raise NotUnderstood(words.no_such(key), offers=("/planned",))
            if not self._rests(key):
                raise NotUnderstood(words.rests_not(key), offers=("/planned",))
            order = replace(order, generations=self._generations(order.generations))
            now_ns = self._rooms.organiser.wall_ns()
            decided = Decided(act="schedule", by=who, about=key, at_ns=now_ns, digest=asked.cid)
            await turn.write((decided, fact_of(key, order, self._schedule.texts[key])))
        at_ns = order.when.after(max(order.after_ns, now_ns))
        return Reply(words.goes_on(key, self._rooms.organiser.moment(who, at_ns or now_ns)))


def _named(line: Do) -> str:
    """Return an order with the name of whom it is for: another robot may be here by then."""
    return line.text if line.named else f"{line.name} {line.text.lstrip('/')}"
