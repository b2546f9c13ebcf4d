"""What the operator of this machine may ask of a running gateway, without a chat.

They own the process and its data, so nothing here asks the organiser; everything that changes
something is on the record under `OPERATOR`.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Annotated, TypeVar

import msgspec

from rosic.app.added_robots import AddRobotRequest
from rosic.app.admin.access import (
    AccessAdmin,
    InviteParameters,
    ProgramParameters,
    RotateParameters,
)
from rosic.app.admin.api import ALL, AdminVerb
from rosic.app.admin.containers import ContainersAdmin, LimitParameters
from rosic.app.admin.explain import Explainer
from rosic.app.admin.history import HistoryParameters, history_of
from rosic.app.admin.naming import people_lines, people_listed
from rosic.app.admin.recording import RecordParameters, recording_for_operator
from rosic.app.admin.schedule import BookParameters, ScheduleAdmin, ScheduleWindow
from rosic.app.admin.verification import VerificationAdmin
from rosic.app.maintenance import lost
from rosic.config.profiles import known_units
from rosic.contracts.programs import AttachesPrograms
from rosic.core import messages
from rosic.core.i18n import joined, plain, said
from rosic.core.identity import OPERATOR
from rosic.core.order import RestReport
from rosic.core.policy.limits import unit_converter
from rosic.core.secret import Secret
from rosic.errors import NotUnderstood
from rosic.gateway.robot_registry import owner_may

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Iterator, Sequence
    from typing import TypeAlias

    from rosic.app.admin.api import AdminContext, AdminRequest
    from rosic.app.gateway import Gateway
    from rosic.contracts.programs import ServeConnection
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId


# ---- people and rights ----


if TYPE_CHECKING:
    Doing: TypeAlias = Callable[[AdminRequest], Awaitable[Iterable[str]]]

LINES_AT_ONCE = 500
ACCEPT = "accept"
NO_REQUEST = "That is no request I know."

T = TypeVar("T")

_encode = msgspec.json.Encoder(enc_hook=plain).encode


class AdminApi:
    """Answers each verb but those about robots' motion.

    Attributes:
        access: Who comes in, and whose access ends.
    """

    def __init__(self, books: AdminContext) -> None:
        self.access = AccessAdmin(books, unit_converter(known_units()))
        self._books = books
        self._planning = ScheduleAdmin(books)
        self._explaining = Explainer(books)
        self._containers = ContainersAdmin(books)
        self._doing: dict[AdminVerb, Doing] = {
            AdminVerb.PEOPLE: self._people,
            AdminVerb.REVOKE: self._to(self.access.revoke),
            AdminVerb.INVITE: self._invite,
            AdminVerb.KEYS: self._keys,
            AdminVerb.ROTATE: self._rotate,
            AdminVerb.CREATE_KEY: self._create_key,
            AdminVerb.TAKE_KEY: self._to(self.access.take_key),
            AdminVerb.LOCK: self._to(self.access.lock),
            AdminVerb.UNLOCK: self._to(self.access.unlock),
            AdminVerb.EXPLAIN: self._explain,
            AdminVerb.SECURITY: self._security,
            AdminVerb.WHO: self._who,
            AdminVerb.TAKEN: self._taken,
            AdminVerb.BOOK: self._book,
            AdminVerb.CLOCK: self._clock,
            AdminVerb.CONTAINERS: self._containers.list,
            AdminVerb.CONTAINER: self._containers.show,
            AdminVerb.CONTENT: self._containers.content,
            AdminVerb.LIMIT: self._limit,
            AdminVerb.ERASE: self._containers.erase,
            AdminVerb.HISTORY: self._history,
            AdminVerb.VERIFY: VerificationAdmin(books).do,
        }

    async def do(self, ask: AdminRequest) -> Iterable[str]:
        """Do what is asked, and return the answers.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        doing = self._doing.get(ask.verb)
        if doing is None:
            raise NotUnderstood(NO_REQUEST)
        return await doing(ask)

    def _to(self, act: Callable[[str], Awaitable[str]]) -> Doing:
        async def doing(ask: AdminRequest) -> Iterable[str]:
            return (await act(" ".join(ask.names)),)

        return doing

    async def _people(self, ask: AdminRequest) -> Iterable[str]:
        if ask.wants_json:
            return _lists(people_listed(self._books))
        return _together(people_lines(self._books) or ("Nobody is known yet.",))

    async def _invite(self, ask: AdminRequest) -> Iterable[str]:
        return await self.access.invite(body_of(ask, InviteParameters))

    async def _keys(self, ask: AdminRequest) -> Iterable[str]:
        if ask.wants_json:
            return _lists(self.access.keys_listed(ask.names))
        return _together(self.access.keys(ask.names))

    async def _create_key(self, ask: AdminRequest) -> Iterable[str]:
        return (await self.access.create_program(body_of(ask, ProgramParameters)),)

    async def _rotate(self, ask: AdminRequest) -> Iterable[str]:
        return (await self.access.rotate(" ".join(ask.names), body_of(ask, RotateParameters)),)

    async def _explain(self, ask: AdminRequest) -> Iterable[str]:
        if len(ask.names) != 2:  # noqa: PLR2004 - a person and a line
            raise NotUnderstood(NO_REQUEST)
        return self._explaining.explain(*ask.names)

    async def _security(self, ask: AdminRequest) -> Iterable[str]:
        security = self._books.access.security
        if ask.names == ("json",):
            return (_encode(security.report()).decode(),)
        return (security.text(),)

    async def _clock(self, ask: AdminRequest) -> Iterable[str]:
        if ask.names not in {(), (ACCEPT,)}:
            raise NotUnderstood(NO_REQUEST)
        return (await self.access.clock(accept=ask.names == (ACCEPT,)),)

    async def _who(self, _ask: AdminRequest) -> Iterable[str]:
        return (_encode(some).decode() for some in self._planning.who())

    async def _taken(self, ask: AdminRequest) -> Iterable[str]:
        found = self._planning.taken(body_of(ask, ScheduleWindow))
        return (_encode(some).decode() for some in found)

    async def _book(self, ask: AdminRequest) -> Iterable[str]:
        return (await self._planning.book(body_of(ask, BookParameters)),)

    async def _history(self, ask: AdminRequest) -> Iterable[str]:
        return await history_of(self._books, body_of(ask, HistoryParameters))

    async def _limit(self, ask: AdminRequest) -> Iterable[str]:
        return await self._containers.limit(ask, body_of(ask, LimitParameters))


