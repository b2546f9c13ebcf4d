"""What the operator of this machine may ask of a running gateway, without a chat.

They own the process and its data, so nothing here asks the organiser; everything that changes
something is on the record under `OPERATOR`.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import msgspec

from rosic.app.added_robots import Wanted
from rosic.app.admin.asked import Verb
from rosic.app.admin.operator_desk import body_of
from rosic.app.record_monitor import lost
from rosic.core import messages
from rosic.core.i18n import joined, plain, said
from rosic.core.identity import OPERATOR
from rosic.core.order import Rest
from rosic.errors import NotUnderstood

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterable, Sequence

    from rosic.app.admin.asked import Ask
    from rosic.app.admin.operator_desk import AdminApi
    from rosic.app.gateway import Gateway
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId


ALL = "--all"
NOT_KEPT = said("This could not be written down: after a restart, look before you move anything.")

_encode = msgspec.json.Encoder(enc_hook=plain).encode


class AdminDispatcher:
    """One running gateway.

    Args:
        gateway: Open.
        desk: Answers about people and their rights; None: nobody does.
    """

    def __init__(self, gateway: Gateway, desk: AdminApi | None = None) -> None:
        self._gateway = gateway
        self._desk = desk

    def status(self, names: Sequence[str] = ()) -> tuple[str, ...]:
        """Return a line for each robot, after what keeps all of them from moving.

        Raises:
            NotUnderstood: There is no robot and no group of that name.
        """
        file = self._gateway.record_watch.lost_file()
        first = (str(lost(file)),) if file else ()
        return (*first, *(self._status(robot) for robot in self._robots(names)))

    def _status(self, robot: RobotId) -> str:
        rooms = self._gateway.rooms
        holder = rooms.organiser.whose(robot)
        stopped = rooms.board[robot]
        name_of = rooms.organiser.name_of
        by = (name_of(stopped.by) if stopped.by else "") if stopped.latched else None
        return messages.status_line(
            rooms.profiles[robot],
            rooms.linker.presence(robot),
            holder=name_of(holder) if holder else "",
            stopped_by=by,
            waiting=rooms.linker.waiting(robot),
        )

    def status_json(self, names: Sequence[str] = ()) -> str:
        """Return one list, for programs: what `status` says, robot by robot.

        Raises:
            NotUnderstood: As `status`.
        """
        return _encode([self._state(robot) for robot in self._robots(names)]).decode()

    def _state(self, robot: RobotId) -> dict[str, object]:
        rooms = self._gateway.rooms
        presence, stopped = rooms.linker.presence(robot), rooms.board[robot]
        holder = rooms.organiser.whose(robot)
        return {
            "robot": robot,
            "shown": rooms.profiles[robot].shown,
            "online": presence.online,
            "heard_s_ago": presence.age_s,
            "at_rest": presence.at_rest,
            "doing": presence.doing,
            "stopped": stopped.latched,
            "stopped_by": (stopped.by or None) if stopped.latched else None,
            "holder": holder or None,
            "waiting": rooms.linker.waiting(robot),
            "values": presence.values,
        }

    def _robots(self, names: Sequence[str]) -> tuple[RobotId, ...]:
        rooms = self._gateway.rooms
        if not names:
            return tuple(rooms.profiles)
        found: dict[RobotId, None] = {}
        for name in names:
            robot = rooms.vocabulary.robot(name)
            members = (robot.id,) if robot is not None else rooms.vocabulary.members(name)
            if not members:
                known = ", ".join(rooms.vocabulary.names)
                raise NotUnderstood(f"There is no robot called {name}. There are: {known}.")
            found.update(dict.fromkeys(members))
        return tuple(found)

    async def stop(
        self, names: Sequence[str] = (), *, by: PrincipalId = OPERATOR
    ) -> AsyncIterator[str]:
        """Stop robots at once; yield what was done, then what was measured.

        A name that nobody knows stops everything, as in a chat.

        Args:
            names: Robots and groups; none: every robot.
            by: Who is said to have stopped them.
        """
        rooms = self._gateway.rooms
        misheard = ""
        try:
            robots = self._robots(names)
        except NotUnderstood as unknown:
            robots = tuple(rooms.profiles)
            misheard = f"{unknown} Everything is stopped.\n"
        halting = self._gateway.stop_lane.stop_robots(robots, by)
        yield joined("", (misheard, messages.stopping([rooms.profiles[r].shown for r in robots])))
        # Waiting is all that may be cut off when whoever asked goes away; the stop goes on.
        await asyncio.wait(halting.rests.values())
        found = [
            Rest(robot, confirmed=False, seconds=0.0) if rest.exception() else rest.result()
            for robot, rest in halting.rests.items()
        ]
        yield messages.rests(rooms.profiles, found)
        if not await asyncio.shield(halting.latched):
            yield NOT_KEPT

    async def resume(self, names: Sequence[str] = ()) -> str:
        """Undo the stop of robots; without a name, of the one that is stopped.

        Raises:
            NotUnderstood: No such robot, or several are stopped and none was named.
            Refusal: Why a robot stays stopped; those before it in the row go on.
        """
        rooms = self._gateway.rooms
        named = self._robots([name for name in names if name != ALL])
        stopped = [robot for robot in named if rooms.board[robot].latched]
        if not names and len(stopped) > 1:
            listed = ", ".join(stopped)
            raise NotUnderstood(
                f"Several robots are stopped: {listed}. Name those that may go on, or say {ALL}."
            )
        at_ns = self._gateway.access.time.wall_ns()
        return await self._gateway.pipeline.resuming.by_operator(stopped, at_ns)

    async def do(self, ask: Ask) -> Iterable[str]:
        """Do what is asked about people and their rights, and return the answers.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        if ask.verb is Verb.ADD_ROBOT:
            wanted = body_of(ask, Wanted)
            return (await self._gateway.enlisting.add(wanted.draft, OPERATOR, wanted.role),)
        if ask.verb is Verb.RESUME:
            return (await self.resume(ask.names),)
        if self._desk is None:
            raise NotUnderstood("Nobody answers that here.")
        return await self._desk.do(ask)
