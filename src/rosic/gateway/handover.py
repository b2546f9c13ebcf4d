"""A robot passes from one person to the next: what moves ends first, and rest is measured."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said
from rosic.core.language.suggestions import AND
from rosic.core.message import Button
from rosic.core.messages import no_robot
from rosic.core.policy.scope import FLEET
from rosic.errors import NotPermitted, NotUnderstood, RobotBusy
from rosic.gateway.commands import Reply
from rosic.gateway.rest_wait import comes_to_rest

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.order_execution import OrderExecutor
    from rosic.gateway.stop import StopLane


class LeaseHandover:
    """Ends somebody's time with a robot without latching it for whoever comes next.

    What does not come to rest by itself is stopped, and stays stopped.
    """

    def __init__(
        self,
        rooms: Components,
        executor: OrderExecutor,
        stop_lane: StopLane,
        reach: Notifier,
        clock: Clock,
    ) -> None:
        self._rooms = rooms
        self._executor = executor
        self._stop_lane = stop_lane
        self._reach = reach
        self._clock = clock

    async def end(self, robot: RobotId, reason: str) -> bool:
        """End what a robot does for its holder and give it back.

        Args:
            robot: Which.
            reason: Why, as it stands in the outcome: ``your time is over``.

        Returns:
            Whether it was measured at rest, or its side cannot say; if not, it was stopped, and
            stays stopped until somebody resumes it.
        """
        linker, organiser = self._rooms.linker, self._rooms.organiser
        await self._executor.cut(robot, reason)
        rests = await comes_to_rest(linker, self._clock, robot)
        if not rests:
            self._stop_lane.stop_robots((robot,), "")
        organiser.release(robot)
        return rests

    async def take(self, asked: CommandContext) -> Reply:
        """Take a robot over from somebody of a lower role: ``take over omni``.

        Raises:
            NotUnderstood: No such robot, or nobody has it.
            NotPermitted: Not from them.
            RobotBusy: It did not come to rest; it is stopped now.
        """
        robot = self._robot(asked)
        shown = self._rooms.linker.profile(robot).shown
        who = asked.caller.principal
        others = [p for p in self._in_the_way(robot) if p != who]
        if not others:
            raise NotUnderstood(said("{shown} is free. Say what it should do.", shown=shown))
        if not all(self.outranks(who, other, robot) for other in others):
            names = joined(said(" and "), map(self._rooms.organiser.name_of, others))
            raise NotPermitted(
                said(
                    "{robot} is {names}'s now, and not yours to take over. Wait for it, and I tell "
                    "you when it is free.",
                    robot=shown,
                    names=names,
                ),
                offers=(f"wait {robot}",),
            )
        name = asked.caller.name
        self._reach.tell(
            others, said("{name} takes {shown} over now.", name=name, shown=shown), urgent=True
        )
        if not await self.end(robot, said("{name} took it over", name=name)):
            raise RobotBusy(
                said(
                    "{shown} has not come to rest. It is stopped; look before you resume it.",
                    shown=shown,
                )
            )
        self._rooms.organiser.yielded(robot, who)
        return Reply(
            said(
                "{shown} is yours now. {names} was told.",
                shown=shown,
                names=joined(AND, map(self._name, others)),
            )
        )

    async def give_back(self, asked: CommandContext) -> Reply:
        """End one's own time with a robot, or somebody's, for whoever looks after the place.

        Raises:
            NotUnderstood: No such robot, or nobody has it.
            NotPermitted: It is somebody else's.
            RobotBusy: It did not come to rest; it is stopped now.
        """
        robot = self._named(asked.rest.strip(), asked)
        shown = self._rooms.linker.profile(robot).shown
        organiser, who = self._rooms.organiser, asked.caller.principal
        holder = organiser.holder(robot)
        if holder is None and organiser.whose(robot) == who:
            return self._ended(robot, shown, who)
        if holder is None:
            raise NotUnderstood(said("Nobody has {shown}.", shown=shown))
        if holder != who and not organiser.rights.holds(who, FLEET, "slots", organiser.wall_ns()):
            raise NotPermitted(
                said(
                    "{robot} is {name}'s now. They can end that, or an admin. Wait for it, and I "
                    "tell you when it is free.",
                    robot=shown,
                    name=self._name(holder),
                ),
                offers=(f"wait {robot}",),
            )
        if not await self.end(robot, said("{name} ended the session", name=asked.caller.name)):
            raise RobotBusy(
                said(
                    "{shown} has not come to rest. It is stopped; look before you resume it.",
                    shown=shown,
                )
            )
        if holder != who:
            self._reach.tell(
                (holder,),
                said("{name} ended your time with {shown}.", name=asked.caller.name, shown=shown),
            )
        return self._ended(robot, shown, who)

    def _ended(self, robot: RobotId, shown: str, who: PrincipalId) -> Reply:
        """Return that a session was ended; and whose time with the robot goes on, if it does."""
        organiser = self._rooms.organiser
        owner, now_ns = organiser.whose(robot), organiser.wall_ns()
        slot = None if owner is None else organiser.calendar.present(robot, now_ns)
        if owner is None or slot is None or slot.principal != owner:
            return Reply(said("Session ended. {shown} is at rest, and free.", shown=shown))
        until = organiser.moment(who, slot.end_ns)
        text = (
            said(
                "Session ended. {shown} is at rest, and yours until {until}.",
                shown=shown,
                until=until,
            )
            if owner == who
            else said(
                "Session ended. {shown} is at rest, and {name}'s until {until}.",
                shown=shown,
                name=self._name(owner),
                until=until,
            )
        )
        return Reply(text, ((Button(said("Give that time back"), f"/cancel booking {slot.id}"),),))

    def _name(self, principal: PrincipalId) -> str:
        return self._rooms.organiser.name_of(principal)

    def _robot(self, asked: CommandContext) -> RobotId:
        words = asked.rest.split()
        return self._named(" ".join(words[1:] if words[:1] == ["over"] else words), asked)

    def _named(self, named: str, asked: CommandContext) -> RobotId:
        robot = named.casefold()
        if robot not in self._rooms.organiser.visible(asked.caller.principal):
            raise NotUnderstood(no_robot(named))
        return robot

    def _in_the_way(self, robot: RobotId) -> list[PrincipalId]:
        organiser = self._rooms.organiser
        slot = organiser.calendar.present(robot, organiser.wall_ns())
        found = [organiser.holder(robot), slot.principal if slot is not None else None]
        return list(dict.fromkeys(p for p in found if p is not None))

    def outranks(self, who: PrincipalId, other: PrincipalId, robot: RobotId) -> bool:
        """Whether somebody may take a robot over from somebody else, by the rules of the place."""
        organiser = self._rooms.organiser
        rights, now_ns = organiser.rights, organiser.wall_ns()
        return rights.may_take_over(robot) and rights.priority(
            who, robot, now_ns
        ) > rights.priority(other, robot, now_ns)
