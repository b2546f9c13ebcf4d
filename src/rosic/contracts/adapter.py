"""How an adapter is found and made: by entry point, never by an if over names.

Entry point groups: ``rosic.messengers``, ``rosic.robots``. Each entry is a factory below; making
does no I/O, opening does. What a profile may say of a link is the business of its adapter: a robot
factory carries a `ProfileSchema`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Protocol, TypeAlias, runtime_checkable

from rosic.contracts.file_rules import Rules, ValidationFinding
from rosic.core.robot.profile import Profile

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.robot import Robot
    from rosic.core.order_gate import OrderGate


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

    What else is asked of a kind stands on the factory, for a class as an attribute of it:
    ``schema``, see `DescribesProfiles`; ``stops_itself``, see `StopsItself`.
    """

    def __call__(self, profile: Profile, gate: OrderGate, clock: Clock) -> Robot:
        """Make it from its profile.

        Raises:
            ConfigurationError: The profile asks for what this kind cannot do.
        """
        ...


@runtime_checkable
class StopsItself(Protocol):
    """A kind that is stopped and measured at rest by itself, whatever a profile says.

    A robot of any other kind that moves needs a stop and a measured rest in its profile (see
    `Profile.stops`, `Profile.measures_rest`), or the word ``unstoppable`` there.
    """

    stops_itself: bool


def stops_itself(factory: RobotFactory) -> bool:
    """Whether robots of a kind are stopped and measured at rest without a word in the profile."""
    return isinstance(factory, StopsItself) and factory.stops_itself


# ---- profiles ----

Advice: TypeAlias = Callable[[Any], Iterator[ValidationFinding]]
Reaches: TypeAlias = Callable[[Any], Iterator[str]]


def shares_nothing(_profile: Profile) -> Iterator[str]:
    """Say that no other profile can reach this robot: it is made for this one."""
    return iter(())


class ProfileSchema(NamedTuple):
    """What the profiles of one kind say, besides what every robot has.

    Attributes:
        profile: `Profile`, or a class derived from it: with keys of the link's own, and with
            `Link`, `Skill`, `Telemetry`, `Files` derived in the same way where those have some. A
            file is decoded into it, and the published schema and its descriptions are made of it.
        rules: What is asked of these keys beyond their types. What is asked of every robot's is
            asked as well.
        advice: Says what is allowed, but worse than it could be; takes such a profile.
        reaches: Returns what one robot alone can answer to, in words that hold for every robot of
            an installation, whatever its kind: what it is commanded, stopped and measured by. Two
            profiles that share a word reach one robot, and are refused: its second id would pass
            by a stop and a lock of the first.
    """

    profile: type[Profile]
    rules: Rules
    advice: Advice
    reaches: Reaches = shares_nothing


def no_advice(_profile: Profile) -> Iterator[ValidationFinding]:
    """Say nothing."""
    return iter(())


EVERY_ROBOT: Final = ProfileSchema(Profile, Rules({}, {}, frozenset(), {}), no_advice)
"""Of a kind with no keys of its own."""


@runtime_checkable
class DescribesProfiles(Protocol):
    """A kind that has keys of its own in a profile."""

    schema: ProfileSchema


def schema_of(factory: RobotFactory) -> ProfileSchema:
    """Return what profiles of a kind say."""
    return factory.schema if isinstance(factory, DescribesProfiles) else EVERY_ROBOT
