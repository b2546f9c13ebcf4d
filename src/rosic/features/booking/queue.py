"""``/wait kuka1``, ``/wait none kuka1``, and the buttons under an offered turn."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said
from rosic.core.language.compiled import fold
from rosic.core.language.keywords import NOTHING
from rosic.core.message import Button
from rosic.core.time_units import MINUTE_NS
from rosic.errors import NotPermitted, NotUnderstood, RobotTaken
from rosic.features.booking import messages as words
from rosic.features.booking.context import decided
from rosic.gateway.commands import Reply
from rosic.gateway.robot_argument import RobotArgument
from rosic.organiser.calendar_messages import moment
from rosic.organiser.wait_queue import your_place

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.core.identity import PrincipalId
    from rosic.core.records import Record
    from rosic.core.robot.profile import RobotId
    from rosic.features.booking.context import BookingContext
    from rosic.features.booking.scheduler import BookingScheduler
    from rosic.gateway.commands import CommandContext

# Said by buttons, with a robot after them.
TAKE, KEEP = "take", "keep"
_ENDS = ".,;:!?"
_SOON_NS = MINUTE_NS


class QueueCommands:
    """The handler who keeps queues."""

    def __init__(self, times: BookingContext, scheduler: BookingScheduler) -> None:
        self._times = times
        self._scheduler = scheduler
        self._availability = scheduler.availability
        self._naming = RobotArgument(times)

    async def wait(self, asked: CommandContext) -> Reply:
        """Join a queue, leave it, take a turn, or keep a time that is not used.

        Raises:
            Refusal: Why not; nobody's place has changed.
        """
        text = asked.rest.strip().rstrip(_ENDS)
        first, _, rest = text.partition(" ")
        word = fold(first)
        meant: dict[str, Callable[[CommandContext, str], Awaitable[Reply]]] = {
            TAKE: self._take,
            KEEP: self._keep,
            **dict.fromkeys(NOTHING, self._leave),
        }
        if word in meant and not self._naming.calls(asked, text):
            return await meant[word](asked, rest.strip())
        if not text and (waits := self._times.waiting.waits_for(asked.caller.principal)):
            return self._places(asked.caller.principal, waits)
        robot, more = self._naming.robot(asked, "wait", text)
        if more:
            raise NotUnderstood(words.only_a_name(), offers=(f"wait {robot}",))
        return await self._join(asked.caller.principal, robot)

    # ---- places ----

    async def _join(self, principal: PrincipalId, robot: RobotId) -> Reply:
        times = self._times
        async with times.changes.turn() as turn:
            self._check(principal, robot)
            if self._availability.has(principal, robot):
                until = self._until(principal, robot)
                return Reply(words.yours_already(times.shown(robot), until))
            await turn.write(times.waiting.join(principal, robot))
            place = self._place(principal, robot)
        leave = Button(said("Leave the queue"), f"/wait none {robot}")
        return Reply(words.queued(place), ((leave,),))

    def _check(self, principal: PrincipalId, robot: RobotId) -> None:
        refusal = self._times.sides.may_book(principal, robot)
        if refusal is not None:
            raise refusal

    def _place(self, principal: PrincipalId, robot: RobotId) -> str:
        times = self._times
        waiting, now_ns = times.waiting, times.clock.wall_ns()
        free_ns = now_ns
        if self._availability.booked(robot):
            useful_s = times.calendar.limits.useful_s
            free_ns = times.calendar.next_free(robot, now_ns, useful_s, principal)
        about_ns = waiting.estimate_ns(principal, robot, free_ns) or now_ns
        zone = times.sides.zone_of(principal)
        place = waiting.place(principal, robot)
        return your_place(times.shown(robot), place, about_ns, now_ns, zone)

    def _places(self, principal: PrincipalId, robots: tuple[RobotId, ...]) -> Reply:
        lines = [self._place(principal, robot) for robot in sorted(robots)]
        rows = tuple(
            (Button(said("Leave {shown}", shown=self._times.shown(robot)), f"/wait none {robot}"),)
            for robot in sorted(robots)
        )
        return Reply(joined("\n", lines), rows)

    async def _leave(self, asked: CommandContext, text: str) -> Reply:
        """Leave one queue, or every queue if none is named."""
        times, principal = self._times, asked.caller.principal
        robots = times.waiting.waits_for(principal)
        if text:
            robot, _ = self._naming.robot(asked, "wait none", text)
            if robot not in robots:
                return Reply(words.not_in_queue(times.shown(robot)))
            robots = (robot,)
        if not robots:
            return Reply(words.NOT_WAITING)
        async with times.changes.turn() as turn:
            offers = [times.waiting.standing(robot) for robot in robots]
            facts = [fact for r in robots for fact in times.waiting.leave(principal, r)]
            await turn.write(facts)
            for offer in offers:
                if offer is not None and offer.principal == principal:
                    self._availability.give_up(offer)
        return Reply(joined("\n", (words.left_queue(times.shown(r)) for r in sorted(robots))))

    # ---- turns ----

    async def _take(self, asked: CommandContext, text: str) -> Reply:
        times, principal = self._times, asked.caller.principal
        robot, _ = self._naming.robot(asked, "wait", text)
        async with times.changes.turn() as turn:
            self._check(principal, robot)
            left = times.waiting.take(principal, robot)
            if not self._availability.free_for(robot, principal):
                place = times.waiting.place(principal, robot)
                times.waiting.withdraw(robot)
                raise RobotTaken(words.taken_meanwhile(times.shown(robot), place))
            await turn.write((*self._slot(principal, robot), *left))
            self._availability.give(robot, principal)
        until = self._until(principal, robot)
        menu = Button(times.shown(robot), f"/use {robot}")
        return Reply(words.turn_taken(times.shown(robot), until), ((menu,),))

    def _slot(self, principal: PrincipalId, robot: RobotId) -> tuple[Record, ...]:
        """Return what books a turn: nobody else can have the robot then."""
        times = self._times
        if not self._availability.booked(robot) or self._availability.slot(robot) is not None:
            return ()
        start_ns, length_s = self._availability.turn(robot)
        if length_s < times.calendar.limits.shortest_s:
            return ()  # their own slot begins just now
        facts = times.calendar.book(principal, robot, start_ns, length_s, principal)
        return decided("book", principal, times.clock.wall_ns(), facts)

    def _until(self, principal: PrincipalId, robot: RobotId) -> str:
        """Return until when a robot is somebody's by their slots; empty if they have none."""
        times = self._times
        now_ns = times.clock.wall_ns()
        if not self._availability.booked(robot):
            return ""
        slots = [s for s in times.upcoming(principal) if s.robot == robot]
        if not slots or slots[0].start_ns >= now_ns + _SOON_NS:
            return ""
        end_ns = slots[0].end_ns
        for slot in slots[1:]:
            if slot.start_ns != end_ns:
                break
            end_ns = slot.end_ns
        return moment(end_ns, now_ns, times.sides.zone_of(principal))

    async def _keep(self, asked: CommandContext, text: str) -> Reply:
        robot, _ = self._naming.robot(asked, "wait", text)
        shown = self._times.shown(robot)
        if not self._scheduler.keep(asked.caller.principal, robot):
            raise NotPermitted(words.not_yours_now(shown), offers=(f"wait {robot}",))
        return Reply(words.kept(shown))
