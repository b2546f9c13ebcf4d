"""What is known here to a messenger by which programs speak, and what it owes to its own side."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeAlias, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Address, PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Skill
    from rosic.core.secret import Secret

ServeConnection: TypeAlias = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


class OfferedSkill(NamedTuple):
    """A skill of a robot that a program may ask for now.

    Attributes:
        shown: The robot, as people read it.
        skill: As the profile says: parameters in their declared units.
        asks: A person is asked before it is done.
    """

    robot: RobotId
    shown: str
    skill: Skill
    asks: bool


class Programs(Protocol):
    """Who programs are, and what they may say. Look-ups, all of it: nothing is asked for by them.

    Nothing here moves a robot: what a program wants becomes a line of the grammar, and goes the way
    of every line.
    """

    def identify(self, secret: Secret) -> Address:
        """Return the address from which whoever shows a secret speaks.

        Raises:
            Unrecognised: It is no secret of a good key.
        """
        ...

    def who(self, address: Address) -> tuple[PrincipalId, str]:
        """Return who speaks from an address: their id, and how people read their name.

        Raises:
            Unrecognised: Nobody is there any more.
        """
        ...

    def robots(self, address: Address) -> Mapping[RobotId, str]:
        """Return the robots that a program may see, and therefore stop: id, and as people read it.

        Raises:
            Unrecognised: Nobody is there any more.
        """
        ...

    def skills(self, address: Address) -> Sequence[OfferedSkill]:
        """Return what a program may ask for, under whatever limits.

        Raises:
            Unrecognised: Nobody is there any more.
        """
        ...

    def line(
        self, address: Address, robot: RobotId, skill: str, values: Mapping[str, object]
    ) -> str:
        """Return the line that says an order: each value by its name, in its declared unit.

        Whether a value is within its bounds is decided where every line is.

        Raises:
            Unrecognised: Nobody is there any more.
            NotUnderstood: No such robot or skill, as far as it may know; or a value is missing, of
                the wrong kind, or cannot be said.
        """
        ...


@runtime_checkable
class ServesPrograms(Protocol):
    """By it programs speak; see `serve_programs`."""

    def serve_programs(self, programs: Programs) -> None:
        """Ask this who they are, and what they may say."""


@runtime_checkable
class AttachesPrograms(Protocol):
    """A program may be at the other end of a connection of this machine."""

    def attach(self, secret: Secret) -> ServeConnection:
        """Return what serves the program that shows a secret, over a connection, until it leaves.

        Raises:
            Unrecognised: It is no secret of a good key.
        """
        ...


def serve_programs(messenger: Messenger, programs: Programs) -> None:
    """Have a messenger by which programs speak ask who they are, and what they may say."""
    if isinstance(messenger, ServesPrograms):
        messenger.serve_programs(programs)
