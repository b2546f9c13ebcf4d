"""How an adapter is found and made: by entry point, never by an if over names.

Entry point groups: ``rosic.messengers``, ``rosic.robots``. Each entry is a factory below; making
does no I/O, opening does.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.robot import Robot
    from rosic.core.order_gate import OrderGate
    from rosic.core.robot.profile import Profile


class MessengerFactory(Protocol):
    """Makes a messenger of one kind."""

    def __call__(self, name: str, settings: Mapping[str, Any], clock: Clock) -> Messenger:
        """Make it from its table in the configuration, secrets already resolved.

        Raises:
            ConfigurationError: A setting is missing, unknown or wrong; the sentence names it.
        """
        ...


class RobotFactory(Protocol):
    """Makes a robot of one kind.

    A kind that can be stopped and measures rest by itself, whatever a profile says of `stop` and
    `at_rest`, says so: `stops_itself = True` on the class. A robot of any other kind that moves
    needs both in its profile, or the word `unstoppable` there.
    """

    def __call__(self, profile: Profile, gate: OrderGate, clock: Clock) -> Robot:
        """Make it from its profile.

        Raises:
            ConfigurationError: The profile asks for what this kind cannot do.
        """
        ...


@runtime_checkable
class StopsItself(Protocol):
    """A kind of robot that says whether it is stopped without a word in its profile."""

    stops_itself: bool


def stops_itself(factory: RobotFactory) -> bool:
    """Whether robots of a kind are stopped and measured at rest without a word in the profile."""
    return isinstance(factory, StopsItself) and factory.stops_itself
