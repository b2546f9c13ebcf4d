"""The stop lane: before the grammar, never queued, limited, expired or void (I5, I10)."""

from __future__ import annotations

import asyncio
import logging
from collections import Counter
from itertools import islice
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from rosic.authoriser.button_tokens import ANYBODY, MENU_LIFETIME_NS
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core import messages
from rosic.core.i18n import in_language, joined, said
from rosic.core.language import leaves_out
from rosic.core.message import AnswerState, Button, ChatKind, Inbound, Outbound, SendPriority
from rosic.core.order import RestReport
from rosic.core.records import Stopped
from rosic.core.time_units import MINUTE_NS
from rosic.errors import ChatGone, MessageGone, MessengerFault, Unrecognised
from rosic.gateway.button_rows import rows
from rosic.gateway.delivery.chat_queue import OutgoingMessage
from rosic.gateway.group_people import GroupChatPeople, is_unnamed
from rosic.gateway.replies import ask_for_it
from rosic.gateway.resume import RESUMED_AT_MOST
from rosic.gateway.stopped_by import STOPPERS_AT_MOST, stopped_by

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Coroutine
    from typing import TypeAlias

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.store import Store
    from rosic.core.i18n import Catalogue
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.outbox import Outbox
    from rosic.gateway.delivery.sender import ChatSender
    from rosic.gateway.resume import ResumeHandler
    from rosic.linker.linker import StopInProgress


# ---- stops that are not on disk yet ----


