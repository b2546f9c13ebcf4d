"""Gateways with one faulty part: for seeing that a journey can fail."""

from __future__ import annotations

import asyncio
import signal
from typing import TYPE_CHECKING

import msgspec

from rosic.app.builder import latch_of, parts_of, secrets_of, settings_of
from rosic.app.closing import close_in_time
from rosic.app.config import load_config
from rosic.app.gateway import Gateway, GatewayParts
from rosic.app.logging import log_to_standard_error
from rosic.app.runtime import face_of
from rosic.core.records import Claimed, Concluded, Memory, Record, Refused
from rosic.errors import Repeated
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.store import Store

LATE_S = 0.3


class Faulty:
    """A store that passes everything on."""

    def __init__(self, good: Store) -> None:
        self._good = good

    async def open(self) -> Memory:
        return await self._good.open()

    async def close(self) -> None:
        await self._good.close()

    async def write(self, *records: Record) -> None:
        await self._good.write(*records)

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        self._good.keep(record, then)

    def note(self, *records: Record) -> None:
        self._good.note(*records)


class ForgetsDuplicates(Faulty):
    """Says that a message is new, however often it was settled."""

    async def write(self, *records: Record) -> None:
        try:
            await self._good.write(*records)
        except Repeated:
            return


class ClaimsAfterwards(Faulty):
    """Lets the robot act first: a claim is written only a while later, or with its outcome."""

    def __init__(self, good: Store) -> None:
        super().__init__(good)
        self._owed: dict[bytes, Claimed] = {}
        self._paying: set[asyncio.Task[None]] = set()

    async def write(self, *records: Record) -> None:
        claims = [record for record in records if isinstance(record, Claimed)]
        if claims:
            for claim in claims:
                self._owed[claim.cid] = claim
                task = asyncio.create_task(self._pay_later(claim.cid))
                self._paying.add(task)
                task.add_done_callback(self._paying.discard)
            return
        for record in records:
            if isinstance(record, Concluded | Refused):
                await self._pay(record.cid)
        await self._good.write(*records)

    async def _pay_later(self, cid: bytes) -> None:
        await asyncio.sleep(LATE_S)
        await self._pay(cid)

    async def _pay(self, cid: bytes) -> None:
        claim = self._owed.pop(cid, None)
        if claim is not None:
            await self._good.write(claim)


class ForgetsNumbers(Faulty):
    """Begins to count orders and leases anew at every start."""

    async def open(self) -> Memory:
        return msgspec.structs.replace(await self._good.open(), numbers={})


class ForgetsTheUnfinished(Faulty):
    """Tells nobody what the last run did not."""

    async def open(self) -> Memory:
        return msgspec.structs.replace(await self._good.open(), unfinished=())


async def serve(config_file: str, faulty: Callable[[Store], Store]) -> None:
    """Run a gateway as `rosic run` does, with this store in place of the good one."""
    config, clock = load_config(config_file), SystemClock()
    log_to_standard_error(config.log_level.value, face_of(), secrets_of(config))
    latch = latch_of(config)
    parts: GatewayParts = parts_of(config, latch, clock, SystemEntropy())
    parts = msgspec.structs.replace(parts, store=faulty(parts.store))
    gateway = Gateway(settings_of(config), parts)
    ended = asyncio.Event()
    asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, ended.set)
    await gateway.open()
    running = asyncio.create_task(gateway.run())
    await ended.wait()
    running.cancel()
    await close_in_time(gateway)
    await latch.close()


FAULTS: dict[str, Callable[[Store], Store]] = {
    "dedup-off": ForgetsDuplicates,
    "claim-after-act": ClaimsAfterwards,
    "numbers-forgotten": ForgetsNumbers,
    "unfinished-forgotten": ForgetsTheUnfinished,
}
