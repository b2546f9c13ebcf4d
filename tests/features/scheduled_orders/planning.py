"""A place whose robots work until they are told how it ended, and where orders are planned."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.features.scheduled_orders import ScheduledOrdersFeature
from rosic.testing.clock import ManualClock
from tests.features.fleet.test_tasks import Warehouse, Worker
from tests.gateway.place import ADA, FLEET, Place, WritingStore

if TYPE_CHECKING:
    from rosic.core.records import Record
    from rosic.core.robot.profile import Profile
    from rosic.features.scheduled_orders.schedule import OrderSchedule
    from rosic.stores.memory import MemoryStore

BERLIN = "Europe/Berlin"
SATURDAY_NS = 1_795_255_200_000_000_000
"""21 November 2026, 10:00 UTC: 11:00 in Berlin."""
MINUTE_S, HOUR_S, DAY_S = 60.0, 3600.0, 86_400.0


def lab(
    store: MemoryStore | None = None,
    *,
    now_ns: int = SATURDAY_NS,
    fleet: tuple[Profile, ...] = FLEET,
    zone: str = BERLIN,
    place: type[Place] = Warehouse,
) -> Place:
    here = place(store, clock=ManualClock(now_ns), fleet=fleet)
    here.gateway._settings = replace(here.gateway._settings, zone=zone)
    return here


def quick(here: Place, *names: str) -> None:
    """Let robots do at once what they are asked."""
    for name in names or ("omni", "kuka1", "cf1", "cf2"):
        worker(here, name).work_s = 1e-9


def worker(here: Place, name: str = "omni") -> Worker:
    found = here.robot(name)
    assert isinstance(found, Worker)
    return found


def schedule(here: Place) -> OrderSchedule:
    return here.gateway.features.get(ScheduledOrdersFeature).schedule


async def plan(here: Place, line: str, account: str = ADA) -> str:
    """Say a plan and let it stand; return what was told then."""
    await here.say(line, account=account, chat=account)
    button, under = here.button("Plan it")
    return await here.tap(button, under, account=account)


async def later(here: Place, seconds: float, account: str = ADA) -> str:
    """Let time pass; return what one person was told meanwhile."""
    before = len(here.chat.told)
    here.clock.jump_wall(seconds - 3)
    for _ in range(12):
        await here.clock.advance(0.5)
        await here.quiet()
    return "\n".join(
        told.outbound.text
        for told in list(here.chat.told)[before:]
        if told.outbound.chat.id == account
    )


async def next_time(here: Place, account: str = ADA) -> str:
    """Let time pass until the next of what is planned has had its time."""
    kept = schedule(here)
    at_ns = min(at_ns for at_ns in kept.next_ns.values() if at_ns is not None)
    return await later(here, (at_ns - here.clock.wall_ns()) / 1e9, account)


class Recording(WritingStore):
    """Keeps what was written, in order."""

    def __init__(self) -> None:
        super().__init__()
        self.written: list[Record] = []

    async def write(self, *records: Record) -> None:
        await super().write(*records)
        self.written += records
