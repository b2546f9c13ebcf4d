"""Opens the robots of a start, and tells the admins what takes long: nobody is heard before."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.contracts.messenger import alarm_to
from rosic.core.i18n import joined, said

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.contracts.messenger import Messenger
    from rosic.contracts.robot import Robot
    from rosic.core.robot.profile import Profile
    from rosic.errors import MessengerFault


class RobotStartup:
    """Opens one robot after the other.

    Args:
        says: What becomes of a robot's words once people are heard.
        tell_admins: Tells whoever looks after people here.
        opened: Every robot that was opened is put here, in order.
    """

    def __init__(
        self,
        says: Callable[[Profile, str], None],
        tell_admins: Callable[[str], object],
        opened: list[Robot],
    ) -> None:
        self._says = says
        self._tell_admins = tell_admins
        self._opened = opened
        self._waiting = True
        self._told = False

    async def all(self, robots: Iterable[Robot]) -> None:
        """Open them.

        Raises:
            ConfigurationError: From the robot that could not be opened. Those before it are open.
        """
        for robot in robots:
            await robot.open(self._mouth(robot.profile))
            self._opened.append(robot)
        self._waiting = False
        if self._told:
            self._tell_admins(said("All robots are prepared. From now on I listen."))

    def _mouth(self, profile: Profile) -> Callable[[str], None]:
        def says(text: str) -> None:
            if not self._waiting:
                self._says(profile, text)
                return
            if not self._told:
                self._told = True
                self._tell_admins(
                    said("I am starting. I hear nobody until my robots are prepared.")
                )
            self._tell_admins(joined(": ", (profile.shown, text)))

        return says


def warn_of_thieves(messengers: Iterable[Messenger], tell: Callable[[str], object]) -> None:
    """Have the admins told wherever they are reached that somebody else acts for a messenger.

    Through that messenger too: whoever has its token may take the words away again, but not from
    every phone that has shown them.
    """

    def warn(fault: MessengerFault) -> None:
        tell(fault.sentence)

    for messenger in messengers:
        alarm_to(messenger, warn)