class LatchWait:
    """Knows the newest stop of each robot, by the messenger that would bring it again."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._newest: dict[tuple[str, RobotId], asyncio.Future[None]] = {}
        self._holds: dict[asyncio.Future[None], int] = {}

    async def hold(
        self,
        messenger: str,
        robots: tuple[RobotId, ...],
        latched: asyncio.Task[bool],
        within_s: float,
    ) -> None:
        """Wait until a stop is on disk, or newer ones stop all its robots, or for so long."""
        mine: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        names = [(messenger, robot) for robot in robots]
        self._holds[mine] = len(names)
        for name in names:
            self._succeed(self._newest.get(name))
            self._newest[name] = mine
        patience = asyncio.create_task(self._clock.sleep(within_s))
        try:
            await asyncio.wait((latched, patience, mine), return_when=asyncio.FIRST_COMPLETED)
        finally:
            patience.cancel()
            del self._holds[mine]
            for name in names:
                if self._newest.get(name) is mine:
                    del self._newest[name]

    def _succeed(self, older: asyncio.Future[None] | None) -> None:
        if older is None:
            return
        self._holds[older] -= 1
        if not self._holds[older] and not older.done():
            older.set_result(None)


# ---- the stop lane (I5, I10) ----
# Before the grammar; never queued, limited, expired or void.


if TYPE_CHECKING:
    OwnOf: TypeAlias = Callable[[PrincipalId], Collection[RobotId]]

# In one chat at a time. Stops are obeyed whatever their number; answering a flood of them helps
# nobody (I15).
ANSWERS_AT_MOST = 8
LATCH_WITHIN_S = 10.0
REPEATED_WITHIN_NS = MINUTE_NS
"""Whoever says stop all day to what is stopped has so often a row of the record to themselves."""
NOT_WRITTEN = said("I could not write this down: after a restart, look before you move anything.")
NOBODY_LEFT_OUT = said("A stop leaves nobody out: all of them were stopped.")

log = logging.getLogger("rosic.stop")


class StopLane:
    """Stops whatever its author may see.

    Attributes:
        resuming: Undoes stops; every answer to one offers that.
        hears: Whether a stop could be in a message at all; see `GroupChatPeople`.

    Args:
        outbox: Has a stop answered even if this process does not live to do it.
    """

    def __init__(
        self,
        rooms: Components,
        store: Store,
        clock: Clock,
        chat_sender: ChatSender,
        resuming: ResumeHandler,
        outbox: Outbox,
    ) -> None:
        self._languages = chat_sender.languages
        self._chat_sender = chat_sender
        self.resuming = resuming
        self._authoriser = rooms.authoriser
        self._organiser = rooms.organiser
        self._company = GroupChatPeople(rooms, clock)
        self.hears = self._company.hears
        self._linker = rooms.linker
        self._stops = rooms.stops
        self._profiles = rooms.profiles
        self._vocabularies = rooms.vocabularies
        self._store = store
        self._clock = clock
        self._latch_wait = LatchWait(clock)
        self._tasks: BackgroundTasks[None] = BackgroundTasks()
        self._following: dict[tuple[str, str, RobotId], asyncio.Task[None]] = {}
        self._answering: Counter[tuple[str, str]] = Counter()
        self._outbox = outbox
        self._noted_ns: dict[RobotId, dict[PrincipalId, int]] = {}

    async def stop(
        self, messenger: Messenger, inbound: Inbound, names: tuple[str, ...], own_of: OwnOf
    ) -> bool:
        """Stop now; tell when rest was measured. On return every adapter has been told to stop.

        And the latch is on disk, or cannot be written, or newer stops by the same messenger wait
        for it: a messenger confirms a message when this
        returns, and a stop that is confirmed must survive whatever comes (I13).

        A stranger's stop changes nothing: he sees no robot. A stop without an identity (an
        anonymous admin, a channel) counts for the people recognised in that chat; see
        `GroupChatPeople`.

        Args:
            messenger: By which it came, and is answered.
            inbound: The message, or the tap.
            names: As `hears_stop` returns them.
            own_of: Returns the robots whose order, under way or waiting, is somebody's own and was
                meant by this stop: whoever stops their own order may let that robot go on again.

        Returns:
            Whether that is all there is to say: not to a stranger, who has to hear that nothing was
            stopped.
        """
        if inbound.tap:
            self._spawn(messenger.answer_tap(inbound, ""))
        by, visible = self._whose(inbound)
        visible = visible or await self._company.ask(messenger, inbound)
        robots, _ = self._vocabularies.current.to_stop(names, visible)
        if not robots:
            return bool(by) or is_unnamed(inbound)
        halting = self.stop_robots(robots, by, own_of(by) if by else ())
        where = (messenger.name, inbound.chat.id)
        if self._answering[where] < ANSWERS_AT_MOST:
            self._answering[where] += 1
            self._spawn(self._answer(messenger, inbound, halting, by))
        await self._latch_wait.hold(messenger.name, robots, halting.latched, LATCH_WITHIN_S)
        return True

    def stop_robots(
        self, robots: tuple[RobotId, ...], by: PrincipalId, own: Collection[RobotId] = ()
    ) -> StopInProgress:
        """Stop robots, also for somebody who does not ask in a chat: the operator, a revocation.

        Args:
            robots: Which.
            by: Who stops them; empty: nobody who is known.
            own: Those among them that carry out an order of theirs by which they are stopped.
        """
        stops = self._stops
        again = frozenset(r for r in robots if stops[r].latched)
        mine = [r for r in robots if r in own and (not stops[r].latched or stops[r].own == by)]
        halting = self._linker.stop(robots, by)
        for robot in mine:
            stops[robot].stopped_their_own(by)
        self._note(robots, by, again)
        return halting

    @property
    def quiet(self) -> bool:
        """Whether every stop has been answered."""
        return not self._tasks

    def _whose(self, inbound: Inbound) -> tuple[PrincipalId, frozenset[RobotId]]:
        try:
            caller = self._authoriser.identify(inbound)
        except Unrecognised:
            return "", self._company.visible(inbound.chat) if is_unnamed(inbound) else frozenset()
        return caller.principal, self._organiser.visible(caller.principal)

    def _note(
        self, robots: tuple[RobotId, ...], by: PrincipalId, again: frozenset[RobotId]
    ) -> None:
        at_ns, now_ns = self._clock.wall_ns(), self._clock.monotonic_ns()
        self._store.note(
            *(
                Stopped(
                    robot=robot,
                    generation=self._stops[robot].generation,
                    principal=by,
                    at_ns=at_ns,
                    repeated=self._is_repeated(robot, by, now_ns, again=robot in again),
                )
                for robot in robots
            ),
            *(stopped_by(robot, self._stops) for robot in robots),
        )

    def _is_repeated(self, robot: RobotId, by: PrincipalId, now_ns: int, *, again: bool) -> bool:
        """Whether somebody's last stop of a robot stands for this one on the record, too."""
        noted = self._noted_ns.setdefault(robot, {})
        if not again or len(noted) > STOPPERS_AT_MOST:
            noted.clear()
        if now_ns - noted.get(by, -REPEATED_WITHIN_NS) < REPEATED_WITHIN_NS:
            return True
        noted[by] = now_ns
        return False

    async def _answer(
        self, messenger: Messenger, inbound: Inbound, halting: StopInProgress, by: PrincipalId
    ) -> None:
        where = (messenger.name, inbound.chat.id)
        try:
            await self._answer_when_at_rest(messenger, inbound, halting, by)
        finally:
            self._answering[where] -= 1
            if not self._answering[where]:
                del self._answering[where]

    async def _answer_when_at_rest(
        self, messenger: Messenger, inbound: Inbound, halting: StopInProgress, by: PrincipalId
    ) -> None:
        generations = {robot: self._stops[robot].generation for robot in halting.rests}
        self._leave_off(messenger, inbound, generations)
        shown = [self._profiles[robot].shown for robot in halting.rests]
        catalogue = self._languages.of_sender(inbound)
        message = key = ""
        if by:
            plain = in_language(messages.stopped_unseen(shown), catalogue)
            owed = Outbound(chat=inbound.chat, text=plain, weight=SendPriority.STOP)
            key = self._outbox.owe(by, messenger, owed)
        if messenger.edits:
            plain = in_language(messages.stopping(shown), catalogue)
            sent = Outbound(
                chat=inbound.chat,
                text=plain,
                weight=SendPriority.STOP,
                cause=inbound.message,
                state=AnswerState.GOES_ON,
            )
            message = await self._say(messenger, sent, "")
        rests = [await self._rest(robot, task) for robot, task in halting.rests.items()]
        text = self._told(inbound, rests)
        if not await halting.kept(self._clock):
            text = joined(" ", (text, NOT_WRITTEN))
        who, asking = self._who_can(inbound, tuple(halting.rests), by)
        plain = in_language(joined("\n", filter(None, (text, who))), catalogue)
        buttons = self._buttons(inbound, tuple(halting.rests), by, catalogue, asking)
        rested = all(rest.confirmed for rest in rests)
        outbound = Outbound(
            chat=inbound.chat,
            text=plain,
            buttons=buttons,
            weight=SendPriority.STOP,
            cause=inbound.message,
            state=AnswerState.DONE if rested else AnswerState.NOT_DONE,
        )
        told = await self._say(messenger, outbound, message)
        if told:
            self._chat_sender.on_buttons.emit(OutgoingMessage(messenger, outbound), told)
        if told:
            self._outbox.said(key)
        else:
            self._outbox.insist(key, messenger, replace(outbound, buttons=()))
        for rest in islice((r for r in rests if not r.confirmed), messages.NAMED_AT_MOST):
            self._follow(messenger, inbound, rest.robot, generations[rest.robot])

    def _told(self, inbound: Inbound, rests: list[RestReport]) -> str:
        """Return what became of a stop; and that it left nobody out, where it was to."""
        text = messages.rests(self._profiles, rests)
        all_the_same = len(rests) > 1 and leaves_out(inbound.text)
        return joined("\n", (text, NOBODY_LEFT_OUT)) if all_the_same else text

    def _follow(
        self, messenger: Messenger, inbound: Inbound, robot: RobotId, generation: int
    ) -> None:
        task = asyncio.create_task(self._when_at_rest(messenger, inbound, robot, generation))
        where = (messenger.name, inbound.chat.id, robot)
        self._following[where] = task
        task.add_done_callback(lambda _: self._followed(where, task))

    def _followed(self, where: tuple[str, str, RobotId], task: asyncio.Task[None]) -> None:
        if self._following.get(where) is task:
            del self._following[where]

    def _leave_off(
        self, messenger: Messenger, inbound: Inbound, robots: Collection[RobotId]
    ) -> None:
        """Say nothing more of earlier stops in a chat: the answer to the newest says how it is."""
        for robot in robots:
            task = self._following.pop((messenger.name, inbound.chat.id, robot), None)
            if task is not None:
                task.cancel()

    async def _when_at_rest(
        self, messenger: Messenger, inbound: Inbound, robot: RobotId, generation: int
    ) -> None:
        """Say so once a robot is at rest whose stop was answered without that.

        Whoever stopped it before others did is told, too; nobody once it was resumed.
        """
        rested = await self._linker.pursuit.rested(robot, generation)
        if rested is None or not self._stops[robot].latched:
            return
        text = messages.at_rest_now(self._profiles[robot].shown)
        plain = in_language(text, self._languages.of_sender(inbound))
        await self._say(
            messenger, Outbound(chat=inbound.chat, text=plain, weight=SendPriority.STOP), ""
        )

    def _buttons(
        self,
        inbound: Inbound,
        robots: tuple[RobotId, ...],
        by: PrincipalId,
        catalogue: Catalogue | None,
        asking: tuple[tuple[Button, ...], ...],
    ) -> tuple[tuple[Button, ...], ...]:
        """Offer to resume what was stopped, to whoever may; and to ask for that, to others.

        In a group the buttons are for everybody there: each tap is checked for whoever taps.
        """
        together = inbound.chat.kind is ChatKind.GROUP
        if not together:
            may = (robot for robot in robots if by and self.resuming.may(by, robot))
            robots = tuple(islice(may, RESUMED_AT_MOST + 1))
        issue, who = self._authoriser.buttons.issue, ANYBODY if together else by
        return tuple(
            tuple(
                issue(replace(b, label=in_language(b.label, catalogue)), who, inbound.chat.id)
                for b in row
            )
            for row in (*self.resuming.buttons(robots), *asking)
        )

    def _who_can(
        self, inbound: Inbound, robots: tuple[RobotId, ...], by: PrincipalId
    ) -> tuple[str, tuple[tuple[Button, ...], ...]]:
        """Return who can resume what their own stop leaves to others, and how to ask them.

        Of what they may move, if they may move any of it: the rest is nobody's concern here.
        """
        stopped = [robot for robot in robots if self._stops[robot].latched]
        if not by or not stopped or inbound.chat.kind is ChatKind.GROUP:
            return "", ()
        why, organiser = self._organiser.why_stopped, self._organiser
        free = [robot for robot in stopped if self._stops.barred(robot) is None]
        left = [robot for robot in free if not self.resuming.may(by, robot)]
        theirs = [robot for robot in left if organiser.why_not_move(by, robot) is None]
        left = theirs or left
        if not left:
            return "", ()
        asks = [(robot, why.access_request(by, robot)) for robot in theirs[:RESUMED_AT_MOST]]
        several = len(robots) > 1
        return why.who_resumes(by, left, several=several), rows(
            [
                Button(
                    said("Ask to resume {shown}", shown=self._profiles[robot].shown)
                    if several
                    else ask_for_it(),
                    access_request,
                    good_for_ns=MENU_LIFETIME_NS,
                )
                for robot, access_request in asks
                if access_request
            ]
        )

    async def _rest(self, robot: RobotId, task: asyncio.Task[RestReport]) -> RestReport:
        try:
            return await asyncio.shield(task)
        except Exception:
            log.exception("the stop of %s failed", robot)
            return RestReport(robot, confirmed=False, seconds=0.0)

    async def _say(self, messenger: Messenger, outbound: Outbound, message: str) -> str:
        """Send or edit, with patience: the answer to a stop is worth trying again."""
        for wait_s in (0.2, 0.5, 1.0, 2.0, 5.0):
            try:
                if message:
                    await messenger.edit(message, outbound)
                    return message
                return await messenger.send(outbound)
            except MessageGone:
                message = ""
            except ChatGone:
                break
            except MessengerFault as fault:
                log.warning("the answer to a stop was not told yet: %s", fault)
                await self._clock.sleep(wait_s)
        return ""

    def _spawn(self, work: Coroutine[Any, Any, None]) -> None:
        self._tasks.begin(work)

    async def close(self) -> None:
        """Wait for answers under way, briefly; robots are stopped already."""
        for task in self._following.values():
            task.cancel()
        if self._tasks:
            await asyncio.wait(tuple(self._tasks), timeout=2.0)
