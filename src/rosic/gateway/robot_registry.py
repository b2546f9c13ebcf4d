"""The robots of a gateway: where one is added, and who is told of it.

The rooms come first, in the order in which an order passes them: they decide about a robot, so
they are arguments and not subscribers. Whoever else keeps something per robot connects to the
signal and is told when every room knows.
"""

from __future__ import annotations

from hashlib import blake2b
from typing import TYPE_CHECKING, Final, Protocol

import msgspec

from rosic.contracts.robot import Robot
from rosic.core.identity import DIGEST_BYTES
from rosic.core.robot.profile import Profile
from rosic.core.signal import Signal

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rosic.core.identity import PrincipalId
    from rosic.core.language import Vocabulary
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.components import Components


TEXT_BYTES: Final = 131_072


class AddedRobot(msgspec.Struct, frozen=True, kw_only=True):
    """A robot that has just been added.

    Attributes:
        robot: Its adapter, open.
        number: The highest number of an order to it so far.
        fence: The highest fence so far.
        stop: Generation of its newest stop, and whether it is latched.
    """

    profile: Profile
    robot: Robot
    number: int
    fence: int
    stop: tuple[int, bool]


class ProfileDraft(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A profile as it was handed over; also the body of the fact.

    Attributes:
        text: What stands in the file.
        name: Of the file, without its folder, for saying where something is wrong.
        link: Reach the robot by this adapter, whatever the file says; empty: as it says.
    """

    text: str
    name: str
    link: str = ""

    @property
    def digest(self) -> bytes:
        """What stands for it in the log of decisions."""
        return blake2b(self.encoded(), digest_size=DIGEST_BYTES).digest()

    def encoded(self) -> bytes:
        """Return the body of the fact that makes the robot known to every later start."""
        return _encode(self)


_encode = msgspec.msgpack.Encoder().encode


def owner_may() -> None:
    """Let the owner of the machine add a robot: whoever runs it needs no right (`OPERATOR`)."""


class RobotAdder(Protocol):
    """Adds robots to a gateway that runs."""

    async def check(self, draft: ProfileDraft, role: str = "") -> tuple[Profile, Sequence[str]]:
        """Return the robot of a profile that nobody would take for another, and advice about it.

        Raises:
            NotUnderstood: Everything that is wrong with it.
        """
        ...

    async def add(
        self,
        draft: ProfileDraft,
        by: PrincipalId,
        check_right: Callable[[], None],
        role: str = "",
    ) -> str:
        """Add a robot, if ``check_right`` still lets them then. Return what is said of it.

        Raises:
            Refusal: Why not. Nothing was changed.
        """
        ...


class RobotRegistry:
    """Adds robots, for everybody between two turns of the event loop.

    Attributes:
        added: Tells of a robot that all rooms know now.

    Args:
        rooms: Which look into the profiles.
        profiles: Of every robot; nobody else writes into it.
        robots: Their adapters; likewise.
    """

    def __init__(
        self,
        rooms: Components,
        profiles: dict[RobotId, Profile],
        robots: dict[RobotId, Robot],
    ) -> None:
        self.added: Signal[[AddedRobot]] = Signal()
        self._rooms = rooms
        self._profiles = profiles
        self._robots = robots

    def add(self, newcomer: AddedRobot, vocabulary: Vocabulary) -> None:
        """Let a robot be here: nothing is waited for, so no order meets half of it.

        Args:
            newcomer: Nobody knows its id yet.
            vocabulary: Everything that can be said from now on.
        """
        rooms, profile = self._rooms, newcomer.profile
        self._profiles[profile.id] = profile
        rooms.stops.add_robot(profile.id, newcomer.stop)
        rooms.linker.add_robot(newcomer.robot)
        rooms.organiser.add_robot(profile, newcomer.fence)
        rooms.container.add_robot(profile.id, newcomer.number)
        self._robots[profile.id] = newcomer.robot
        rooms.vocabularies.replace(vocabulary)
        self.added.emit(newcomer)
