"""``/robot``: what one robot can do, and whether it takes part in the fleet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core import messages as core_words
from rosic.core.fleet import events as e
from rosic.core.fleet.task import FleetMembership
from rosic.core.language.suggestions import did_you_mean
from rosic.core.messages import no_robot
from rosic.core.policy.scope import FLEET, RESUME
from rosic.core.records import Decided
from rosic.errors import NotPermitted, NotUnderstood, RobotStopped
from rosic.features.fleet import messages
from rosic.features.fleet import robot_messages as words
from rosic.features.fleet.added_robot_messages import SUFFIXES
from rosic.features.fleet.task_commands import ASSIGN
from rosic.gateway.commands import Reply

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection

    from rosic.core.robot.profile import RobotId
    from rosic.errors import Refusal
    from rosic.features.fleet.dispatcher import TaskDispatcher
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.stop import StopLane

OUT: Final = {"disable": FleetMembership.DISABLED, "retire": FleetMembership.RETIRED}
NAMED_AT_MOST: Final = 5
IN: Final = frozenset({"enable", "add"})


class RobotCommands:
    """The handler of who takes part. Whoever does not is stopped, and nobody can resume it.

    Args:
        newcomer: Adds a robot that nobody knows yet, from a file; None: nobody does.
    """

    def __init__(
        self,
        rooms: Components,
        dispatching: TaskDispatcher,
        stop_lane: StopLane,
        newcomer: Callable[[CommandContext, str], Awaitable[Reply]] | None,
    ) -> None:
        self._newcomer = newcomer
        self._rooms = rooms
        self._dispatching = dispatching
        self._stop_lane = stop_lane

    def register(self, commands: CommandRegistry) -> None:
        """Take these commands."""
        commands.register("robot", self.robot)

    def barred(self, robot: RobotId) -> Refusal | None:
        """Return why a robot must stay stopped; None if it need not."""
        standing = self._dispatching.fleet.standing(robot)
        if standing is FleetMembership.ACTIVE:
            return None
        return RobotStopped(words.barred(self._rooms.profiles[robot].shown, standing))

    def begins(self, robots: Collection[RobotId]) -> str:
        """Return what robots that were resumed may begin by themselves; mostly nothing."""
        found = self._dispatching.fleet.beginning(robots)
        more = len(found) - NAMED_AT_MOST
        return messages.begins(found[:NAMED_AT_MOST], max(0, more)) if found else ""

    async def robot(self, asked: CommandContext) -> Reply:
        """Say what a robot can do, or let it take part or not.

        Raises:
            NotUnderstood: No such robot, or it is so already.
            NotPermitted: Not theirs to decide.
        """
        low = asked.rest.casefold().split()
        verb = low[0] if low else ""
        if self._rooms.vocabulary.robot(" ".join(low)) is None:
            verb = self._rooms.vocabulary.commands.verb("robot", verb)
        if self._newcomer is not None and verb == "add" and low[1:] and _is_file(low):
            return await self._newcomer(asked, asked.rest.strip()[len(low[0]) :])
        verb = verb if verb in OUT or verb in IN else ""
        robot = self._named(asked, " ".join(low[1:] if verb else low))
        if not verb:
            return self._about(robot)
        organiser, who = self._rooms.organiser, asked.caller.principal
        if not organiser.rights.holds(who, FLEET, ASSIGN, organiser.wall_ns()):
            raise NotPermitted(words.MAY_NOT)
        if verb in OUT:
            return await self._leaves(asked, robot, OUT[verb])
        return await self._joins(asked, robot, verb)

    def _named(self, asked: CommandContext, name: str) -> RobotId:
        visible = self._rooms.organiser.visible(asked.caller.principal)
        profile = self._rooms.vocabulary.robot(name)
        if not name:
            raise NotUnderstood(words.HOW_TO)
        if profile is None or profile.id not in visible:
            close = did_you_mean(name, sorted(visible))
            raise NotUnderstood(no_robot(name), offers=tuple(f"/robot {other}" for other in close))
        return profile.id

    def _about(self, robot: RobotId) -> Reply:
        can = core_words.help_for(self._rooms.profiles[robot])
        state = words.standing(self._dispatching.fleet.standing(robot))
        return Reply(words.about(can, state), about=robot)

    async def _leaves(
        self, asked: CommandContext, robot: RobotId, standing: FleetMembership
    ) -> Reply:
        """Stop a robot for good, and take its task from it."""
        fleet, shown = self._dispatching.fleet, self._rooms.profiles[robot].shown
        before = fleet.standing(robot)
        if before is standing or before is FleetMembership.RETIRED:
            raise NotUnderstood(words.is_out(shown, before))
        self._stop_lane.stop_robots((robot,), asked.caller.principal)  # waits for no disk
        await self._stand(asked, robot, standing)
        task = fleet.holds.get(robot, "")
        return Reply(words.left(shown, standing, task), about=robot)

    async def _joins(self, asked: CommandContext, robot: RobotId, verb: str) -> Reply:
        before, shown = self._dispatching.fleet.standing(robot), self._rooms.profiles[robot].shown
        if before is FleetMembership.ACTIVE:
            raise NotUnderstood(words.is_in(shown))
        if before is FleetMembership.RETIRED and verb != "add":
            raise NotUnderstood(words.is_retired(shown, robot), offers=(f"/robot add {robot}",))
        await self._stand(asked, robot, FleetMembership.ACTIVE)
        can = core_words.help_for(self._rooms.profiles[robot])
        text = words.about(words.joins(shown), can if verb == "add" else "")
        may = self._rooms.organiser.allows(asked.caller.principal, robot, RESUME)
        return Reply(text, words.resume_button(robot, shown) if may else (), about=robot)

    async def _stand(
        self, asked: CommandContext, robot: RobotId, standing: FleetMembership
    ) -> None:
        decided = Decided(
            act=f"robot-{standing.value}",
            by=asked.caller.principal,
            about=robot,
            at_ns=self._rooms.organiser.wall_ns(),
            digest=asked.cid,
        )
        out = standing is not FleetMembership.ACTIVE  # and that, too, waits for no disk
        await self._dispatching.feed(e.MembershipSet(robot, standing), decided, happened=out)


def _is_file(low: list[str]) -> bool:
    """Whether a profile is named rather than a robot."""
    return any(word.endswith(SUFFIXES) for word in low)
