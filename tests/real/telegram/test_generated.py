"""Thousands of generated updates: each is handled or ignored, and none acts that must not (I17)."""

from __future__ import annotations

import logging
import os
import time
from collections import Counter
from random import Random
from typing import TYPE_CHECKING

import pytest

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from rosic.messengers.memory import MemoryMessenger
from rosic.messengers.telegram import incoming, updates
from rosic.messengers.telegram.messenger import TelegramMessenger, telegram_messenger
from rosic.messengers.telegram.polling_gap import PollMoment
from rosic.messengers.telegram.reading import UpdateHooks
from rosic.testing.clock import settle
from rosic.testing.messenger_harness import settled
from tests.gateway.place import Place
from tests.real.telegram.generated import ADA, BO, OWN, VI, Generator, May

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.testing.clock import ManualClock

TOKEN = "1:x"  # noqa: S105 - it opens nothing
PEOPLE = (
    ConfiguredPerson("Ada", (Address("telegram", str(ADA)),), ("admin",)),
    ConfiguredPerson("Bo", (Address("telegram", str(BO)),), ("viewer",)),
    ConfiguredPerson("Vi", (Address("telegram", str(VI)),), ("viewer",)),
)
ROBOTS = ("omni", "kuka1", "cf1", "cf2")
HOOKS = UpdateHooks(
    settle=settled,
    known=lambda _address: True,
    serves=lambda _chat: True,
    passed=lambda _event: None,
    reacted=lambda _reaction: None,
    account_since_ns=0,
    one_of_several=False,
)
SEED = int(os.environ.get("ROSIC_SEED", "1"))


class Talk(MemoryMessenger):
    """What a Telegram messenger says stays here; what it reads is fed to it."""

    platform = "telegram"


class TelegramPlace(Place):
    """Its people have accounts at Telegram."""

    people = PEOPLE


def _adapter(clock: Clock) -> TelegramMessenger:
    adapter = telegram_messenger("lab", {"token": TOKEN}, clock)
    adapter._listener.reading.begin(HOOKS, own_name=OWN, hears_groups=False)
    return adapter


class Run:
    """One run of many updates.

    Attributes:
        seen: How many there were of each kind and of what they did.
        wrong: What was done that must not be, or was not done that must be.
    """

    def __init__(self, place: Place, adapter: TelegramMessenger, seed: int) -> None:
        self._place = place
        self._listener = adapter._listener
        self._chance = Random(seed)  # noqa: S311 - a seed makes it repeatable
        self._generator = Generator(self._chance, lambda: place.clock.wall_ns() / 1e9)
        self.seen: Counter[str] = Counter()
        self.wrong: list[str] = []

    async def follow(self, count: int) -> None:
        """Feed so many updates, one after another, as one poll each."""
        for _ in range(count):
            await self._place.clock.advance(0.01)
            raw, may = self._generator.update()
            before = self._acted()
            await self._feed(raw)
            did = self._acted() - before
            stopped = self._latched()
            self.seen[f"{may.name} acted {did} stopped {bool(stopped)}"] += 1
            if did > (may in {May.MUST_ACT, May.MAY_ACT}) or (may is May.MUST_ACT and not did):
                self.wrong.append(f"{may.value}: it acted {did} times: {str(raw)[:600]}")
            if may is May.MUST_STOP and not stopped:
                self.wrong.append(f"{may.value}: nothing stopped: {str(raw)[:600]}")
            if stopped:
                await self._resume(stopped)

    async def _feed(self, raw: dict[str, object]) -> None:
        clock = self._place.clock
        listener, number = self._listener, updates.update_id(raw)
        if number is None:  # it can be neither handed over nor confirmed
            return
        received = incoming.ReceivedAt(clock.wall_ns(), listener._listening.stamp(clock.wall_ns()))
        update = listener.reading.parsed(raw)
        news = listener.reading.news(number, update, received, of_stranger=False)
        if news.inbound is not None:
            await self._place.gateway.pipeline.receive(self._place.chat, news.inbound)
        await self._quiet()

    async def _quiet(self) -> None:
        for _ in range(100):
            await settle()
            if (
                not len(self._place.gateway.pipeline.executor)
                and self._place.gateway.stop_lane.quiet
            ):
                return
        raise AssertionError("something does not come to an end")

    async def _resume(self, robots: tuple[str, ...]) -> None:
        await self._place.clock.advance(3.0)
        for robot in robots:
            number = 10**9 + self._chance.randrange(10**12)
            message = {
                "message_id": number,
                "date": int(self._place.clock.wall_ns() / 1e9) + 1,
                "chat": {"id": ADA, "type": "private"},
                "from": {"id": ADA, "first_name": "Ada"},
                "text": f"resume {robot}",
            }
            await self._feed({"update_id": number, "message": message})
        assert not self._latched(), "it could not be undone"

    def _acted(self) -> int:
        return sum(self._place.acted(name) for name in ROBOTS)

    def _latched(self) -> tuple[str, ...]:
        return tuple(name for name in ROBOTS if self._place.robot(name).gate.latched)


async def _run(count: int, caplog: pytest.LogCaptureFixture) -> Run:
    caplog.set_level(logging.ERROR)
    place = TelegramPlace(chat=lambda clock: Talk("lab", clock=clock))
    async with place.open():
        adapter = _adapter(place.clock)
        _listening(adapter, place.clock)
        run = Run(place, adapter, SEED)
        await run.follow(count)
    assert not [record for record in caplog.records if record.levelno >= logging.ERROR]
    assert run.wrong == [], f"seed {SEED}; {len(run.wrong)} wrong; the first: {run.wrong[:1]}"
    return run


def _listening(adapter: TelegramMessenger, clock: ManualClock) -> None:
    """Let it have drained its backlog."""
    listening = adapter._listener._listening
    for _ in range(2):
        now = PollMoment(clock.wall_ns(), clock.monotonic_ns())
        listening.answered(now)
        listening.drained(now, empty=True, full=False)
    assert not listening.frozen


def _check_that_something_happened(run: Run, count: int) -> None:
    """See that the run was none of refusals alone, which would prove nothing."""
    acted = run.seen["MUST_ACT acted 1 stopped False"]
    assert acted > count / 50, run.seen
    assert run.seen["MUST_STOP acted 0 stopped True"] > count / 50, run.seen
    assert sum(n for what, n in run.seen.items() if what.startswith("NOTHING")) > count / 3


async def test_2000_generated_updates(caplog: pytest.LogCaptureFixture) -> None:
    run = await _run(2_000, caplog)
    _check_that_something_happened(run, 2_000)


@pytest.mark.campaign
@pytest.mark.limit(1800)
async def test_50000_generated_updates(caplog: pytest.LogCaptureFixture) -> None:
    begun_s = time.monotonic()
    run = await _run(50_000, caplog)
    _check_that_something_happened(run, 50_000)
    print(f"50,000 updates in {time.monotonic() - begun_s:.0f} s: {dict(run.seen)}")  # noqa: T201
