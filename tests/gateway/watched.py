"""Disk, stop file, messenger, gates and robots that write down what they are asked to do."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.core.order_gate import OrderGate
from rosic.errors import RobotOffline, RobotUnreachable, StoreFault
from rosic.robots.memory import CANCELLED, DONE, RECEIVED, SENT, MemoryRobot
from rosic.stores.stop_latch import MemoryLatch

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from rosic.contracts.messenger import Receive
    from rosic.contracts.robot import Tell
    from rosic.core.message import Chat, Inbound, IncomingFile, Outbound
    from rosic.core.order import Order, Outcome, Stop
    from rosic.core.records import Memory, Record
    from rosic.messengers.memory import MemoryMessenger
    from tests.gateway.histories import World
from tests.gateway.events import Acted, Event, Kept, Latched, Mode, Unlatched, Written

LINES_AT_MOST = 3


# ---- one run of a gateway ----


class Disk:
    """What one run sees of the disk: slow, broken, or gone with the run. Notes come late."""

    def __init__(self, world: World) -> None:
        self.broken = False
        self.dead = False
        self.ready = asyncio.Event()
        self.ready.set()
        self._world = world
        self._one = asyncio.Lock()
        self._notes: list[tuple[Record, ...]] = []
        self._keeping: set[asyncio.Task[None]] = set()

    async def open(self) -> Memory:
        return await self._world.store.open()

    async def close(self) -> None:
        self.flush()

    async def write(self, *records: Record) -> None:
        # What was handed over is written although whoever asked for it is cancelled meanwhile.
        writing = asyncio.ensure_future(self._write(records))
        try:
            await asyncio.shield(writing)
        except asyncio.CancelledError as cancelled:
            await asyncio.wait((writing,))
            raise cancelled from (None if writing.cancelled() else writing.exception())

    async def _write(self, records: tuple[Record, ...]) -> None:
        async with self._one:
            await self.ready.wait()
            self.flush()
            if self.broken or self.dead:
                raise StoreFault("the disk is full")
            await self._world.store.write(*records)
            self._world.log.append(Written(records))

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        task = asyncio.ensure_future(self._keep(record, then))
        self._keeping.add(task)
        task.add_done_callback(self._keeping.discard)

    async def _keep(self, record: Record, then: Callable[[], None]) -> None:
        try:
            await self._write((record,))
        except StoreFault:
            self.note(record)
        then()

    def note(self, *records: Record) -> None:
        if not self.dead:
            self._notes.append(records)

    def flush(self) -> None:
        """Write what was noted, unless the disk is broken: then it waits."""
        if not self.broken and not self.dead:
            for records in self._notes:
                self._world.store.note(*records)
                self._world.log.append(Written(records))
            self._notes.clear()


class StopFile(MemoryLatch):
    """What outlives a gateway of its stops."""

    def __init__(self, log: list[Event]) -> None:
        super().__init__()
        self._log = log

    async def write(self, robot: str, generation: int, *, latched: bool) -> None:
        await super().write(robot, generation, latched=latched)
        self._log.append(Kept(robot, *self.read()[robot]))


class Mouth:
    """The messenger as one run has it: silent once the run is dead."""

    platform = "memory"
    name = "memory"
    assurance = "local"

    def __init__(self, chat: MemoryMessenger, disk: Disk) -> None:
        self.edits = chat.edits
        self.file_bytes = chat.file_bytes
        self.fetch_bytes = chat.fetch_bytes
        self.pins = chat.pins
        self._chat = chat
        self._disk = disk

    async def run(self, receive: Receive) -> None:
        await self._chat.run(receive)

    async def send(self, outbound: Outbound) -> str:
        await self._alive()
        return await self._chat.send(outbound)

    async def edit(self, message: str, outbound: Outbound) -> None:
        await self._alive()
        await self._chat.edit(message, outbound)

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:
        await self._alive()
        await self._chat.pin(chat, message, pinned=pinned)

    async def answer_tap(self, inbound: Inbound, text: str) -> None:
        await self._alive()
        await self._chat.answer_tap(inbound, text)

    def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        return self._chat.fetch(enclosure)

    async def _alive(self) -> None:
        if self._disk.dead:
            await asyncio.Event().wait()


class WatchedGate(OrderGate):
    """A gate that writes down when it closes and opens. It decides nothing differently."""

    __slots__ = ("_log",)

    def __init__(self, gate: OrderGate, log: list[Event]) -> None:
        super().__init__(
            gate.robot,
            n=gate.n,
            fence=gate.fence,
            generation=gate.generation,
            latched=gate.latched,
        )
        self._log = log

    def apply_stop(self, stop: Stop) -> None:
        newer = stop.generation > self.generation
        super().apply_stop(stop)
        if newer:
            self._log.append(Latched(self.robot, stop.generation))

    def resume(self, generation: int) -> None:
        before = self.latched
        super().resume(generation)
        if before and not self.latched:
            self._log.append(Unlatched(self.robot))


class Recorder(MemoryRobot):
    """Writes down every actuation, takes its time on the test's clock, and can fail."""

    world: World
    mode = Mode.WELL
    rest_s = 0.0
    _rests_ns = 0

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Act once, unless it fails before."""
        if self.mode is Mode.OFFLINE:
            raise RobotOffline(f"{self.profile.shown} is not there. Nothing was sent.")
        self.gate.pass_order(order, self._clock.monotonic_ns(), self._clock.wall_ns())
        tell(SENT)
        if self.mode is Mode.LOST_BEFORE:
            raise RobotUnreachable(f"{self.profile.shown} does not answer.")
        self._act(order)
        if self.mode is Mode.LOST_AFTER:
            raise RobotUnreachable(f"{self.profile.shown} does not answer.")
        if self.mode is Mode.BREAKS:
            raise ZeroDivisionError
        tell(RECEIVED)
        self._doing = order
        try:
            await self._work()
        finally:
            self._doing = None
        return DONE if self.gate.still_allows(order) else CANCELLED

    def _act(self, order: Order) -> None:
        permit, skill = order.permit, order.skill
        self.world.log.append(
            Acted(
                self.profile.id,
                order.cid,
                order.n,
                permit.fence,
                permit.stop_generation,
                self._clock.wall_ns(),
                skill.order_lifetime_ns / 1e9,
                skill.actuates,
                self._doing is not None or self._clock.monotonic_ns() < self._rests_ns,
            )
        )
        self.acted.append(order.n)

    async def _work(self) -> None:
        end = self._end = asyncio.get_running_loop().create_future()
        timer = asyncio.ensure_future(self._clock.sleep(self.work_s))
        try:
            await asyncio.wait((timer, end), return_when=asyncio.FIRST_COMPLETED)
        except asyncio.CancelledError:
            if self.rest_s and not self.world.disk.dead:  # at rest before it leaves
                self._rests_ns = self._clock.monotonic_ns() + int(self.rest_s * 1e9)
                await self._clock.sleep(self.rest_s)
            raise
        finally:
            timer.cancel()
