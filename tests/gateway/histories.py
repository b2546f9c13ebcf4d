"""A world in which whole histories are played: people, robots, one disk, and one clock.

Everything that happens is written into one log, in order, by the world's own robots, gates and
disk. What must hold is judged afterwards (`judging.py`), with no help from the gateway.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.app.admin.api import AdminVerb
from rosic.app.gateway import Gateway, GatewayParts, GatewaySettings
from rosic.authoriser.button_tokens import ANYBODY
from rosic.config.profiles import known_units
from rosic.core.identity import command_id, robot_command_id
from rosic.core.message import Chat, ChatKind, Inbound, MessageValidity
from rosic.core.rate_limit import RateLimit
from rosic.core.robot.profile import Busy
from rosic.messengers.memory import MemoryMessenger
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock, SeededEntropy, settle
from tests.gateway.place import ADA, BO, STRANGER, TWO_ADMINS, VI, ask_as_operator, profile

if TYPE_CHECKING:
    from typing import Any

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.message import Button
    from rosic.core.order_gate import OrderGate
    from rosic.core.robot.profile import Profile
from tests.gateway.events import Event, Mode, Revoked, Said, Started
from tests.gateway.watched import Disk, Mouth, Recorder, StopFile, WatchedGate

FLEET = (
    profile("omni"),
    profile("kuka1", busy=Busy.QUEUE),
    profile("arm", busy=Busy.REPLACE),
    profile("cf1", groups=("swarm",)),
    profile("cf2", groups=("swarm",)),
)
ROBOTS = tuple(one.id for one in FLEET)
ACCOUNTS = {"Ada": ADA, "Bo": BO, "Vi": VI, "stranger": STRANGER}
LINES_AT_MOST = 3
CLOSING_TURNS = 2_000
STARTING_S = 0.05


class World:
    """People who speak, one gateway at a time, and what outlives it.

    Attributes:
        fleet: The robots.
        kind: What they are.
        log: Everything that happened, in order.
        chat: The platform; it outlives gateways, too.
    """

    fleet: tuple[Profile, ...] = FLEET
    kind: type[Recorder] = Recorder

    def __init__(self, *, edits: bool = True) -> None:
        self.log: list[Event] = []
        self.clock = ManualClock()
        self.store = MemoryStore()
        self.latch = StopFile(self.log)
        self.chat = MemoryMessenger("memory", clock=self.clock, edits=edits)
        self.sent: list[Inbound] = []
        self.revoked: set[str] = set()
        self.disk = Disk(self)
        self.gateway: Gateway
        self._runs = 0
        self._running: asyncio.Task[None] | None = None

    # ---- gateways begin and end ----

    async def start(self) -> None:
        """Start a gateway on what is there."""
        self._runs += 1
        await self.clock.advance(STARTING_S)
        self.disk = Disk(self)
        self.chat.listening_since_ns = self.clock.wall_ns() if self._runs > 1 else 0
        settings = GatewaySettings(
            profiles=self.fleet,
            people=TWO_ADMINS,
            limit=RateLimit(burst=1e6, per_s=1e6),
            lease_idle_s=30.0,
        )
        parts = GatewayParts(
            messengers=(Mouth(self.chat, self.disk), *self.besides()),
            robot_factory=lambda _kind: self._robot,
            store=self.disk,
            latch=self.latch,
            clock=self.clock,
            entropy=SeededEntropy(self._runs),
            units=known_units(),
            face=lambda _ns: "12:00:00",
        )
        self.gateway = Gateway(settings, parts)
        self._give_out_again()
        at = len(self.log)
        await self.gateway.open()
        robots = self.gateway.robots.items()
        known = {r: (o.gate.n, o.gate.fence, o.gate.generation, o.gate.latched) for r, o in robots}
        self.log.insert(at, Started(known))
        self._running = asyncio.create_task(self.gateway.run())
        await settle()

    def besides(self) -> tuple[Messenger, ...]:
        """Return what people and programs speak by besides the chat, in this run."""
        return ()

    def _robot(self, profile: Profile, gate: OrderGate, clock: Clock) -> Recorder:
        robot = self.kind(profile, WatchedGate(gate, self.log), clock)
        robot.world = self
        return robot

    def _give_out_again(self) -> None:
        """Stamp anew what no gateway has confirmed, as a platform would that gives it out again."""
        now_ns, since_ns = self.clock.wall_ns(), self.chat.listening_since_ns

        def stamped(inbound: Inbound) -> Inbound:
            return replace(inbound, received_ns=now_ns, listening_since_ns=since_ns)

        for lane in self.chat._waiting.values():
            again = [stamped(inbound) for inbound in lane]
            lane.clear()
            lane.extend(again)
        for number, inbound in self.chat._stops.items():
            self.chat._stops[number] = stamped(inbound)

    async def close(self) -> None:
        """End the gateway as a signal would."""
        self.disk.ready.set()
        await self._end(self._running)
        closing = asyncio.create_task(self.gateway.close())
        for _ in range(CLOSING_TURNS):
            if closing.done():
                break
            await self.clock.advance(0.01)
        await closing
        await self._end(*(asyncio.all_tasks() - {asyncio.current_task()}))

    async def crash(self, *, written: bool) -> None:
        """Kill the gateway. What was on its way to the disk arrived, or did not."""
        if written:
            self.disk.ready.set()
            await asyncio.sleep(0)
            await asyncio.sleep(0)
        self.disk.dead = True
        self.disk.ready.set()
        while others := asyncio.all_tasks() - {asyncio.current_task()}:
            for task in others:
                if task is not None:
                    task.cancel()  # again and again: nothing comes to rest in a dead process
            await asyncio.sleep(0)

    async def _end(self, *tasks: asyncio.Task[Any] | None) -> None:
        ending = [task for task in tasks if task is not None]
        for task in ending:
            task.cancel()
        await asyncio.gather(*ending, return_exceptions=True)

    # ---- people speak ----

    def say(
        self,
        who: str,
        text: str,
        *,
        group: bool,
        age_s: float = 0.0,
        standing: MessageValidity = MessageValidity.FRESH,
    ) -> None:
        """Say something for the first time."""
        account = ACCOUNTS[who]
        chat = Chat("memory", "g", ChatKind.GROUP) if group else Chat("memory", account)
        message = f"m{len(self.sent)}"
        sent_ns = self.clock.wall_ns() - int(age_s * 1e9)
        inbound = replace(
            self.chat._inbound(account, chat, message, sent_ns), text=text, standing=standing
        )
        base = tuple(
            command_id("memory", account, chat.id, message, str(line))
            for line in range(LINES_AT_MOST)
        )
        self.log.append(Said(who, text, base, sent_ns, standing, message, not group))
        self.sent.append(inbound)
        self.chat.deliver(inbound)

    def say_again(self, which: int) -> None:
        """Let the platform give out an earlier message once more; 0 is the newest."""
        if self.sent:
            again = replace(
                self.sent[-1 - which % len(self.sent)],
                received_ns=self.clock.wall_ns(),
                listening_since_ns=self.chat.listening_since_ns,
            )
            self.chat.deliver(again)

    def tap(self, who: str, which: int) -> None:
        """Tap one of the buttons that are to be seen, whoever it was shown to."""
        seen = [
            (button, message)
            for message in dict.fromkeys(told.message for told in self.chat.told)
            for row in self.chat.shown(message).buttons
            for button in row
        ]
        if seen:
            button, under = seen[-1 - which % len(seen)]
            self._note_tap(who, button)
            self.chat.tap(button, under=under, account=ACCOUNTS[who])

    def _note_tap(self, who: str, button: Button) -> None:
        """A tap says something if the button was bound to who tapped it, and was not used."""
        authoriser = self.gateway.rooms.authoriser
        bound = authoriser.buttons._bound.get(button.nonce)
        if bound is None:
            return
        if bound.principal == ANYBODY or authoriser.directory.name(bound.principal) == who:
            tap = ("tap", button.nonce, "memory", ACCOUNTS[who])
            base = tuple(command_id(*tap, str(n)) for n in range(LINES_AT_MOST))
            now_ns = self.clock.wall_ns()
            said = Said(who, button.command, base, now_ns, MessageValidity.FRESH, "", private=True)
            self.log.append(said)

    async def revoke(self, who: str) -> None:
        """Take somebody's access back, if the disk lets us."""
        if who in self.revoked or self.disk.broken or not self.disk.ready.is_set():
            return
        await ask_as_operator(self.gateway, AdminVerb.REVOKE, who)
        self.revoked.add(who)
        self.log.append(Revoked(who))

    # ---- things happen ----

    def robot(self, name: str) -> Recorder:
        """Return a robot."""
        robot = self.gateway.robots[name]
        assert isinstance(robot, Recorder)
        return robot

    async def turns(self, count: int) -> None:
        """Let the event loop turn that often, no more."""
        for _ in range(count):
            await asyncio.sleep(0)

    async def heal(self) -> None:
        """Everything works again, and there is time for everything."""
        self.disk.broken = False
        self.disk.ready.set()
        for name in self.gateway.robots:
            self.robot(name).mode = Mode.WELL
        for seconds in (1.0, 60.0, 700.0, 60.0):
            await self.clock.advance(seconds)
        self.disk.flush()


def cids_of(said: Said) -> dict[bytes, int]:
    """Return every id under which a message may act, and the line it belongs to."""
    found: dict[bytes, int] = {}
    for number, base in enumerate(said.base):
        found[base] = number
        found.update({robot_command_id(base, robot): number for robot in ROBOTS})
    return found
