"""A robot that has each actuation counted in another process, which survives the gateway.

Registered as a stranger's adapter would be: by an entry point of the name ``counting``. See
`tests.journeys.gateway`.
"""

from __future__ import annotations

import asyncio
import os
from contextlib import suppress
from typing import TYPE_CHECKING

import msgspec

from rosic.core.order import Order, OrderEnding, OrderStage, Outcome, RestReport, StageReport, Stop
from rosic.core.robot.profile import Presence, Profile
from rosic.errors import ConfigurationError, RobotUnreachable

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Say, Tell
    from rosic.core.order_gate import OrderGate

PORT = "ROSIC_TEST_COUNTER_PORT"
PATIENCE_S = 1.0


class Event(msgspec.Struct, frozen=True, kw_only=True):
    """What a robot is told: to act (``cid`` is set), or to stop.

    Attributes:
        process: Of the gateway that told it.
    """

    robot: str
    generation: int
    process: int
    cid: str = ""
    n: int = 0
    fence: int = 0
    skill: str = ""


class Answer(msgspec.Struct, frozen=True, kw_only=True):
    """What the robot's side says to an actuation.

    Attributes:
        ending: ``done`` or ``failed``, after ``work_s``.
    """

    cid: str
    work_s: float
    ending: str


class CountingRobot:
    """Implements `contracts.robot.Robot`; its body is the counter at the other end of a socket."""

    stops_itself = True  # its counter is told of every stop, and answers

    def __init__(self, profile: Profile, gate: OrderGate, clock: Clock) -> None:
        self.profile = profile
        self.gate = gate
        self._clock = clock
        self._answers: dict[str, asyncio.Future[Answer]] = {}
        self._halted = asyncio.Event()
        self._writer: asyncio.StreamWriter | None = None
        self._listening: asyncio.Task[None] | None = None
        self._doing = ""

    async def open(self, say: Say) -> None:  # noqa: ARG002 - it says nothing of its own accord
        """Connect to the counter."""
        try:
            reader, self._writer = await asyncio.open_connection("127.0.0.1", int(os.environ[PORT]))
        except OSError as error:
            raise ConfigurationError("There is no counter.") from error
        self._listening = asyncio.create_task(self._listen(reader))

    async def close(self) -> None:
        """Disconnect."""
        if self._listening is not None:
            self._listening.cancel()
            await asyncio.gather(self._listening, return_exceptions=True)
        if self._writer is not None:
            self._writer.close()
            with suppress(OSError):
                await self._writer.wait_closed()

    async def _listen(self, reader: asyncio.StreamReader) -> None:
        while line := await reader.readline():
            answer = msgspec.json.decode(line, type=Answer)
            waiting = self._answers.pop(answer.cid, None)
            if waiting is not None and not waiting.done():
                waiting.set_result(answer)

    def _send(self, event: Event) -> None:
        assert self._writer is not None
        self._writer.write(msgspec.json.encode(event) + b"\n")

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Act once: nothing suspends between the gate and the socket."""
        self.gate.pass_order(order, self._clock.monotonic_ns(), self._clock.wall_ns())
        cid = order.cid.hex()
        answer = self._answers[cid] = asyncio.get_running_loop().create_future()
        permit = order.permit
        self._send(
            Event(
                robot=order.robot,
                generation=permit.stop_generation,
                process=os.getpid(),
                cid=cid,
                n=order.n,
                fence=permit.fence,
                skill=order.skill.id,
            )
        )
        tell(StageReport(OrderStage.SENT))
        self._doing = order.skill.id
        self._halted.clear()
        try:
            return await self._outcome(order, answer, tell)
        finally:
            self._doing = ""
            self._answers.pop(cid, None)

    async def _outcome(self, order: Order, coming: asyncio.Future[Answer], tell: Tell) -> Outcome:
        try:
            answer = await asyncio.wait_for(coming, PATIENCE_S)
        except TimeoutError:
            raise RobotUnreachable(f"{self.profile.shown} has not answered.") from None
        tell(StageReport(OrderStage.RECEIVED))
        tell(StageReport(OrderStage.RUNNING, 0.5))
        with suppress(TimeoutError):
            await asyncio.wait_for(self._halted.wait(), answer.work_s)
        if not self.gate.still_allows(order):
            return Outcome(OrderEnding.CANCELLED)
        return Outcome(OrderEnding(answer.ending))

    async def stop(self, stop: Stop) -> RestReport:
        """Latch, tell the counter, end what is under way."""
        self.gate.apply_stop(stop)
        self._send(Event(robot=stop.robot, generation=stop.generation, process=os.getpid()))
        self._halted.set()
        return RestReport(stop.robot, confirmed=True, seconds=0.0)

    async def resume(self, generation: int) -> None:
        """Undo the latch."""
        self.gate.resume(generation)

    def presence(self) -> Presence:
        """Always at hand."""
        return Presence(online=True, age_s=0.0, doing=self._doing, at_rest=not self._doing)
