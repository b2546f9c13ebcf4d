"""I12: two hundred people ask for one robot at once, and exactly one of them has it."""

from __future__ import annotations

import asyncio
from collections import Counter
from random import Random
from typing import TYPE_CHECKING

import msgspec
import pytest

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from rosic.core.message import Chat, Inbound
from rosic.stores.memory import MemoryStore
from tests.gateway.place import Place

if TYPE_CHECKING:
    from rosic.core.lease import Lease
    from rosic.core.records import Record

PEOPLE = 200
IDLE_S = 30.0
WHEN = "You can have it when that ends and it has been idle for 30 s."
SETTLED_WITHIN_TURNS = 10_000


class UnevenStore(MemoryStore):
    """Lets others run while it writes, now for longer, now for less."""

    def __init__(self, chance: Random) -> None:
        super().__init__()
        self._chance = chance

    async def write(self, *records: Record) -> None:
        for _ in range(self._chance.randrange(4)):
            await asyncio.sleep(0)
        await super().write(*records)
        for _ in range(self._chance.randrange(3)):
            await asyncio.sleep(0)


class Rush:
    """A gateway with as many operators as ask, and one robot that works until it is told."""

    def __init__(self, seed: int) -> None:
        self.chance = Random(seed)  # noqa: S311 - a seed makes it repeatable
        self.place = Place(UnevenStore(self.chance))
        people = tuple(
            ConfiguredPerson(f"Person {n}", (Address("memory", str(n)),), ("operator",))
            for n in range(PEOPLE)
        )
        gateway = self.place.gateway
        gateway._settings = msgspec.structs.replace(gateway._settings, people=people)
        self.serial = 0

    @property
    def lease(self) -> Lease:
        return self.place.gateway.rooms.organiser.lease("omni")

    async def ask(self, account: int) -> None:
        """Hand one request over, a few turns of the event loop sooner or later."""
        for _ in range(self.chance.randrange(3)):
            await asyncio.sleep(0)
        self.serial += 1
        now_ns = self.place.clock.wall_ns()
        inbound = Inbound(
            sender=Address("memory", str(account)),
            chat=Chat("memory", str(account)),
            message=str(self.serial),
            text="omni wave",
            sent_ns=now_ns,
            received_ns=now_ns,
        )
        await self.place.gateway.pipeline.receive(self.place.chat, inbound)

    async def round(self) -> tuple[str, Counter[str]]:
        """Let all ask at once. Return who has the robot and what everybody else was told."""
        place, robot = self.place, self.place.robot("omni")
        fence, acted = self.lease.fence, len(robot.acted)
        robot.work_s = 3_600.0
        place.chat.told.clear()
        everybody = list(range(PEOPLE))
        self.chance.shuffle(everybody)
        await asyncio.gather(*map(self.ask, everybody))
        answers: dict[str, str] = {}
        for _ in range(SETTLED_WITHIN_TURNS):
            await asyncio.sleep(0)
            answers = {told.outbound.chat.id: told.outbound.text for told in place.chat.told}
            if len(answers) == PEOPLE and robot.presence().doing:
                break
        assert self.lease.fence == fence + 1, "one grant is one number"
        assert self.lease.active == 1
        assert len(robot.acted) == acted + 1
        person = place.gateway.rooms.authoriser.directory.person(self.lease.holder or "")
        assert person is not None
        has = answers.pop(person.addresses[0].account)
        assert has.startswith("omni: wave\n"), has
        await self._becomes_free()
        return person.name, Counter(answers.values())

    async def _becomes_free(self) -> None:
        robot = self.place.robot("omni")
        assert robot._end is not None
        robot._end.set_result(None)
        for _ in range(SETTLED_WITHIN_TURNS):
            await asyncio.sleep(0)
            if self.place.gateway.quiet:
                break
        assert self.place.gateway.quiet
        await self.place.clock.advance(IDLE_S + 1)


async def rush(rounds: int) -> None:
    """Let all ask at once, again and again."""
    crowd = Rush(seed=12)
    winners = set()
    async with crowd.place.open():
        for _ in range(rounds):
            holder, told = await crowd.round()
            sentence = f"omni is taken by {holder}. {WHEN}"
            assert told == {sentence: PEOPLE - 1}
            winners.add(holder)
    assert len(winners) > min(rounds, PEOPLE) // 4, "chance decides who is first"


async def test_one_of_two_hundred_has_the_robot_over_50_rounds() -> None:
    await rush(50)


@pytest.mark.campaign
@pytest.mark.limit(1800)
async def test_one_of_two_hundred_has_the_robot_over_1000_rounds() -> None:
    await rush(1_000)
