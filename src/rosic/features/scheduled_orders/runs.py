"""What is done at its time: orders like any other, one step after another, as their author.

Nobody is asked to confirm anything, and nobody is made to give a robot up. Each step has to come to
what was shown when it was agreed to (I16); the rights, limits and stops are those of that moment.
"""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.container.records import ReplyTo
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.contracts.messenger import catching_up
from rosic.core.i18n import in_language, joined
from rosic.core.identity import DIGEST_BYTES, command_id, robot_command_id
from rosic.core.language import Do, LanguageReader, Misunderstood
from rosic.core.order import OrderEnding, Request
from rosic.core.order_status import ENGLISH, wording_in
from rosic.core.policy.query import NOTHING
from rosic.core.synchronised_start import begin_together
from rosic.errors import Expired, NotPermitted, NotUnderstood, OrderVoid, Refusal, RobotStopped
from rosic.features.scheduled_orders import messages as words
from rosic.features.scheduled_orders.schedule import LOOK_S
from rosic.gateway.limit_clamping import LimitClamping
from rosic.gateway.order_execution import CANCELLED_BEFORE
from rosic.gateway.order_services import AutomatedRequester
from rosic.gateway.order_status import AwaitedOrder, OrderMessage, stop_button
from rosic.gateway.requests import RequestFactory

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Caller, CommandId, PrincipalId
    from rosic.core.message import Chat
    from rosic.core.order import Order, Outcome, Permit
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Argument
    from rosic.features.scheduled_orders.schedule import OrderOccurrence, OrderSchedule
    from rosic.gateway.agreement import Agreements
    from rosic.gateway.components import Components
    from rosic.gateway.order_services import OrderServices

CARRIED_OUT: Final = frozenset({OrderEnding.DONE, OrderEnding.SENT})

log = logging.getLogger("rosic.scheduled")


class ScheduledRun:
    """One plan under way.

    Attributes:
        due: Which, and when it was to begin.
        robots: Whose orders it gives.
        cancelled: Its author has ended what they had under way: no step begins any more.
        rests: A robot was stopped since it was agreed to: it waits for a word of its author.
    """

    __slots__ = ("cancelled", "due", "rests", "robots")

    def __init__(self, due: OrderOccurrence) -> None:
        self.due = due
        self.cancelled = False
        self.rests = False
        self.robots = frozenset(due.order.generations)

    def cancel(self) -> None:
        """Let no step begin any more."""
        self.cancelled = True

    def rest(self) -> None:
        """Let it wait for a word of its author, if it comes again."""
        self.rests = self.due.order.when.first is not None


