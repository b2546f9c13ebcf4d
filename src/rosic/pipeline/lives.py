"""From a claimed order to an outcome that was told: relay, durable outcome, tell. In that order."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

import msgspec

from rosic.core.language import clean
from rosic.core.order import Ending, Order, Outcome, Report
from rosic.errors import Refusal, RobotUnreachable
from rosic.linker.linker import Linker, PolicyMoved

if TYPE_CHECKING:
    from rosic.container.container import Containers
    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Tell
    from rosic.core.identity import Caller, CommandId
    from rosic.organiser.organiser import Organiser
    from rosic.pipeline.cards import Card
    from rosic.pipeline.telling import Teller

AT_MOST = 20_000
NOTE_AT_MOST = 400

FULL = Outcome(Ending.REFUSED, "I have too much to do. This was not done.", code="full")
CUT_OFF = Outcome(Ending.CANCELLED, "ROSIC was shut down")
NEVER_BEGUN = Outcome(
    Ending.REFUSED, "ROSIC was shut down before this could begin. Nothing was done.", code="closed"
)

log = logging.getLogger("rosic.pipeline")


class Lives:
    """Every order under way, each in a task of its own: a long motion blocks nobody else."""

    def __init__(
        self,
        organiser: Organiser,
        container: Containers,
        linker: Linker,
        teller: Teller,
        clock: Clock,
    ) -> None:
        self._organiser = organiser
        self._container = container
        self._linker = linker
        self._teller = teller
        self._clock = clock
        self._tasks: set[asyncio.Task[None] | None] = set()
        # Those whose outcome is not known yet; once it is, nothing may keep it from being told.
        self._moving: set[asyncio.Task[None] | None] = set()

    def __len__(self) -> int:
        return len(self._tasks)

    def begin(self, order: Order, caller: Caller, card: Card) -> None:
        """Let a claimed order live. It will end, and its end will be told."""
        task = asyncio.create_task(self._live(order, caller, card))
        self._tasks.add(task)
        self._moving.add(task)

    async def _live(self, order: Order, caller: Caller, card: Card) -> None:
        try:
            full = len(self._tasks) > AT_MOST
            outcome = FULL if full else await self._relay(order, caller, card)
            self._moving.discard(asyncio.current_task())
            words = card.wording(order.cid, outcome, self._clock.wall_ns())
            await self._container.conclude(order, outcome, words)
            self._organiser.settle(order.permit)
            # Not before it is on disk: whoever reads the card meanwhile must not find the ending.
            card.end(order.cid, words)
            self._teller.show(card)
        finally:
            self._tasks.discard(asyncio.current_task())

    async def _relay(self, order: Order, caller: Caller, card: Card) -> Outcome:
        """RELAYCOMMAND: return what the robot did, whatever happens."""
        tell = self._reporter(card, order.cid)
        linker = self._linker
        begun = False
        try:
            if not linker.try_turn(order):
                await linker.turn(order, tell)
            begun = True
            try:
                return inert(await linker.dispatch(order, tell))
            except PolicyMoved:
                return inert(await self._relay_anew(order, caller, tell))
            finally:
                linker.leave(order)
        except Refusal as refusal:
            return Outcome(Ending.REFUSED, str(refusal), code=refusal.code)
        except asyncio.CancelledError:
            return CUT_OFF if begun else NEVER_BEGUN
        except RobotUnreachable as fault:
            log.warning("order %d of %s: %s", order.n, order.robot, fault)
            return Outcome(Ending.UNKNOWN, f"{fault} Please look.", code=fault.code)
        except Exception:
            log.exception("order %d of %s", order.n, order.robot)
            return Outcome(Ending.UNKNOWN, "Something went wrong here. Please look.", code="fault")

    async def _relay_anew(self, order: Order, caller: Caller, tell: Tell) -> Outcome:
        """Admit an order once more under the present policy, and relay it; its turn is kept."""
        while True:
            permit = self._organiser.readmit(caller, order)
            try:
                renewed = msgspec.structs.replace(order, permit=permit)
                return await self._linker.dispatch(renewed, tell)
            except PolicyMoved:
                continue

    def _reporter(self, card: Card, cid: CommandId) -> Tell:
        """Return what takes the reports of one order: a robot's words are made inert."""
        step, update, wall_ns = card.step, self._teller.update, self._clock.wall_ns

        def tell(report: Report) -> None:
            if report.note:
                report = Report(report.stage, report.fraction, clean(report.note)[:NOTE_AT_MOST])
            step(cid, report, wall_ns())
            update(card)

        return tell

    async def close(self) -> None:
        """Cancel what is under way: robots come to rest, the outcomes are written and told."""
        for task in tuple(self._moving):
            if task is not None:
                task.cancel()
        await asyncio.gather(*filter(None, self._tasks), return_exceptions=True)


def inert(outcome: Outcome) -> Outcome:
    """Return the outcome with a robot's words stripped of what could act on a reader."""
    if not outcome.note:
        return outcome
    return msgspec.structs.replace(outcome, note=clean(outcome.note)[:NOTE_AT_MOST])
