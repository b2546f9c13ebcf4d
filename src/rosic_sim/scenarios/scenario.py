"""A play: what it is made of, and where it is played.

That is a real gateway with simulated robots; the people are method calls.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final, NamedTuple, TypeVar

from rosic.app.admin.dispatch import AdminDispatcher
from rosic.app.runtime import until_quiet
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules
from rosic.features.fleet import FleetFeature
from rosic.messengers.memory import MemoryMessenger
from rosic_sim.robots.simulation_loop import simulation_of
from rosic_sim.scenarios.recording_store import counted
from rosic_sim.scenarios.robots import SpeakingRobot

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator

    from rosic.app.gateway import Gateway
    from rosic.contracts.clock import Clock
    from rosic.core.fleet.mission import Mission
    from rosic.core.message import Button, Outbound
    from rosic.core.robot.profile import Profile
    from rosic_sim.robots.machines.stepped_machine import SteppedMachine
    from rosic_sim.robots.machines.world import SimulatedWorld
    from rosic_sim.scenarios.recording_store import RecordingStore
    from rosic_sim.scenarios.terminal_view import TerminalView

Found = TypeVar("Found")


# ---- what a play is made of ----

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
    """One scenario: its people, robots and script.

    Attributes:
        name: As typed after ``rosic demo``.
        about: One line.
        people: Who takes part; whoever plays along is the first unless they say otherwise.
        profiles: The robots.
        machines: Those of them that the room of the six does not have anyway.
        script: What happens.
        hints: What somebody who plays along could try.
        peers: Robots that speak with each other, with the role ``peer``.
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
    peers: tuple[str, ...] = ()
    rules: RoleRules = RULES
    lease_idle_s: float = 20.0
    missions: tuple[Mission, ...] = ()


class ScenarioMismatch(Exception):
    """It did not go as written; the sentence says what was missing."""


# ---- where it is played ----

WITHIN_S: Final = 180.0
"""On the play's clock, which may be four times as fast as the machine's. Nothing in a play takes
half a minute, but a busy machine may take several times as long."""
BEAT_S: Final = 0.8
READ_S: Final = 0.02
"""For each letter of what an onlooker says, before somebody acts."""
LOOK_S: Final = 0.05
# An order's way is told step by step; its beginning and its end are enough for an onlooker.
STEP: Final = re.compile(r"[^:\n]+: (sent|received by the robot|[^:\n]+ \d+ %)")


class ScenarioChats(MemoryMessenger):
    """The people's phones; what they are told is handed on as it is shown."""

    _watcher: Callable[[str, Outbound], None] | None = None

    def watch(self, watcher: Callable[[str, Outbound], None]) -> None:
        """Call a watcher with each message from now on."""
        self._watcher = watcher

    async def send(self, outbound: Outbound) -> str:
        """Show a message."""
        message = await super().send(outbound)
        if self._watcher is not None:
            self._watcher(message, outbound)
        return message


