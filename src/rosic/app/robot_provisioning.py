"""Adds a robot to a gateway that runs: all rooms know it from one turn of the event loop on.

First everything that can fail: the profile is read, the adapter is made and opened. Then the
decision is written down. Then the robot exists: for stops, for rights, for what people say.
"""

from __future__ import annotations

import asyncio
import logging
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from rosic.app.added_robots import KIND, AddRobotRequest, check_distinct, check_draft, fact_of
from rosic.app.people import ConfiguredPerson, admitted
from rosic.app.robot_startup import stops_of
from rosic.config.plugins import demand_good
from rosic.contracts.background_tasks import BackgroundTasks
from rosic.contracts.robot import PeerRobot
from rosic.core import messages as core_words
from rosic.core.fleet.task import FleetMembership
from rosic.core.i18n import capital, joined
from rosic.core.identity import ROBOT, Address
from rosic.core.language import Vocabulary
from rosic.core.order_gate import OrderGate
from rosic.core.records import Decided
from rosic.errors import ConfigurationError, NotUnderstood, RosicError
from rosic.features.alerts.evaluator import read_rules
from rosic.features.fleet import FleetFeature, robot_messages
from rosic.features.fleet import added_robot_messages as words
from rosic.features.robot_to_robot import RobotToRobotFeature
from rosic.gateway.robot_registry import AddedRobot

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rosic.app.gateway_parts import RunningGateway
    from rosic.app.settings import GatewayParts
    from rosic.contracts.robot import Robot
    from rosic.core.identity import PrincipalId
    from rosic.core.records import Memory, Record
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.gateway.policy_service import PolicyPreview
    from rosic.gateway.robot_registry import ProfileDraft

OPENS_WITHIN_S = 30.0
CLOSES_WITHIN_S = 0.5

log = logging.getLogger("rosic.fleet")


class PendingRobot(NamedTuple):
    """A robot of which everything is made that can fail, and that nobody knows yet.

    Attributes:
        vocabulary: Everything that can be said once it is here.
    """

    profile: Profile
    robot: Robot
    vocabulary: Vocabulary


