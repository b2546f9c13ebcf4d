"""Who a robot is to the authoriser and the organiser: somebody with a key, like any person."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.identity import ROBOT, Address
from rosic.core.policy.scope import READ
from rosic.errors import NotPermitted

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator

    from rosic.core.identity import Caller, PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.components import Components

LOOKED_AT_A_STEP = 50


class PeerPermissions:
    """Asks the rooms about robots that speak, and about people around them."""

    def __init__(self, rooms: Components) -> None:
        self._rooms = rooms

    def caller(self, robot: RobotId) -> Caller:
        """Return a robot as whoever speaks now, under its own key.

        Raises:
            Unrecognised: Its key is revoked or has expired.
            NotPermitted: It is no principal here, or it is locked.
        """
        found = self._rooms.authoriser.directory.at(Address(ROBOT, robot))
        if found is None:
            raise NotPermitted(
                said(
                    "{robot} has no key of its own here. The operator can give it one.",
                    robot=self.shown(robot),
                )
            )
        caller = self._rooms.authoriser.stand_for(found[0].id)
        self._rooms.organiser.check_unlocked(caller)
        return caller

    def check(self, caller: Caller, robot: RobotId, word: str) -> None:
        """See that somebody, robot or person, has a right on a robot.

        Raises:
            NotPermitted, Unrecognised: They lack it; a robot that they may not see is not known.
        """
        self._rooms.organiser.check_word(caller, robot, word)

    def robot_may(self, robot: RobotId, other: RobotId, word: str) -> bool:
        """Whether a robot has a right on another now."""
        found = self._rooms.authoriser.directory.at(Address(ROBOT, robot))
        return found is not None and self.may(found[0].id, other, word)

    def may(self, who: PrincipalId, robot: RobotId, word: str = READ) -> bool:
        """Whether somebody has a right now, whose key is good and who is not locked."""
        organiser = self._rooms.organiser
        return (
            self._rooms.authoriser.has_access(who)
            and who not in organiser.locked
            and organiser.allows(who, robot, word)
        )

    def operates(self, who: PrincipalId, robot: RobotId) -> bool:
        """Whether a person may command a robot at all."""
        return self.may(who, robot) and self._rooms.organiser.why_not_move(who, robot) is None

    def operators(
        self, *robots: RobotId, or_helpers_of: RobotId = ""
    ) -> AsyncIterator[PrincipalId]:
        """Yield the people who may command one of some robots. Walks everybody: for rare news.

        Args:
            robots: Which.
            or_helpers_of: And those who may accept this robot's request for help.
        """
        return self._each(
            lambda who: (
                any(self.operates(who, robot) for robot in robots)
                or bool(or_helpers_of and self.may(who, or_helpers_of, "help"))
            )
        )

    def helpers(self, asker: RobotId) -> AsyncIterator[PrincipalId]:
        """Yield the people who may accept a robot's request for help."""
        return self._each(lambda who: self.may(who, asker, "help"))

    async def _each(self, meant: Callable[[PrincipalId], bool]) -> AsyncIterator[PrincipalId]:
        """Yield people, a few in each step of the event loop: there may be thousands (I15)."""
        for number, person in enumerate(tuple(self._rooms.authoriser.directory.people()), 1):
            if number % LOOKED_AT_A_STEP == 0:
                await asyncio.sleep(0)
            if not person.is_robot and meant(person.id):
                yield person.id
                await asyncio.sleep(0)  # to tell one is a step

    def robots(self) -> Iterator[RobotId]:
        """Yield the robots that are principals here."""
        for robot in self._rooms.profiles:
            if self._rooms.authoriser.directory.at(Address(ROBOT, robot)) is not None:
                yield robot

    def principal(self, robot: RobotId) -> PrincipalId:
        """Return who a robot is; empty if it is nobody here."""
        found = self._rooms.authoriser.directory.at(Address(ROBOT, robot))
        return "" if found is None else found[0].id

    def name_for(self, caller: Caller, other: PrincipalId) -> str:
        """Return how somebody is named to a caller: people's names are not for robots' nodes."""
        person = self._rooms.authoriser.directory.person(other)
        if caller.address.platform == ROBOT and (person is None or not person.is_robot):
            return said("a person")
        return self._rooms.organiser.name_of(other)

    def shown(self, robot: RobotId) -> str:
        """Return how people read a robot."""
        profile = self._rooms.profiles.get(robot)
        return robot if profile is None else profile.shown
