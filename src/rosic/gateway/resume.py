"""Resume: a stop is undone only by somebody who may, explicitly, and on disk first."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core import messages
from rosic.core.i18n import joined, said
from rosic.core.identity import (
    OPERATOR,
    Address,
    Caller,
    CommandId,
    PrincipalId,
    command_id,
    robot_command_id,
)
from rosic.core.message import Button
from rosic.core.policy.scope import RESUME
from rosic.core.signal import Deferred
from rosic.core.time_units import SECOND_NS
from rosic.errors import (
    Expired,
    Fault,
    NotPermitted,
    NotUnderstood,
    RecordUnavailable,
    Refusal,
    RobotMoving,
    RobotOffline,
    RobotStopped,
    RobotUnreachable,
    StillMoves,
    TimeInDoubt,
)
from rosic.gateway.button_rows import rows
from rosic.gateway.requests import check_heard_in_time, is_said_to_us
from rosic.organiser.refusals import CLOCK_SET_BACK
from rosic.organiser.why_stopped import may_resume, stopped_own

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection, Mapping, Sequence

    from rosic.core.language import Resume
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.components import Components
    from rosic.gateway.message_context import MessageContext


OPERATING = Caller(OPERATOR, OPERATOR, Address(OPERATOR, ""), "", "")
"""Whoever runs this machine: they act under no key."""
RESUME_ALL = said("Resume all")
# As many as a line may name, and a page of buttons shows.
RESUMED_AT_MOST = 8
RESUME_LIFETIME_NS = 30 * SECOND_NS


class ResumeHandler:
    """Undoes stops.

    Attributes:
        begins: Returns what some robots may begin by themselves once they are resumed; mostly "".
            Whoever knows is made later; nothing is resumed until then (`StopRegistry.barred`).
    """

    def __init__(self, rooms: Components) -> None:
        self.begins: Deferred[[Collection[RobotId]], str] = Deferred(_nothing)
        self._organiser = rooms.organiser
        self._container = rooms.container
        self._linker = rooms.linker
        self._stops = rooms.stops

    async def resume(self, message: MessageContext, line: Resume, cid: CommandId) -> str:
        """Resume every robot of the line that is stopped. Return what to say.

        People say it to each other: in a group nothing goes on by it unless it is said to us or
        names a robot. What it could mean is offered then.

        Raises:
            RobotStopped: It was perhaps said to somebody else; offers to resume.
            NotPermitted: Not this person; no robot was resumed.
            NotUnderstood: Several are stopped, and it was not said which.
            Expired: It is backlog, too old, or was received before the stop it would undo: stops
                overtake, so an older resume can arrive after a younger stop (I5). Or its button was
                shown before that stop: whoever taps it does not know of it.
            TimeInDoubt: By the clock of this computer it came before the stop: that was set back.
            Repeated, RecordUnavailable, RobotOffline, RobotStopped: Robots not resumed so far stay
                stopped; the sentence says which were resumed before it came to this.
        """
        caller = message.caller
        stopped = self._stopped(caller, line)
        if stopped and not line.named and not is_said_to_us(message.inbound):
            raise self._organiser.why_stopped.refusal(caller.principal, stopped)
        for robot in stopped:
            self._check_may(message, robot)
            # Before the time is looked at: said again, it would be refused again.
            self._check_not_barred(robot)
            self._check_later(message, robot)
        # As they were when this was asked: what is stopped meanwhile stays stopped.
        generations = {robot: self._stops[robot].generation for robot in stopped}

        async def one(robot: RobotId, generation: int) -> None:
            robot_cid = robot_command_id(cid, robot)
            await self._container.resume(robot_cid, caller, robot, generation)
            try:
                self._check_may(message, robot)  # the right may have ended meanwhile
                await self._go_on(robot, generation)
            except Refusal:
                self._container.stays_stopped(robot_cid)
                raise

        told = await self._each(generations, one)
        spared = [self._linker.profile(r).shown for r in line.spared if self._stops[r].latched]
        return joined("\n", (told, messages.still_stopped(spared))) if spared else told

    async def by_operator(self, robots: Collection[RobotId], at_ns: int) -> str:
        """Resume robots for the operator of this machine, who asks no organiser, and on the record.

        Args:
            robots: Those that are stopped; others are left as they are.
            at_ns: Wall clock; the same stop may be asked about again, once it can be written.

        Raises:
            Refusal: What bars one, or it is not written: this one and those after it stay stopped,
                and the sentence says which went on.
        """
        generations = {r: self._stops[r].generation for r in robots if self._stops[r].latched}
        for robot in generations:
            self._check_not_barred(robot)

        async def one(robot: RobotId, generation: int) -> None:
            cid = command_id(OPERATOR, RESUME, robot, str(generation), str(at_ns))
            await self._container.resume(cid, OPERATING, robot, generation)
            try:
                await self._go_on(robot, generation)
            except Refusal:
                self._container.stays_stopped(cid)
                raise

        return await self._each(generations, one)

    async def _each(
        self,
        generations: Mapping[RobotId, int],
        resume: Callable[[RobotId, int], Awaitable[None]],
    ) -> str:
        """Resume one robot after another. Return what to say.

        Raises:
            Refusal: Of the first that stays stopped. Its sentence says which were resumed before,
                and which are left.
        """
        left = list(generations)
        done: list[RobotId] = []
        try:
            for robot, generation in generations.items():
                left.remove(robot)
                await resume(robot, generation)
                done.append(robot)
        except Refusal as why:
            if why.silent:
                raise  # the message came before: its first robots are the ones it resumed then
            others = [self._linker.profile(r).shown for r in left if self._stops[r].latched]
            parts = (self._told(done) if done else "", why.sentence, messages.still_stopped(others))
            why.reworded(joined("\n", filter(None, parts)))
            raise
        return self._told(done)

    async def _go_on(self, robot: RobotId, generation: int) -> None:
        """Let a robot go on whose resume is on disk.

        Raises:
            RobotMoving, RobotOffline, RecordUnavailable, RobotStopped: It stays stopped.
        """
        shown = self._linker.profile(robot).shown
        try:
            ready = await self._linker.resume(robot, generation)
        except Fault as fault:
            raise _refusal_of(fault)(
                said("{shown} stays stopped: {fault}", shown=shown, fault=fault.sentence)
            ) from fault
        if not ready:
            raise RobotStopped(
                said("{shown} was stopped again meanwhile. It stays stopped.", shown=shown)
            )

    def _told(self, stopped: Collection[RobotId]) -> str:
        if not stopped:
            return said("Nothing is stopped there.")
        text = messages.resumed([self._linker.profile(robot).shown for robot in stopped])
        return joined("\n", filter(None, (text, self.begins(stopped))))

    def _check_may(self, message: MessageContext, robot: RobotId) -> None:
        """See that somebody may resume a robot: by right, or as it was their own order's stop.

        What a resume wants of the conversation it wants of either.

        Raises:
            NotPermitted: They may not; the robot stays stopped.
        """
        auth_context = message.auth_context()
        try:
            self._organiser.check_word(message.caller, robot, RESUME, auth_context)
        except NotPermitted:
            own = stopped_own(self._organiser, self._stops, message.caller.principal, robot)
            least = self._organiser.rights.caution(robot, RESUME).assurance
            if not own or auth_context.channel < least:
                raise

    def may(self, principal: PrincipalId, robot: RobotId) -> bool:
        """Whether somebody could resume a robot now, for offering it."""
        if not self._stops[robot].latched or self._stops.barred(robot) is not None:
            return False
        return may_resume(self._organiser, self._stops, principal, robot)

    def warning(
        self, principal: PrincipalId, robots: Collection[RobotId]
    ) -> tuple[str, tuple[tuple[Button, ...], ...]]:
        """Return who has stopped which of some robots, and what resumes those; mostly nothing."""
        stopped = [robot for robot in robots if self._stops[robot].latched]
        if not stopped:
            return "", ()
        sentence = self._organiser.why_stopped.since(principal, stopped)
        return sentence, self.buttons([robot for robot in stopped if self.may(principal, robot)])

    def buttons(self, robots: Sequence[RobotId]) -> tuple[tuple[Button, ...], ...]:
        """Return a button for each of some stopped robots, and one for all of them."""
        if len(robots) > RESUMED_AT_MOST:
            return ((Button(RESUME_ALL, "resume all"),),)
        each = [
            Button(said("Resume {shown}", shown=self._linker.profile(r).shown), f"resume {r}")
            for r in robots
        ]
        together = Button(RESUME_ALL, " ".join(("resume", *robots)))
        return ((together,), *rows(each)) if len(each) > 1 else rows(each)

    def _check_not_barred(self, robot: RobotId) -> None:
        why = self._stops.barred(robot)
        if why is not None:
            raise why

    def _check_later(self, message: MessageContext, robot: RobotId) -> None:
        inbound = message.inbound
        check_heard_in_time(inbound, RESUME_LIFETIME_NS, f"resume {robot}")
        stopped_ns = self._stops[robot].at_ns
        if 0 < message.shown_ns < stopped_ns:
            again = said(
                "{shown} was stopped again since this was shown. It stays stopped.",
                shown=self._linker.profile(robot).shown,
            )
            raise Expired(again, offers=(f"resume {robot}",))
        # A platform may give whole seconds: within one, the order of receiving decides.
        if inbound.received_ns <= stopped_ns or inbound.sent_ns + SECOND_NS < stopped_ns:
            if self._organiser.in_doubt:
                raise TimeInDoubt(CLOCK_SET_BACK)
            shown = self._linker.profile(robot).shown
            raise Expired(
                said("{shown} was stopped after you sent this. It stays stopped.", shown=shown),
                offers=(f"resume {robot}",),
            )

    def _stopped(self, caller: Caller, line: Resume) -> list[RobotId]:
        visible = self._organiser.visible(caller.principal)
        stopped = [r for r in line.robots or sorted(visible) if self._stops[r].latched]
        if not line.robots and len(stopped) > 1:
            free = [robot for robot in stopped if self._stops.barred(robot) is None]
            if not free:
                self._check_not_barred(stopped[0])
            may = [robot for robot in free if self.may(caller.principal, robot)]
            offers = tuple(f"resume {robot}" for robot in may)
            raise NotUnderstood(
                said("Several robots are stopped. Say which one may go on."),
                offers=(*offers, "resume all") if len(offers) == len(stopped) else offers,
            )
        return stopped


def _refusal_of(fault: Fault) -> type[Refusal]:
    """Return what a program is told by its code: trying again helps where the record failed."""
    if isinstance(fault, StillMoves):
        return RobotMoving
    return RobotOffline if isinstance(fault, RobotUnreachable) else RecordUnavailable


def _nothing(_robots: Collection[RobotId]) -> str:
    return ""