class ScheduledRuns:
    """Carries out what is due, and says to its author what does not come of it."""

    def __init__(
        self,
        rooms: Components,
        hands: OrderServices,
        agreements: Agreements,
        schedule: OrderSchedule,
        clock: Clock,
    ) -> None:
        self._rooms = rooms
        self._hands = hands
        self._agreements = agreements
        self._schedule = schedule
        self._clock = clock
        self._reader = LanguageReader(rooms.vocabularies)
        self._clamping = LimitClamping(rooms, RequestFactory(rooms, clock), clock)
        self._runs: dict[str, ScheduledRun] = {}
        self._tasks: BackgroundTasks[None] = BackgroundTasks()

    # ---- when it is due ----

    def begin(self, due: OrderOccurrence) -> None:
        """Begin it; whatever comes of it is said."""
        if due.key in self._runs:
            self._tell(due, words.under_way_still(due.key, due.text.steps))
            return
        run = self._runs[due.key] = ScheduledRun(due)
        self._tasks.begin(self._carry(run))

    def missed(self, due: OrderOccurrence) -> None:
        """Say that it was too late to begin."""
        at = self._rooms.organiser.moment(due.order.author, due.at_ns)
        self._tell(due, words.missed(due.key, due.text.steps, at))

    def interrupted(self, due: OrderOccurrence) -> None:
        """Say that it was under way when ROSIC ended."""
        self._tell(due, words.interrupted(due.key, due.text.steps))

    def cancel(self, who: PrincipalId, robots: Collection[RobotId] = ()) -> None:
        """Let no step of somebody begin any more, of any robot or of some."""
        for run in self._runs.values():
            theirs = run.due.order.author == who
            if theirs and (not robots or not run.robots.isdisjoint(robots)):
                run.cancel()

    def cancel_one(self, key: str) -> None:
        """Let no step of one plan begin any more."""
        if (run := self._runs.get(key)) is not None:
            run.cancel()

    async def close(self) -> None:
        """Follow nothing any more; the orders under way end with the others."""
        for task in tuple(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    def _tell(self, due: OrderOccurrence, text: str, *, rests: bool = False) -> None:
        buttons = words.go_on_button(due.key) if rests else ()
        self._hands.reach.tell((due.order.author,), text, buttons, lifetime_s=words.GO_ON_S)

    # ---- step by step ----

    async def _carry(self, run: ScheduledRun) -> None:
        """Carry one out. Cut off by the end of ROSIC it stays noted, for the next run to say so."""
        try:
            await self._all_steps(run)
        finally:
            self._runs.pop(run.due.key, None)
        self._schedule.over(run.due)

    async def _all_steps(self, run: ScheduledRun) -> None:
        due, step, steps = run.due, 0, len(run.due.text.steps)
        try:
            for step in range(steps):
                ended = await self._step(run, step)
                if not all(outcome.ending in CARRIED_OUT for outcome in ended):
                    if step + 1 < steps:
                        self._tell(due, words.rest_not_done(due.key, step + 1, steps))
                    return
            if steps > 1:
                self._tell(due, words.all_done(due.key, due.text.steps))
        except Refusal as why:
            self._say_why_not(run, step, why)
        except Exception:
            log.exception("the planned order %s could not be carried out", due.key)
            self._tell(due, words.not_done(due.key, due.text.steps, words.FAULT))

    def _say_why_not(self, run: ScheduledRun, step: int, why: Refusal) -> None:
        due = run.due
        if step:
            text = words.ended_at(due.key, step + 1, len(due.text.steps), why.sentence)
        else:
            text = words.not_done(due.key, due.text.steps, why.sentence)
        self._tell(due, text, rests=run.rests)

    async def _step(self, run: ScheduledRun, step: int) -> list[Outcome]:
        """Return how the orders of one step have ended.

        Raises:
            Refusal: Why it was not begun. No robot has moved because of it.
        """
        due, rooms = run.due, self._rooms
        await self._caught_up(due)
        self._check_wanted(run)
        caller = rooms.authoriser.stand_for(due.order.author)
        rooms.organiser.check_unlocked(caller)
        line = self._line(due, step, caller)
        self._check_stops(run, line)
        if not step:
            rooms.organiser.charge(caller)
        line, note = self._clamping.of(caller, line)
        cid = command_id("scheduled", due.key, str(due.order.given_ns), str(due.at_ns), str(step))
        requests = self._requests(due, step, line, cid)
        where = self._where(due)
        permits = rooms.organiser.admit(caller, requests, self._arguments_of, lambda: NOTHING)
        orders = await self._prepared(permits, requests, where, words.titled(due.key, line.text))
        if step + 1 == len(due.text.steps):
            self._schedule.over(due)  # from here on its orders speak for themselves
        return await self._ended(due, step, (caller, where), line, note, orders)

    async def _caught_up(self, due: OrderOccurrence) -> None:
        """Wait until no stop can come any more that was said while nobody listened.

        Raises:
            Expired: That takes longer than an order lives.
        """
        began_ns = self._clock.monotonic_ns()
        while any(map(catching_up, self._hands.reach.messengers)):
            if self._clock.monotonic_ns() - began_ns > due.order.lives_ns:
                raise Expired(words.TOO_LATE)
            await self._clock.sleep(LOOK_S)

    def _check_wanted(self, run: ScheduledRun) -> None:
        if run.cancelled:
            raise OrderVoid(CANCELLED_BEFORE)

    def _line(self, due: OrderOccurrence, step: int, caller: Caller) -> Do:
        """Return a step as it is read now.

        Raises:
            NotUnderstood: It means nothing any more.
            Expired: It would be something else than what was shown.
        """
        who, text = caller.principal, due.text.steps[step]
        [line, *_] = self._reader.lines(text, "", self._rooms.organiser.visible(who))
        if isinstance(line, Misunderstood):
            raise NotUnderstood(line.sentence)
        if not isinstance(line, Do):
            raise Expired(words.means_something_else(text))
        act = self._agreements.of(line, caller)
        if act.digest[:DIGEST_BYTES] != due.order.digests[step]:
            raise Expired(words.would_be(act.shown))
        return line

    def _check_stops(self, run: ScheduledRun, line: Do) -> None:
        """See that nobody has stopped any of its robots since it was agreed to (I5).

        Raises:
            RobotStopped: Somebody has, and it was resumed meanwhile, or is not asked by this step.
        """
        agreed = run.due.order.generations
        for robot in dict.fromkeys((*line.robots, *agreed)):
            stopped = self._rooms.stops.get(robot)
            if stopped is not None and stopped.generation != agreed.get(robot, -1):
                run.rest()
                if stopped.latched and robot in line.robots:
                    continue  # who has stopped it is said by whoever decides
                raise RobotStopped(words.stopped_since(self._rooms.profiles[robot].shown))

    def _requests(self, due: OrderOccurrence, step: int, line: Do, cid: CommandId) -> list[Request]:
        """Return what a step asks of each robot; the first step is as old as its time (I2).

        Raises:
            Expired: It is too late to begin.
        """
        now_ns, wall_ns = self._clock.monotonic_ns(), self._clock.wall_ns()
        age_ns = 0 if step else max(0, wall_ns - due.at_ns)
        requests: list[Request] = []
        for robot, skill in zip(line.robots, line.skills, strict=True):
            left_ns = skill.order_lifetime_ns - age_ns
            if left_ns < 0:
                raise Expired(words.TOO_LATE)
            requests.append(
                Request(
                    robot_command_id(cid, robot) if requests else cid,
                    robot,
                    skill,
                    line.spoken,
                    line.text,
                    wall_ns - age_ns,
                    age_ns,
                    now_ns + left_ns,
                    wall_ns + left_ns,
                    line.group,
                )
            )
        return requests

    def _arguments_of(self, request: Request) -> Mapping[str, Argument]:
        return self._rooms.container.complete(request).arguments

    def _where(self, due: OrderOccurrence) -> tuple[Messenger, Chat]:
        """Return where the orders are shown: where it was planned, or else in private."""
        reach, author = self._hands.reach, due.order.author
        for messenger in reach.messengers:
            here = messenger.name == due.text.messenger
            if here and reach.may_read(author, due.text.chat):
                return messenger, due.text.chat
        places = reach.chats(author)
        if not places:
            raise NotPermitted(words.no_chat(self._rooms.organiser.name_of(author)))
        return places[0]

    async def _prepared(
        self,
        permits: tuple[Permit, ...],
        requests: Sequence[Request],
        where: tuple[Messenger, Chat],
        title: str,
    ) -> tuple[Order, ...]:
        """PROCESSCOMMAND: return the orders, which are on disk."""
        messenger, chat = where
        origin = ReplyTo(messenger.name, chat, "", title)
        try:
            for request in requests:
                self._rooms.linker.check_free(request.robot)
            return await self._rooms.container.prepare(permits, requests, origin)
        except BaseException:
            self._rooms.organiser.abandon(permits)
            raise

    async def _ended(
        self,
        due: OrderOccurrence,
        step: int,
        whose: tuple[Caller, tuple[Messenger, Chat]],
        line: Do,
        note: str,
        orders: tuple[Order, ...],
    ) -> list[Outcome]:
        """RELAYCOMMAND goes on by itself; return how it ended, once that is on disk."""
        hands, (caller, (messenger, chat)) = self._hands, whose
        catalogue = hands.chat_sender.languages.of(caller.principal)
        wording = ENGLISH if catalogue is None else wording_in(catalogue)
        about, now_ns = line.name, self._clock.wall_ns()
        order_message = OrderMessage(
            messenger,
            chat,
            "",
            caller.principal,
            wording,
            about=about,
            buttons=stop_button(about),
            after=hands.ends[about, line.text, catalogue],
        )
        if len(orders) > 1:
            orders = begin_together(orders, self._clock.monotonic_ns())
        ends: list[asyncio.Future[Outcome]] = []
        for order in orders:
            shown = self._rooms.profiles[order.robot].shown
            what = in_language(joined(", ", filter(None, (order.words, note))), catalogue)
            title = words.order_title(f"{shown}: {what}", due.key, step + 1, len(due.text.steps))
            status = AwaitedOrder(shown, in_language(title, catalogue), hands.face, now_ns, wording)
            order_message.show(order.cid, status)
            end: asyncio.Future[Outcome] = asyncio.get_running_loop().create_future()
            ends.append(end)
            status.over = partial(_hear, end)
            hands.executor.begin(
                order,
                AutomatedRequester(caller),
                order_message,
                status,
                self._rooms.linker.dispatch,
            )
        hands.chat_sender.show(order_message)
        return list(await asyncio.gather(*ends))


def _hear(end: asyncio.Future[Outcome], outcome: Outcome) -> None:
    if not end.done():  # nobody waits for it at the end of a run of ROSIC
        end.set_result(outcome)
