"""A place whose robots are principals: two that may much, one that may only read, one unknown."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

import msgspec
from msgspec.structs import replace

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.core.robot.skill import Parameter, Strategy
from rosic.features.robot_to_robot import RobotToRobotFeature
from tests.gateway.place import FLEET, PEOPLE, Place

if TYPE_CHECKING:
    from rosic.contracts.robot import RobotTasks
    from rosic.core.robot.profile import Profile
    from rosic.features.robot_to_robot.service import RobotMessaging

T = TypeVar("T", bound="RobotTasks | None")

FELLOW = Role(scopes=("*:share", "*:ask", "*:help", "*:read", "*:strategy"))
READER = Role(scopes=("cf2:share", "cf1:read"))
CAREFUL = Strategy(
    title="Careful",
    parameters={
        "speed": Parameter(unit="m/s", min=0.05, max=0.5, default=0.2),
        "spacing": Parameter(unit="m", min=0.5, max=3.0, default=1.0),
    },
)
BRISK = Strategy(parameters={"manner": Parameter(choices={"calm": (), "bold": ("brave",)})})


def robot(name: str, role: str) -> ConfiguredPerson:
    """Return a robot as the configuration names one."""
    return ConfiguredPerson(name, (Address("robot", name),), (role,))


class PeerRobots(Place):
    """omni and cf1 may much, cf2 reads cf1 alone, kuka1 is nobody."""

    rulebook = RoleRules(roles={**DEFAULT_ROLES, "fellow": FELLOW, "reader": READER})
    people: tuple[ConfiguredPerson, ...] = (
        *PEOPLE,
        robot("omni", "fellow"),
        robot("cf1", "fellow"),
        robot("cf2", "reader"),
    )

    @property
    def messaging(self) -> RobotMessaging:
        """Return what carries the words of robots."""
        return self.gateway.features.get(RobotToRobotFeature).messaging

    def keep_tasks(self, tasks: T) -> T:
        """Let somebody keep the tasks of robots that help each other."""
        self.messaging.circle.helping.tasks = lambda: tasks
        return tasks

    def speaks(self, name: str, kind: str, **said: object) -> None:
        """Let a robot's own nodes say something."""
        self.robot(name).speak(msgspec.json.encode({"kind": kind, **said}), 0)

    async def says(self, name: str, kind: str, **said: object) -> dict[str, Any]:
        """Let a robot say something, and return what it is answered."""
        self.robot(name).heard.clear()
        self.speaks(name, kind, ref="r", **said)
        await self.quiet()
        answers = [a for a in self.heard(name) if a["kind"] == "result"]
        assert len(answers) == 1, answers
        return answers[0]

    def heard(self, name: str, kind: str = "") -> list[dict[str, Any]]:
        """Return what a robot was told."""
        found = [msgspec.json.decode(words) for words in self.robot(name).heard]
        return [one for one in found if kind in {"", one["kind"]}]


def with_strategies(name: str = "omni") -> tuple[Profile, ...]:
    """Return the fleet, one robot of which can be told how to work."""
    declared = {"careful": CAREFUL, "brisk": BRISK}
    return tuple(replace(p, strategies=declared) if p.id == name else p for p in FLEET)
