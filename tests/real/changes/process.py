"""A gateway whose admins change things without a pause, until it is killed.

People numbered from some number on are let in with two rights each, get a series of times and
another key, are locked, and every third is revoked again. What was acknowledged is said through a
pipe. Piecemeal, records are written one by one: the fault that the test must find.
"""

from __future__ import annotations

import asyncio
import os
from itertools import count
from typing import TYPE_CHECKING

from rosic.app.admin.api import AdminVerb
from rosic.app.gateway import Gateway, GatewayParts, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.app.runtime import face_of
from rosic.authoriser.enrolment_records import CodeRedeemed
from rosic.authoriser.invitations import InvitationRequest, InvitedRights
from rosic.config.profiles import known_units
from rosic.core.identity import Address
from rosic.core.local_time import LocalTime
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Skill
from rosic.core.slot import Pattern
from rosic.features.access import AccessFeature
from rosic.features.access.messages import UNWRITTEN
from rosic.robots.memory import MemoryRobot
from rosic.stores.database import DatabaseStore
from rosic.stores.stop_latch import MemoryLatch
from rosic.system import SystemClock, SystemEntropy
from tests.gateway.place import ask_as_operator

if TYPE_CHECKING:
    from collections.abc import Iterator
    from multiprocessing.connection import Connection
    from pathlib import Path

    from rosic.core.records import Record

AT_ONCE = 4
TIMES = 10
ROBOTS = ("omni", "kuka1")
ADA = ConfiguredPerson("Ada", (Address("memory", "1"),), ("admin",))


class Piecemeal(DatabaseStore):
    """Writes what belongs together one by one."""

    async def write(self, *records: Record) -> None:
        for record in records:
            await super().write(record)


def a_gateway(store: DatabaseStore) -> Gateway:
    """Return a gateway over a record; nothing is opened."""
    profiles = tuple(
        Profile(id=name, link=Link(kind="memory"), skills={"wave": Skill(id="wave")})
        for name in ROBOTS
    )
    parts = GatewayParts(
        messengers=(),
        robot_factory=lambda _kind: MemoryRobot,
        store=store,
        latch=MemoryLatch(),
        clock=SystemClock(),
        entropy=SystemEntropy(),
        units=known_units(),
        face=face_of(),
    )
    return Gateway(GatewaySettings(profiles=profiles, people=(ADA,)), parts)


class Pipe:
    """Where things are said: what is in it outlives this process."""

    def __init__(self, connection: Connection) -> None:
        self._end = connection.fileno()

    def say(self, *words: object) -> None:
        """In one piece, at once."""
        os.write(self._end, (" ".join(map(str, words)) + "\n").encode())


class Admin:
    """Does to one person after another what admins do."""

    def __init__(self, gateway: Gateway, numbers: Iterator[int], pipe: Pipe) -> None:
        self._gateway = gateway
        self._access = gateway.access
        self._numbers = numbers
        self._say = pipe.say
        self._ada = gateway.rooms.authoriser.directory.named("Ada")[0].id

    async def run(self) -> None:
        """Go on until killed."""
        for number in self._numbers:
            who = await self._join(number)
            await self._book(number, who)
            async with self._access.changes.turn() as turn:
                await turn.write(self._access.keys.rotate(who, self._ada).records)
            self._say("rotated", number)
            async with self._access.changes.turn() as turn:
                await turn.act(self._access.locks.lock(who, self._ada))
            self._say("locked", number)
            if number % 3 == 0:
                await self._revoke(who)
                self._say("revoked", number)

    async def _join(self, number: int) -> str:
        access, enrolment = self._access, self._access.enrolment
        given = InvitedRights(roles=("operator", "viewer"), robots=ROBOTS, lasts_s=86_400.0)
        async with access.changes.turn() as turn:
            wanted = InvitationRequest(given=given, needs_confirmation=False)
            offer = enrolment.invitations.invite(wanted, self._ada)
            await turn.write(offer.records)
        async with access.changes.turn() as turn:
            answer = enrolment.redeem(
                offer.code.reveal(),
                Address("memory", f"x{number}"),
                private=True,
                name=f"Person {number}",
            )
            assert isinstance(answer, CodeRedeemed)
            await turn.write(
                self._gateway.features.get(AccessFeature).admitting.records(answer, self._ada)
            )
        self._say("joined", number)
        return answer.person.id

    async def _revoke(self, who: str) -> None:
        answer = await ask_as_operator(self._gateway, AdminVerb.REVOKE, who)
        assert UNWRITTEN not in answer

    async def _book(self, number: int, who: str) -> None:
        calendar = self._gateway.rooms.organiser.calendar
        minute, far = number % 1_440, number // 1_440
        first = LocalTime.at(_today() + 1 + far * TIMES)
        first = LocalTime(first.year, first.month, first.day, minute // 60, minute % 60)
        pattern = Pattern(first, 60, f"FREQ=DAILY;COUNT={TIMES}", "UTC")
        async with self._access.changes.turn() as turn:
            await turn.write(calendar.book_series(who, ROBOTS[number % 2], pattern, who))
        self._say("booked", number)


def _today() -> int:
    return SystemClock().wall_ns() // 86_400_000_000_000


async def _main(folder: Path, first: int, pipe: Pipe, *, piecemeal: bool) -> None:
    kind = Piecemeal if piecemeal else DatabaseStore
    gateway = a_gateway(kind(folder, clock=SystemClock()))
    await gateway.open()
    pipe.say("open")
    numbers = count(first)
    await asyncio.gather(*(Admin(gateway, numbers, pipe).run() for _ in range(AT_ONCE)))


def main(folder: Path, first: int, connection: Connection, piecemeal: bool) -> None:
    """Be the process."""
    asyncio.run(_main(folder, first, Pipe(connection), piecemeal=piecemeal))
