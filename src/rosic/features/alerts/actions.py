"""What a rule lets its robot do: an order like any other, as the rule's author, over every room.

The author is a person of the configuration, with the rights they have at that moment. A rule waits
for nobody and confirms nothing: what would want a person's tap is not done, and that is said.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosic.container.records import ReplyTo
from rosic.core.alerts.rule import PAUSE, REALLOCATE
from rosic.core.identity import command_id
from rosic.core.order import Request
from rosic.core.order_status import OrderStatus
from rosic.core.policy.query import NOTHING
from rosic.core.records import Decided
from rosic.core.time_units import SECOND_NS
from rosic.errors import NotPermitted, RobotBusy, TakeOver, TooManyRequests
from rosic.features.alerts import messages as words
from rosic.features.alerts.active_alerts import AlertRun
from rosic.gateway.order_services import AutomatedRequester, no_tasks
from rosic.gateway.order_status import OrderMessage
from rosic.organiser.calendar_messages import length

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.clock import Clock
    from rosic.core.alerts.rule import AlertRule
    from rosic.core.identity import Caller, CommandId, PrincipalId
    from rosic.core.language import Do
    from rosic.core.order import Permit
    from rosic.features.alerts.active_alerts import AlertLog
    from rosic.gateway.components import Components
    from rosic.gateway.order_services import AlertTasks, OrderServices
    from rosic.gateway.transactions import Transactions


class ActionQueries(NamedTuple):
    """What the actions of rules ask of others.

    Attributes:
        author_of: Returns who is called so in the configuration; None: nobody.
        tasks: Keeps the tasks of a fleet; None: there are none.
    """

    author_of: Callable[[str], PrincipalId | None]
    tasks: AlertTasks | None


class AlertActions:
    """Gives the orders of rules: once an occurrence, and not more often than a rule says.

    Args:
        sides: What it asks.
    """

    def __init__(
        self,
        rooms: Components,
        hands: OrderServices,
        changes: Transactions,
        clock: Clock,
        book: AlertLog,
        sides: ActionQueries,
    ) -> None:
        self._author_of, self._tasks = sides
        self._rooms = rooms
        self._hands = hands
        self._changes = changes
        self._reach = hands.reach
        self._clock = clock
        self._book = book

    async def run(self, rule: AlertRule, line: Do | None, alarm_ns: int) -> None:
        """Do what a rule says, because of one occurrence.

        Args:
            rule: Which.
            line: What it runs, understood; None: what every robot can do (`AlertRule.act`).
            alarm_ns: When the alarm was raised: with the rule, the identity of what is done.

        Raises:
            Refusal: Why not; no robot has moved because of it.
        """
        author = self._author(rule)
        if line is None:
            await self._act(rule, author)
            return
        self._check_pace(rule, alarm_ns)
        caller = self._rooms.authoriser.stand_for(author)
        self._rooms.organiser.check_unlocked(caller)
        self._rooms.organiser.charge(caller)
        cid = command_id("rule", rule.robot, rule.alert.name, str(alarm_ns))
        permits, request = await self._admitted(rule, line, caller, cid)
        try:
            async with self._changes.turn() as turn:
                now_ns = self._clock.wall_ns()
                decided = Decided(
                    act="alarm-run", by=author, about=rule.key, at_ns=now_ns, digest=cid
                )
                await turn.write((decided, self._book.run(rule.key, AlertRun(now_ns, alarm_ns))))
            await self._begin(rule, caller, permits, request)
        except BaseException:
            self._rooms.organiser.abandon(permits)
            raise

    def _author(self, rule: AlertRule) -> PrincipalId:
        """Return in whose name a rule runs.

        Raises:
            NotPermitted: They have no access, or could not be told what came of it.
        """
        author = self._author_of(rule.alert.author)
        if author is None or not self._rooms.authoriser.has_access(author):
            raise NotPermitted(words.no_author(rule.alert.author))
        return author

    def _check_pace(self, rule: AlertRule, alarm_ns: int) -> None:
        last = self._book.last_run(rule.key)
        if last is None:
            return
        past_ns = self._clock.wall_ns() - last.at_ns  # a clock that was set back waits longer
        if past_ns < rule.run_every_ns or last.alarm_ns == alarm_ns:
            every_s = rule.run_every_ns // SECOND_NS
            raise TooManyRequests(words.too_soon(length(every_s)), retry_after_s=float(every_s))

    async def _act(self, rule: AlertRule, author: PrincipalId) -> None:
        """Stop, pause or reallocate: whoever may see a robot may stop it, and pausing is less."""
        if rule.robot not in self._rooms.organiser.visible(author):
            raise NotPermitted(words.no_author(rule.alert.author))
        if rule.act == REALLOCATE:
            await self._reallocate(rule, author)
        elif rule.act == PAUSE:
            await self._pause(rule, author)
        else:
            self._hands.stop_lane.stop_robots((rule.robot,), author)
        decided = Decided(act="alarm-run", by=author, about=rule.key, at_ns=self._clock.wall_ns())
        async with self._changes.turn() as turn:
            await turn.act((decided,))

    async def _pause(self, rule: AlertRule, author: PrincipalId) -> None:
        """Let a robot come to rest without latching anything; its task waits, if it has one."""
        why = words.paused(rule)
        if self._tasks is None or not await self._tasks.pause(rule.robot, author, why):
            await self._hands.executor.cut(rule.robot, why)

    async def _reallocate(self, rule: AlertRule, author: PrincipalId) -> None:
        if self._tasks is None:
            raise NotPermitted(no_tasks(self._rooms.profiles[rule.robot].shown))
        refusal = self._rooms.organiser.why_not_move(author, rule.robot)
        if refusal is not None:
            raise refusal
        await self._tasks.reallocate(rule.robot, author, words.paused(rule))

    async def _admitted(
        self, rule: AlertRule, line: Do, caller: Caller, cid: CommandId
    ) -> tuple[tuple[Permit, ...], Request]:
        """CHECKPERMISSIONS, once more where somebody has to give way first."""
        request = self._request(rule, line, cid)
        try:
            return self._admit(caller, request), request
        except TakeOver as needed:
            await self._take_over(rule, caller, needed)
        request = self._request(rule, line, cid)
        return self._admit(caller, request), request

    def _admit(self, caller: Caller, request: Request) -> tuple[Permit, ...]:
        complete = self._rooms.container.complete
        return self._rooms.organiser.admit(
            caller, [request], lambda one: complete(one).arguments, lambda: NOTHING
        )

    def _request(self, rule: AlertRule, line: Do, cid: CommandId) -> Request:
        [skill] = line.skills
        now_ns, wall_ns = self._clock.monotonic_ns(), self._clock.wall_ns()
        lives_ns = skill.order_lifetime_ns
        return Request(
            cid,
            rule.robot,
            skill,
            line.spoken,
            line.text,
            wall_ns,
            0,
            now_ns + lives_ns,
            wall_ns + lives_ns,
        )

    async def _take_over(self, rule: AlertRule, caller: Caller, needed: TakeOver) -> None:
        shown = self._rooms.profiles[rule.robot].shown
        name = self._rooms.organiser.name_of(caller.principal)
        self._reach.tell(needed.others, words.took_over(shown, name, rule), urgent=True)
        if not await self._hands.handover.end(rule.robot, words.reason(rule)):
            raise RobotBusy(words.not_at_rest(shown))
        self._rooms.organiser.yielded(rule.robot, caller.principal)

    async def _begin(
        self, rule: AlertRule, caller: Caller, permits: tuple[Permit, ...], request: Request
    ) -> None:
        """PROCESSCOMMAND; RELAYCOMMAND goes on by itself, shown to the author."""
        hands, shown = self._hands, self._rooms.profiles[rule.robot].shown
        places = self._reach.chats(caller.principal)
        if not places:
            name = self._rooms.organiser.name_of(caller.principal)
            raise NotPermitted(words.no_chat(name))
        messenger, chat = places[0]
        title = str(words.order_title(f"{shown}: {request.text}", rule))
        origin = ReplyTo(messenger.name, chat, "", title)
        [order] = await self._rooms.container.prepare(permits, [request], origin)
        catalogue = hands.chat_sender.languages.of(caller.principal)
        order_message = OrderMessage(
            messenger,
            chat,
            "",
            caller.principal,
            buttons=words.stop_button(rule.robot),
            after=hands.ends[rule.robot, request.text, catalogue],
        )
        titled = str(words.order_title(f"{shown}: {order.words}", rule))
        status = OrderStatus(shown, titled, hands.face, self._clock.wall_ns())
        order_message.show(order.cid, status)
        hands.executor.begin(
            order, AutomatedRequester(caller), order_message, status, self._rooms.linker.dispatch
        )
        hands.chat_sender.show(order_message)