class RobotProvisioning:
    """Makes and opens robots for one gateway, one after another, and adds them to its registry.

    Args:
        gateway: Its rooms and features are set up.
        parts: Its own.
        memory: Says how far robots got that an earlier run knew (I13).
        says: Brings what a robot says of its own accord to people.
    """

    def __init__(
        self,
        gateway: RunningGateway,
        parts: GatewayParts,
        memory: Memory,
        says: Callable[[Profile, str], None],
    ) -> None:
        self._gateway = gateway
        self._parts = parts
        self._numbers = dict(memory.numbers)
        self._stops = stops_of(parts.latch.read(), memory.generations)
        self._says = says
        self._one = asyncio.Lock()
        self._adding: BackgroundTasks[str] = BackgroundTasks()
        self._closing = False
        gateway.access.changes.keep(KIND, lambda _fact: None)  # its effect follows: `_add_robot`

    async def add(
        self,
        draft: ProfileDraft,
        by: PrincipalId,
        check_right: Callable[[], None],
        role: str = "",
    ) -> str:
        """Add a robot. Return what is said of it: that it is here, and what it can do.

        Whoever asked may go away; it goes on.

        Args:
            draft: Its profile.
            by: Who adds it.
            check_right: Raises while they may not; asked again right before it is written down.
            role: In which it speaks with the other robots, under a key of its own; empty: it does
                not.

        Raises:
            Refusal: Why not. Nothing was changed, and whatever was opened is closed.
        """
        if self._closing:
            raise NotUnderstood(words.CLOSING)
        task = self._adding.begin(self._add(AddRobotRequest(draft, role), by, check_right))
        return await asyncio.shield(task)

    async def check(self, draft: ProfileDraft, role: str = "") -> tuple[Profile, Sequence[str]]:
        """Return the robot of a profile that nobody would take for another, and advice about it.

        Args:
            draft: Its profile.
            role: In which it is to speak with the other robots; empty: it does not.

        Raises:
            NotUnderstood: Everything that is wrong with it, or whom it would be taken for; or it
                cannot become somebody in that role.
        """
        profile, advice = await asyncio.to_thread(check_draft, draft, self._parts.units)
        rooms = self._gateway.rooms
        if (
            profile.id in rooms.profiles
            and self._standing(profile.id) is not FleetMembership.ACTIVE
        ):
            raise NotUnderstood(words.retired_id(profile.id))
        check_distinct(profile, rooms.profiles.values())
        self._check_role(profile, role)
        return profile, advice

    def _standing(self, robot: str) -> FleetMembership:
        return self._gateway.features.get(FleetFeature).dispatching.fleet.standing(robot)

    async def close(self) -> None:
        """Add nobody any more. What is on the record is added by the next start."""
        self._closing = True
        for task in self._adding:
            task.cancel()
        if self._adding:
            await asyncio.wait(tuple(self._adding), timeout=CLOSES_WITHIN_S)

    # ---- what can fail ----

    async def _add(
        self, wanted: AddRobotRequest, by: PrincipalId, check_right: Callable[[], None]
    ) -> str:
        async with self._one:
            stops, _ = self._gateway.rooms.stops.newest()
            profile, advice = await self.check(wanted.draft, wanted.role)
            newcomer = await self._make(profile)
            await self._open(newcomer.robot)
            stopped = await self._decide(newcomer, wanted, by, stops, check_right)
        log.info("%s was added", profile.id)
        speaks = (words.speaks(profile.shown, wanted.role),) if wanted.role else ()
        return self._answer(profile, (*speaks, *advice), stopped=stopped)

    def _check_role(self, profile: Profile, role: str) -> None:
        """See that a robot can become somebody.

        Raises:
            NotUnderstood: There is no such role, or it or somebody of its name is known already.
        """
        if not role:
            return
        known = self._gateway.authority.rolebook.rulebook.roles
        if role not in known:
            raise NotUnderstood(words.no_role(role, sorted(known)))
        directory = self._gateway.rooms.authoriser.directory
        if directory.at(Address(ROBOT, profile.id)) or directory.named(profile.id):
            raise NotUnderstood(words.is_somebody(profile.id))

    def _somebody(self, robot: RobotId, role: str, by: PrincipalId) -> list[Record]:
        """Return what gives a robot a key of its own and a role; nothing without one."""
        if not role:
            return []
        peer = ConfiguredPerson(robot, (Address(ROBOT, robot),), (role,))
        return admitted(peer, self._gateway.access.time, self._parts.entropy, by)[2]

    async def _decide(
        self,
        newcomer: PendingRobot,
        wanted: AddRobotRequest,
        by: PrincipalId,
        stops: int,
        check_right: Callable[[], None],
    ) -> bool:
        """Write it down, then let it be so. Return whether it was stopped at once.

        Raises:
            NotPermitted: They may not any more. Nothing has changed, and the adapter is closed.
            RecordUnavailable: Likewise.
        """
        gateway, profile, here = self._gateway, newcomer.profile, False
        decided = Decided(
            act="robot-added",
            by=by,
            about=profile.id,
            at_ns=gateway.access.time.wall_ns(),
            digest=wanted.draft.digest,
        )
        try:
            async with gateway.access.changes.turn() as turn:
                outlook = await gateway.authority.foresee((*gateway.profiles.values(), profile))
                check_right()  # opening took its time: access may have ended
                somebody = self._somebody(profile.id, wanted.role, by)
                await turn.write((decided, fact_of(profile.id, wanted.draft), *somebody))
                here = True
                return self._add_robot(newcomer, outlook, stops)
        except BaseException:
            if not here:
                await newcomer.robot.close()
            raise

    async def _make(self, profile: Profile) -> PendingRobot:
        """Make everything, known to nobody. What takes long in a large fleet is done beside.

        Raises:
            NotUnderstood: People could not speak to it, or it cannot be reached like that.
        """
        parts = self._parts
        robots = (*self._gateway.profiles.values(), profile)
        try:
            known = self._gateway.rooms.vocabulary
            vocabulary = await asyncio.to_thread(
                Vocabulary.build, robots, parts.units, known.commands, known.phrases
            )
        except ValueError as why:
            sentence = capital(f"{str(why).rstrip('.')}.")
            raise NotUnderstood(words.unspeakable(sentence)) from why
        read_rules((profile,), vocabulary)  # what is wrong with them is said before it is here
        n, fence = self._numbers.get(profile.id, (0, 0))
        generation, latched = self._stops.get(profile.id, (0, False))
        gate = OrderGate(profile.id, n=n, fence=fence, generation=generation, latched=latched)
        try:
            factory = parts.robot_factory(profile.link.kind)
            demand_good(profile, factory, parts.clock)
            robot = factory(profile, gate, parts.clock)
        except ConfigurationError as why:
            raise NotUnderstood(words.not_opened(profile.shown, str(why))) from why
        return PendingRobot(profile, robot, vocabulary)

    async def _open(self, robot: Robot) -> None:
        """Open an adapter; one that cannot be opened is closed again.

        Raises:
            NotUnderstood: Why not.
        """
        profile, among = robot.profile, self._gateway.features.get(RobotToRobotFeature).messaging
        if isinstance(robot, PeerRobot):
            among.stand_by(profile.id, robot)
        try:
            async with asyncio.timeout(OPENS_WITHIN_S):
                await robot.open(partial(self._says, profile))
        except BaseException as why:
            with suppress(Exception):
                await robot.close()
            if isinstance(why, RosicError):
                raise NotUnderstood(words.not_opened(profile.shown, str(why))) from why
            if isinstance(why, TimeoutError):
                raise NotUnderstood(words.not_in_time(profile.shown, OPENS_WITHIN_S)) from why
            if not isinstance(why, Exception):
                raise
            log.exception("%s could not be opened", profile.id)
            raise NotUnderstood(words.broken(profile.shown)) from why

    # ---- what cannot ----

    def _add_robot(self, newcomer: PendingRobot, outlook: PolicyPreview, stops: int) -> bool:
        """Let the robot be here, for every room at once: nothing is waited for in here.

        Args:
            newcomer: Opened, and on the record.
            outlook: The rights with it.
            stops: How many stops there had been when it began. A stop that came since could not
                name it, and might have meant it: it is stopped, too.

        Returns:
            Whether it was stopped because of that.
        """
        gateway, profile = self._gateway, newcomer.profile
        meanwhile, by = gateway.rooms.stops.newest()
        number, fence = self._numbers.get(profile.id, (0, 0))
        added = AddedRobot(
            profile=profile,
            robot=newcomer.robot,
            number=number,
            fence=fence,
            stop=self._stops.get(profile.id, (0, False)),
        )
        gateway.authority.add_robot(outlook)
        gateway.registry.add(added, newcomer.vocabulary)
        if stopped := meanwhile != stops:
            gateway.stop_lane.stop_robots((profile.id,), by)
        return stopped

    def _answer(self, profile: Profile, advice: Sequence[str], *, stopped: bool) -> str:
        lines = [words.added(profile)]
        if stopped:
            lines.append(words.STOPPED_MEANWHILE)
        elif self._gateway.rooms.stops[profile.id].latched:
            lines.append(words.LEFT_STOPPED)
        if standing := robot_messages.standing(self._standing(profile.id)):
            lines.append(standing)
        return joined("\n", (*lines, core_words.help_for(profile), *advice))