def _together(lines: Sequence[str]) -> Iterator[str]:
    """Yield lines, many at a time: one answer has a longest size."""
    for at in range(0, len(lines), LINES_AT_ONCE):
        yield "\n".join(lines[at : at + LINES_AT_ONCE])


def _lists(listed: Sequence[object]) -> Iterator[str]:
    """Yield lists for programs, at least one."""
    for at in range(0, max(1, len(listed)), LINES_AT_ONCE):
        yield _encode(listed[at : at + LINES_AT_ONCE]).decode()


def body_of(ask: AdminRequest, kind: type[T]) -> T:
    """Return what else a verb asks for.

    Raises:
        NotUnderstood: It is something else.
    """
    try:
        return msgspec.json.decode(ask.body, type=kind)
    except msgspec.MsgspecError as error:
        raise NotUnderstood(NO_REQUEST) from error


# ---- everything the operator may ask ----

NO_PROGRAMS = (
    'This gateway serves no programs. Add [[messenger]] with kind = "mcp" to its configuration, '
    "and start it again."
)
NOT_KEPT = said("This could not be written down: after a restart, look before you move anything.")


class AttachParameters(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Who wants to speak over this connection: the secret of a program's key."""

    secret: Annotated[str, msgspec.Meta(min_length=1, max_length=256)]


class AdminDispatcher:
    """Answers requests of the operator from one running gateway.

    Args:
        gateway: Open.
        admin: Answers about people and their rights; None: nobody does.
    """

    def __init__(self, gateway: Gateway, admin: AdminApi | None = None) -> None:
        self._gateway = gateway
        self._admin = admin

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
        stopped = rooms.stops[robot]
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
        presence, stopped = rooms.linker.presence(robot), rooms.stops[robot]
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
            "ages_s": {name: presence.ages_s.get(name) for name in presence.values},
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
            RestReport(robot, confirmed=False, seconds=0.0) if rest.exception() else rest.result()
            for robot, rest in halting.rests.items()
        ]
        yield messages.rests(rooms.profiles, found)
        if not await halting.kept(self._gateway.access.time):
            yield NOT_KEPT

    async def resume(self, names: Sequence[str] = ()) -> str:
        """Undo the stop of robots; without a name, of the one that is stopped.

        Raises:
            NotUnderstood: No such robot, or several are stopped and none was named.
            Refusal: Why a robot stays stopped; those before it in the row go on.
        """
        rooms = self._gateway.rooms
        named = self._robots([name for name in names if name != ALL])
        stopped = [robot for robot in named if rooms.stops[robot].latched]
        if not names and len(stopped) > 1:
            listed = ", ".join(stopped)
            raise NotUnderstood(
                f"Several robots are stopped: {listed}. Name those that may go on, or say {ALL}."
            )
        at_ns = self._gateway.access.time.wall_ns()
        return await self._gateway.pipeline.resuming.by_operator(stopped, at_ns)

    def attach(self, ask: AdminRequest) -> ServeConnection:
        """Return what serves a program, or sends a recording, over the connection that asked.

        Raises:
            NotUnderstood: This gateway has no messenger for programs; or there is no such robot.
            Unrecognised: It shows no secret of a good key.
            NotPermitted, TooManyRequests: Nothing can be recorded here now.
        """
        if ask.verb is AdminVerb.RECORD:
            asked = body_of(ask, RecordParameters)
            return recording_for_operator(self._gateway, self._robots(ask.names), asked)
        secret = Secret(body_of(ask, AttachParameters).secret)
        for messenger in self._gateway.kernel.reach.messengers:
            if isinstance(messenger, AttachesPrograms):
                return messenger.attach(secret)
        raise NotUnderstood(NO_PROGRAMS)

    async def do(self, ask: AdminRequest) -> Iterable[str]:
        """Do what is asked about people and their rights, and return the answers.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        if ask.verb is AdminVerb.ADD_ROBOT:
            wanted = body_of(ask, AddRobotRequest)
            adder = self._gateway.robot_adder
            return (await adder.add(wanted.draft, OPERATOR, owner_may, wanted.role),)
        if ask.verb is AdminVerb.RESUME:
            return (await self.resume(ask.names),)
        if self._admin is None:
            raise NotUnderstood("Nobody answers that here.")
        return await self._admin.do(ask)
