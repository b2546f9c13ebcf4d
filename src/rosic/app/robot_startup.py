"""What robots begin with: the numbers, leases and stops that earlier runs left them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.contracts.messenger import alarm_to
from rosic.core.i18n import joined, said
from rosic.core.order_gate import OrderGate
from rosic.core.stop_registry import StopRegistry, not_known_yet
from rosic.gateway.stopped_by import KIND as STOPPED_BY
from rosic.gateway.stopped_by import restore

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.app.settings import GatewayParts
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.robot import Robot
    from rosic.core.records import Memory
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.errors import MessengerFault


# ---- robot opening ----

# Opens the robots of a start, and tells the admins what takes long: nobody is heard before.


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


# ---- robot startup ----


def robots_of(
    parts: GatewayParts,
    profiles: Mapping[RobotId, Profile],
    numbers: Mapping[RobotId, tuple[int, int]],
    stops: StopRegistry,
) -> dict[RobotId, Robot]:
    """Return the robots, not connected yet, each behind a gate that knows where it was.

    Args:
        parts: Makes adapters.
        profiles: Of the robots.
        numbers: The highest order number and fence of each so far.
        stops: What is stopped.
    """
    return {
        robot: parts.robot_factory(profile.link.kind)(
            profile,
            OrderGate(
                robot,
                n=numbers[robot][0],
                fence=numbers[robot][1],
                generation=stops[robot].generation,
                latched=stops[robot].latched,
            ),
            parts.clock,
        )
        for robot, profile in profiles.items()
    }


def stop_registry_of(
    profiles: Mapping[RobotId, Profile], found: Mapping[RobotId, tuple[int, bool]], memory: Memory
) -> StopRegistry:
    """Return which robots are stopped, by whom and since when, as far as earlier runs tell.

    Args:
        profiles: Of the robots.
        found: What the latch says.
        memory: What the record says.
    """
    stops = StopRegistry(profiles, stops_of(found, memory.generations), not_known_yet())
    restore(stops, memory.facts.get(STOPPED_BY, ()))
    return stops


def stops_of(
    found: Mapping[RobotId, tuple[int, bool]], generations: Mapping[RobotId, int]
) -> dict[RobotId, tuple[int, bool]]:
    """Join what the latch and the record say; the higher generation counts (I13).

    A stop that only the record knows holds: the latch could not be written when it was applied.
    """
    joined = dict(found)
    for robot, generation in generations.items():
        if generation > joined.get(robot, (0, False))[0]:
            joined[robot] = (generation, True)
    return joined
