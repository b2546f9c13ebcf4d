"""What a play is made of."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.core.fleet.mission import Mission
    from rosic.core.robot.profile import Profile
    from rosic_sim.robots.machines.clockwork import SteppedMachine
    from rosic_sim.scenarios.stage import ScenarioRunner

RULES: Final = RoleRules(roles=DEFAULT_ROLES)


class Person(NamedTuple):
    """Somebody in a play, known by what they are there.

    Attributes:
        name: ``Ranger``; also the account.
        role: Name of a role.
    """

    name: str
    role: str = "operator"


class Scenario(NamedTuple):
    """One play.

    Attributes:
        name: As typed after ``rosic demo``.
        about: One line.
        people: Who takes part; whoever plays along is the first unless they say otherwise.
        profiles: The robots.
        machines: Those of them that the room of the six does not have anyway.
        script: What happens.
        hints: What somebody who plays along could try.
        fellows: Robots that speak with each other, with the role ``fellow``.
        rules: Roles and pre-emption.
        lease_idle_s: How long a robot stays somebody's after their last order ended.
        missions: What several robots do when somebody says so.
    """

    name: str
    about: str
    people: tuple[Person, ...]
    profiles: Callable[[], tuple[Profile, ...]]
    machines: Callable[[], tuple[SteppedMachine, ...]]
    script: Callable[[ScenarioRunner], Awaitable[None]]
    hints: tuple[str, ...]
    fellows: tuple[str, ...] = ()
    rules: RoleRules = RULES
    lease_idle_s: float = 20.0
    missions: tuple[Mission, ...] = ()


class OffScript(Exception):
    """It did not go as written; the sentence says what was missing."""
