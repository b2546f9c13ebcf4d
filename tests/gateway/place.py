"""A whole gateway in one process: memory robots, a memory messenger, a clock the test owns."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Self

from rosic.app.admin.api import AdminRequest, AdminVerb, books_of
from rosic.app.admin.dispatch import AdminApi
from rosic.app.gateway import Gateway, GatewayParts, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.config.profiles import known_units
from rosic.core.identity import Address
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules
from rosic.core.rate_limit import RateLimit
from rosic.core.robot.profile import Busy, Link, Profile
from rosic.core.robot.skill import Parameter, Skill, SkillClass
from rosic.errors import StoreFault
from rosic.messengers.memory import MemoryMessenger
from rosic.organiser.planning.solver import load
from rosic.robots.memory import MemoryRobot
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import MemoryLatch
from rosic.testing.clock import ManualClock, SeededEntropy, settle
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from rosic.contracts.adapter import RobotFactory
    from rosic.contracts.interpreter import Interpreter
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.recording import Recorder
    from rosic.contracts.store import StopLatch, Store
    from rosic.core.message import Button, Outbound
    from rosic.core.records import Record

ADA, BO, VI, STRANGER = "1", "2", "3", "99"
MOVE = Skill(
    id="move",
    title="Move",
    parameters={
        "direction": Parameter(choices={"forward": (), "back": (), "left": ()}, default="forward"),
        "distance": Parameter(unit="m", min=0.01, max=5.0),
    },
)
WAVE = Skill(id="wave", title="Wave")
LOOK = Skill(id="look", kind=SkillClass.OBSERVE)


def profile(name: str, *, busy: Busy = Busy.REFUSE, groups: tuple[str, ...] = ()) -> Profile:
    """Return a robot that moves, waves and looks."""
    return Profile(
        id=name,
        link=Link(kind="memory"),
        busy=busy,
        groups=groups,
        skills={skill.id: skill for skill in (MOVE, WAVE, LOOK)},
    )


FLEET = (
    profile("omni"),
    profile("kuka1", busy=Busy.QUEUE),
    profile("cf1", groups=("swarm",)),
    profile("cf2", groups=("swarm",)),
)
PEOPLE = (
    ConfiguredPerson("Ada", (Address("memory", ADA),), ("admin",)),
    ConfiguredPerson("Bo", (Address("memory", BO),), ("operator",)),
    ConfiguredPerson("Vi", (Address("memory", VI),), ("viewer",)),
)

# Of the last admin no access can be taken back.
TWO_ADMINS = (*PEOPLE, ConfiguredPerson("Di", (Address("memory", "4"),), ("admin",)))


class WritingStore(MemoryStore):
    """Keeps by writing: what a double does to ``write``, it does to ``keep``."""

    def __init__(self) -> None:
        super().__init__()
        self._keeping: set[asyncio.Task[None]] = set()

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        """Write in a task of its own; what fails becomes a note."""
        task = asyncio.ensure_future(self._keep(record, then))
        self._keeping.add(task)
        task.add_done_callback(self._keeping.discard)

    async def _keep(self, record: Record, then: Callable[[], None]) -> None:
        try:
            await self.write(record)
        except StoreFault:
            self.note(record)
        then()


class BrokenStore(WritingStore):
    """Writes nothing once it is broken."""

    broken = False

    async def write(self, *records: Record) -> None:
        if self.broken:
            raise StoreFault("the disk is full")
        await super().write(*records)

    def note(self, *records: Record) -> None:
        if not self.broken:
            super().note(*records)


class SlowStore(WritingStore):
    """Its disk takes its time with one kind of record, until ``ready``."""

    def __init__(self, slow: type) -> None:
        super().__init__()
        self.ready = asyncio.Event()
        self._slow = slow

    async def write(self, *records: Record) -> None:
        """Wait for ``ready`` if one of the records is of the slow kind."""
        if any(isinstance(record, self._slow) for record in records):
            await self.ready.wait()
        await super().write(*records)


def edited(clock: ManualClock) -> MemoryMessenger:
    """Return a messenger whose messages can be edited."""
    return MemoryMessenger("memory", clock=clock)


def line_by_line(clock: ManualClock) -> MemoryMessenger:
    """Return a messenger that cannot change what was said."""
    return MemoryMessenger("memory", clock=clock, edits=False)


async def ask_as_operator(gateway: Gateway, verb: AdminVerb, *names: str) -> str:
    """Ask what the owner of the machine may ask of a running gateway; return the answer."""
    answers = await AdminApi(books_of(gateway, "UTC")).do(AdminRequest(verb, names))
    return "\n".join(answers)


class Place:
    """A gateway and everything around it.

    Attributes:
        chat: The messenger.
        robots: By id.
        rulebook: The rules of the place.
        kind: What its robots are.
        people: Who is known.
        interpreter: May be shown what is not understood.
        recorder: Makes files of what is seen.
        besides: Other messengers than the one that people here use.
    """

    rulebook = RoleRules(roles=DEFAULT_ROLES)
    kind: RobotFactory = MemoryRobot
    people: tuple[ConfiguredPerson, ...] = PEOPLE
    interpreter: Interpreter | None = None
    recorder: Recorder | None = None
    besides: tuple[Callable[[ManualClock], Messenger], ...] = ()

    def __init__(
        self,
        store: Store | None = None,
        latch: StopLatch | None = None,
        *,
        clock: ManualClock | None = None,
        limit: RateLimit | None = None,
        fleet: tuple[Profile, ...] = FLEET,
        chat: Callable[[ManualClock], MemoryMessenger] = edited,
    ) -> None:
        load()  # of the solver: it takes real time, and the clock here is a test's own
        self.clock = clock or ManualClock()
        self.store = store or MemoryStore()
        self.latch = latch or MemoryLatch()
        self.chat = chat(self.clock)
        self._settings = GatewaySettings(
            profiles=fleet,
            people=self.people,
            limit=limit or RateLimit(burst=1e6, per_s=1e6),
            lease_idle_s=30.0,
            rulebook=self.rulebook,
        )
        self.gateway = Gateway(
            self._settings,
            GatewayParts(
                messengers=(self.chat, *(make(self.clock) for make in self.besides)),
                robot_factory=lambda _kind: type(self).kind,
                store=self.store,
                latch=self.latch,
                clock=self.clock,
                entropy=SeededEntropy(),
                units=known_units(),
                face=lambda _ns: "12:00:00",
                interpreter=self.interpreter,
                recorder=self.recorder,
            ),
        )

    def robot(self, name: str) -> MemoryRobot:
        """Return a robot."""
        found = self.gateway.robots[name]
        assert isinstance(found, MemoryRobot)
        return found

    def acted(self, name: str = "omni") -> int:
        """Return how often a robot acted."""
        return len(self.robot(name).acted)

    @asynccontextmanager
    async def open(self) -> AsyncIterator[Self]:
        """Run it."""
        await self.gateway.open()
        running = asyncio.create_task(self.gateway.run())
        await settle()
        within_s = 1.0  # what has failed may leave something behind that never ends
        try:
            yield self
            within_s = 60.0
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
            if isinstance(self.store, SlowStore):
                self.store.ready.set()
            closing = asyncio.create_task(self.gateway.close())
            for _ in range(500):
                if closing.done():
                    break
                await self.clock.advance(0.01)
            await asyncio.wait_for(closing, within_s * pace())

    async def say(self, text: str, **how: object) -> str:
        """Say something and return everything that was told because of it, newest last."""
        before = len(self.chat.told)
        await self.clock.advance(0.001)
        self.chat.say(text, **how)  # type: ignore[arg-type]
        await self.quiet()
        return "\n".join(told.outbound.text for told in list(self.chat.told)[before:])

    async def tap(self, button: Button, under: str, account: str = ADA) -> str:
        """Tap a button; return what was told because of it."""
        before = len(self.chat.told)
        self.chat.tap(button, under=under, account=account)
        await self.quiet()
        return "\n".join(told.outbound.text for told in list(self.chat.told)[before:])

    async def revoke(self, name: str) -> str:
        """Have the owner of the machine end somebody's access; return what they are answered."""
        answer = await ask_as_operator(self.gateway, AdminVerb.REVOKE, name)
        await self.quiet()
        return answer

    async def quiet(self) -> None:
        """Let everything happen that can happen now."""
        for _ in range(5):
            await settle()

    def last(self) -> tuple[str, Outbound]:
        """Return the newest message and how it looks."""
        told = self.chat.told[-1]
        return told.message, self.chat.shown(told.message)

    def button(self, label: str) -> tuple[Button, str]:
        """Return the newest button with a label, and the message under which it is."""
        for told in reversed(self.chat.told):
            for row in self.chat.shown(told.message).buttons:
                for button in row:
                    if button.label == label:
                        return button, told.message
        raise AssertionError(f"no button {label!r}")
