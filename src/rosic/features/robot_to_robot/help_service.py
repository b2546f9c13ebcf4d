"""Carries requests for help: to whoever may help, to whoever keeps tasks, and to who is told."""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined
from rosic.core.identity import TYPED_ID_BYTES
from rosic.core.language import clean
from rosic.core.message import Button
from rosic.core.policy.scope import ASK, HELP
from rosic.core.rate_limit import Bucket, RateLimit
from rosic.core.time_units import DAY_S
from rosic.errors import NotPermitted, TooManyRequests
from rosic.features.robot_to_robot import messages as words

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.robot import RobotTasks
    from rosic.core.identity import Caller, PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.robot_to_robot.context import RobotToRobotContext
    from rosic.features.robot_to_robot.help_requests import HelpRequest, HelpRequests

TASKS_WITHIN_S: Final = 10.0
SENT_AT_MOST: Final = 2
# People are called by each request; a robot that cries wolf is not heard any more.
CALLS: Final = RateLimit(burst=6.0, per_s=1 / 60)

log = logging.getLogger("rosic.robot_to_robot")


class HelpService:
    """Asks, accepts, and tells.

    Attributes:
        book: Every request.
        tasks: Returns who adjusts the tasks of both robots; None: nobody keeps tasks here.
    """

    def __init__(
        self,
        book: HelpRequests,
        around: RobotToRobotContext,
        tasks: Callable[[], RobotTasks | None],
    ) -> None:
        self.book = book
        self.tasks = tasks
        self._rights = around.rights
        self._rooms = around.rooms
        self._changes = around.changes
        self._reach = around.reach
        self._post = around.post
        self._entropy = around.entropy
        self._clock = around.clock
        self._calls: dict[RobotId, Bucket] = {}

    # ---- asking ----

    async def ask(self, caller: Caller, robot: RobotId, what: str, for_s: float) -> HelpRequest:
        """A robot asks for help; whoever may help hears of it. The same again is no other request.

        Raises:
            NotPermitted: It may not ask.
            TooManyRequests: It asks for as much as it may at once.
            RecordUnavailable: Not written; nobody was told.
        """
        self._rights.check(caller, robot, ASK)
        what = " ".join(clean(what).split())
        async with self._changes.turn() as turn:
            same = self.book.same(robot, what)
            if same is not None:
                return same
            self._charge(robot)
            ident = self._entropy.token(TYPED_ID_BYTES).hex()
            made, fact = self.book.ask(ident, robot, what, for_s)
            await turn.write((fact,))
        self._tell_robots(made)
        async for who in self._rights.helpers(robot):
            self._offer(made, who)
        return made

    def _charge(self, robot: RobotId) -> None:
        """See that a robot does not call people together all the time.

        Raises:
            TooManyRequests: It does.
        """
        now_ns = self._clock.monotonic_ns()
        wait_s = self._calls.setdefault(robot, Bucket(CALLS, now_ns)).take(now_ns)
        if wait_s:
            raise TooManyRequests(words.calls_often(), retry_after_s=wait_s)

    def _tell_robots(self, made: HelpRequest) -> None:
        for other in self._rights.robots():
            if other != made.robot and self._rights.robot_may(other, made.robot, HELP):
                self._post.send(
                    other,
                    {
                        "kind": "help",
                        "id": made.id,
                        "from": made.robot,
                        "what": made.what,
                        "until_s": made.until_ns / 1e9,
                    },
                )

    def _offer(self, made: HelpRequest, who: PrincipalId) -> None:
        until = self._rooms.organiser.moment(who, made.until_ns)
        text = words.asks_for_help(self._rights.shown(made.robot), made.what, until)
        lives_s = min(float(DAY_S), (made.until_ns - made.at_ns) / 1e9)
        self._reach.tell((who,), text, self.buttons(made, who), lifetime_s=lives_s)

    def buttons(self, made: HelpRequest, who: PrincipalId) -> tuple[tuple[Button, ...], ...]:
        """Return what somebody taps to help: themselves, or by a robot that is free."""
        row = [Button(words.i_help(), f"/assist {made.id}")]
        for robot in sorted(self._rooms.profiles):
            if len(row) > SENT_AT_MOST:
                break
            presence = self._rooms.linker.presence(robot)
            free = presence.online is not False and not presence.doing
            free = free and not self._rooms.stops[robot].latched  # it could not go
            if robot != made.robot and free and self._rights.operates(who, robot):
                row.append(
                    Button(words.send(self._rights.shown(robot)), f"/assist {made.id} {robot}")
                )
        return (tuple(row),)

    # ---- accepting ----

    async def accept(self, caller: Caller, ident: str, helper: RobotId = "") -> str:
        """Somebody helps: durable, once, then the tasks of both are adjusted and people told.

        Args:
            caller: A person, or the robot that helps.
            ident: Of the request.
            helper: The robot that helps; empty where a person does so themselves.

        Returns:
            What was done.

        Raises:
            NotUnderstood, Expired: There is no such request, it was accepted, or is over.
            NotPermitted: They may not help this robot, or not send that one.
            RecordUnavailable: Not written; nobody has accepted it.
        """
        who = caller.principal
        self._rights.check(caller, self.book.find(ident).robot, HELP)
        if helper and not self._is(caller, helper) and not self._rights.operates(who, helper):
            raise NotPermitted(words.may_not_send(self._rights.shown(helper)))
        async with self._changes.turn() as turn:
            named = partial(self._rights.name_for, caller)
            await turn.write(self.book.accept(ident, who, helper, named))
        made = self.book.find(ident)
        changed = await self._adjust(made)
        asker, name = self._rights.shown(made.robot), self._rooms.organiser.name_of(who)
        shown = self._rights.shown(helper) if helper else ""
        by = shown if helper and self._is(caller, helper) else name
        text = joined("\n", (words.helped(asker, made.what, by, shown), changed))
        await self._tell(made, text, besides=who)
        self._post.send(made.robot, {"kind": "helped", "id": ident, "by": helper or "a person"})
        if helper and not self._is(caller, helper):
            self._post.send(
                helper, {"kind": "assigned", "id": ident, "to": made.robot, "what": made.what}
            )
        return text

    def _is(self, caller: Caller, robot: RobotId) -> bool:
        return self._rights.principal(robot) == caller.principal

    async def _adjust(self, made: HelpRequest) -> str:
        tasks = self.tasks()
        if tasks is None:
            return words.no_tasks()
        try:
            async with asyncio.timeout(TASKS_WITHIN_S):
                return await tasks.helped(made.helper, made.robot) or words.no_tasks()
        except Exception:
            log.exception("the tasks of a robot that helps could not be adjusted")
            return words.tasks_failed()

    # ---- ending ----

    async def end(self, caller: Caller, ident: str) -> str:
        """The help was given, or is not needed any more.

        Raises:
            NotUnderstood: There is no such request.
            NotPermitted: It is theirs who asked, who helps, or who operates the robot.
            RecordUnavailable: Not written.
        """
        made = self.book.find(ident)
        who = caller.principal
        theirs = who == made.by or self._is(caller, made.robot)
        if not theirs and not self._rights.operates(who, made.robot):
            raise NotPermitted(words.may_not_help(self._rights.shown(made.robot)))
        text = words.help_ended(self._rights.shown(made.robot), made.what)
        if await self._end(made):
            await self._tell(made, text, besides=who)
        return text

    async def _end(self, made: HelpRequest) -> bool:
        async with self._changes.turn() as turn:
            fact = self.book.end(made.id)
            if fact is None:
                return False
            await turn.write((fact,))
        self._post.send(made.robot, {"kind": "over", "id": made.id})
        if made.helper:
            self._post.send(made.helper, {"kind": "over", "id": made.id})
        return True

    async def look(self, wall_ns: int) -> None:
        """End what nobody has accepted in time, and say so; forget what is long over."""
        for made in self.book.late(wall_ns):
            if await self._end(made):
                await self._tell(
                    made, words.help_expired(self._rights.shown(made.robot), made.what)
                )
        old = self.book.forgotten()
        if old:
            async with self._changes.turn() as turn:
                await turn.write(old)

    async def _tell(self, made: HelpRequest, text: str, *, besides: PrincipalId = "") -> None:
        robots = (made.robot, made.helper) if made.helper else (made.robot,)
        async for who in self._rights.operators(*robots, or_helpers_of=made.robot):
            if who != besides:
                self._reach.tell((who,), text)