class ScenarioRunner:
    """What a script may do, and what it waits for.

    Attributes:
        gateway: Open and running.
        clock: Of the play.
        curtain: What is shown.
        muted: Who is not shown: the rest of a class.
    """

    def __init__(
        self,
        play: Scenario,
        gateway: Gateway,
        chats: ScenarioChats,
        curtain: TerminalView,
        clock: Clock,
    ) -> None:
        self.play = play
        self.gateway = gateway
        self.muted: set[str] = set()
        self._chats = chats
        self.curtain = curtain
        self.clock = clock
        self._told: list[tuple[str, str, Outbound]] = []
        self._since: dict[str, int] = {}
        self._unread = 0
        chats.watch(self._shows)

    def _shows(self, message: str, outbound: Outbound) -> None:
        who = outbound.chat.id
        self._told.append((who, message, outbound))
        if who not in self.muted and STEP.fullmatch(outbound.text) is None:
            self.curtain.told(who, outbound)

    # ---- people ----

    async def says(self, who: str, text: str, *, hears: str = "") -> str:
        """Have somebody write something; wait until they are told what is expected.

        Raises:
            ScenarioMismatch: They were not.
        """
        if who not in self.muted:
            await self.beat()
            self.curtain.says(who, text)
        self._since[who] = len(self._told)
        self._chats.say(text, account=who, chat=who)
        return await self.hears(who, hears) if hears else ""

    async def taps(self, who: str, label: str, *, hears: str = "") -> str:
        """Have somebody tap the newest button of that label, and wait likewise.

        Raises:
            ScenarioMismatch: There is no such button, or they were not told.
        """
        button, under = await self._button(who, label)
        await self.beat()
        self.curtain.says(who, f"[ {label} ]")
        self._since[who] = len(self._told)
        self._chats.tap(button, under=under, account=who)
        return await self.hears(who, hears) if hears else ""

    async def _button(self, who: str, label: str) -> tuple[Button, str]:
        def look() -> tuple[Button, str] | None:
            for reader, message, outbound in reversed(self._told):
                for button in (b for row in outbound.buttons for b in row):
                    if reader == who and button.label == label:
                        return button, message
            return None

        return await self.until(look, f"{who} saw no button {label!r}")

    async def hears(self, who: str, text: str, *, within_s: float = WITHIN_S) -> str:
        """Wait until somebody reads something since they last spoke; return the message.

        Raises:
            ScenarioMismatch: They did not.
        """
        since = self._since.get(who, 0)

        def look() -> str | None:
            told = self._told[since:]
            return next((o.text for name, _, o in told if name == who and text in o.text), None)

        return await self.until(look, f"{who} was not told {text!r}", within_s=within_s)

    def readers(self, text: str) -> list[str]:
        """Return who was told something, in order."""
        return [who for who, _, outbound in self._told if text in outbound.text]

    # ---- everything else ----

    def aside(self, text: str) -> None:
        """Say what an onlooker sees."""
        self.curtain.aside(text)
        self._unread = len(text)

    async def beat(self, seconds: float = BEAT_S) -> None:
        """Let people read."""
        unread, self._unread = self._unread, 0
        await self.clock.sleep(max(seconds, unread * READ_S))

    async def quiet(self) -> None:
        """Wait until nothing is under way.

        Raises:
            ScenarioMismatch: Something is, after very long.
        """
        if not await until_quiet(self.gateway, self.clock, seconds=WITHIN_S):
            raise ScenarioMismatch("Something is still under way.")

    async def until(
        self, look: Callable[[], Found | None], sentence: str, within_s: float = WITHIN_S
    ) -> Found:
        """Wait until something is found, and return it.

        Raises:
            ScenarioMismatch: With the sentence: it was not.
        """
        end_ns = self.clock.monotonic_ns() + int(within_s * 1e9)
        while not (found := look()):
            if self.clock.monotonic_ns() > end_ns:
                raise ScenarioMismatch(f"{sentence}.")
            await self.clock.sleep(LOOK_S)
        return found

    @property
    def world(self) -> SimulatedWorld:
        """Where the machines are, for breaking them."""
        return simulation_of(self.clock).world

    def robot(self, name: str) -> SpeakingRobot:
        """Return a robot that speaks."""
        found = self.gateway.robots[name]
        assert isinstance(found, SpeakingRobot)  # noqa: S101 - the play says so
        return found

    # ---- the end ----

    def moving(self) -> list[str]:
        """Return the robots whose machines are not at rest."""
        profiles = self.gateway.rooms.profiles.values()
        return [p.shown for p in profiles if not self.world.machines[p.id].at_rest()]

    def summary(self, record: RecordingStore, took_s: float) -> Iterator[str]:
        """Yield what happened, from the record and from the robots."""
        rooms = self.gateway.rooms
        yield f"It took {took_s:.0f} s."
        directory = rooms.authoriser.directory
        known = [p for person in self.play.people for p in directory.named(person.name)]
        names = {person.id: person.name for person in known}
        robots = {robot: profile.shown for robot, profile in rooms.profiles.items()}
        yield from record.lines(names, robots)
        yield from self._tasks()
        yield "The robots now:"
        yield from (f"  {line}" for line in AdminDispatcher(self.gateway).status())

    def _tasks(self) -> Iterator[str]:
        fleet = self.gateway.features.get(FleetFeature)
        for task in fleet.dispatching.fleet.tasks.values():
            steps = f"{task.done} of {counted(task.steps, 'step')} done"
            moved = f", moved {counted(task.moves, 'time')}" if task.moves else ""
            yield f"Task {task.id}: {task.state.name.lower()}, {steps}{moved}."
