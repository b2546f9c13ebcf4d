"""People who command robots for hours through a messenger, faults between, and who was told what.

Everybody has a chat and a robot of their own. An order counts as told once a reply to it says how
it ended, or that it was refused; or once a summary counts it that came after an absence.
"""

from __future__ import annotations

import asyncio
import os
import re
import signal
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rosic.bench.bot_api_process import TOKEN
from rosic.bench.gateway_process import LOCAL
from rosic.core.order import OrderEnding
from rosic.core.order_status import ended_as

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence
    from pathlib import Path

    from rosic.testing.telegram import Control

LOOK_S: Final = 2.0
SETTLES_S: Final = 90.0
CELLS: Final = 18
MOVING: Final = (
    ("omni", ("omni move 0.05 m", "omni move back 0.05 m")),
    ("kuka1", ("kuka1 home",)),
    ("yumi", ("yumi home",)),
    ("cf1", ("cf1 takeoff 0.2 m", "cf1 land")),
    ("cf2", ("cf2 takeoff 0.2 m", "cf2 land")),
    ("cf3", ("cf3 takeoff 0.2 m", "cf3 land")),
)
MOVING_EVERY_S, CELL_EVERY_S = 4.0, 2.0
"""Half of a message or edit a second, each: an order that moves takes two, another one."""

CONFIG: Final = """\
[gateway]
name = "bench"
data = "data"

[[messenger]]
kind = "telegram"
token = "{token}"
api_base = "{api_base}"

[metrics]
listen = "{listen}"

[[principal]]
name = "Ada"
address = "telegram:{admin}"
role = "admin"
"""
PERSON: Final = """
[[principal]]
name = "Person {number}"
address = "telegram:{account}"
role = "operator"
"""
ROBOT: Final = """
[[robot]]
profile = "{profile}"
link = "{link}"
"""
CELL: Final = """\
id: cell{number}
link: {{ kind: memory }}
skills:
  sort: {{ class: task }}
"""

FAULT_EVERY_S: Final = 30.0
AWAY_S: Final = 3.0
STILL_S: Final = 1.5
"""Longer than simulated robots wait for a sign of life: they hold as if their link was lost."""
FORGETS_S: Final = 60.0
ABSENCE: Final = re.compile(r"While .*?(\d+) commands? came in here")
STEPS: Final = ("accepted", "waiting its turn", "sent ", "received", "running")
DECLINED: Final = "Nothing was done."
"""By this ends what a robot says that refuses an order which was sent to it."""
ENDS: Final = tuple(ended_as(ending.value) for ending in OrderEnding)
DONE: Final = ended_as(OrderEnding.DONE.value)


def is_told(text: str) -> bool:
    """Return whether a reply to an order says its end: that of a life, or a refusal."""
    lines = text.split("\n")[1:]
    alive = any(line.startswith(STEPS) for line in lines[:1])
    return not alive or any(line.startswith(ENDS) or line.endswith(DECLINED) for line in lines)


class SoakPerson(NamedTuple):
    """Somebody with a robot.

    Attributes:
        account: Also the id of their chat.
        says: Their orders, in turns.
        every_s: How often.
    """

    account: int
    says: tuple[str, ...]
    every_s: float


async def open_accounts(control: Control) -> list[SoakPerson]:
    """Open the accounts."""
    said = [(says, MOVING_EVERY_S) for _, says in MOVING]
    said += [((f"cell{number} sort",), CELL_EVERY_S) for number in range(CELLS)]
    return [
        SoakPerson(await control.create_user(f"Person {number}"), says, every_s)
        for number, (says, every_s) in enumerate(said)
    ]


def write_config(
    folder: Path, control: Control, admin: int, people: Sequence[SoakPerson], port: int
) -> str:
    """Write the profiles; return the configuration."""
    text = CONFIG.format(
        token=TOKEN, api_base=control.api_base, listen=f"{LOCAL}:{port}", admin=admin
    )
    for number, person in enumerate(people):
        text += PERSON.format(number=number, account=person.account)
    for name, _ in MOVING:
        text += ROBOT.format(profile=name, link="simulated")
    for number in range(CELLS):
        file = folder / f"cell{number}.yaml"
        file.write_text(CELL.format(number=number), encoding="utf-8")
        text += ROBOT.format(profile=file.name, link="memory")
    return text


async def await_answer(control: Control, admin: int) -> None:
    """Wait until the gateway answers.

    Raises:
        TimeoutError: It does not.
    """
    said = await control.say(admin, admin, "status")
    async with asyncio.timeout(SETTLES_S):
        while not await control.messages(admin, by_bot=True, after=said):  # noqa: ASYNC110 - the same
            await asyncio.sleep(LOOK_S / 8)


# ---- who was told what ----


class PlacedOrders:
    """Every order that was placed, until it is told how it ended.

    Attributes:
        placed: How many.
        told_ns: From before it is said to the end that is told, by the server's clock.
        done: How many were told to be done.
        summed: How many were told in a summary, together.
    """

    def __init__(self, control: Control) -> None:
        self._control = control
        self._open: dict[int, dict[int, float]] = {}
        self._summaries: dict[tuple[int, int], int] = {}
        self.placed = self.summed = self.done = 0
        self.told_ns: list[float] = []

    async def place(self, person: int, text: str) -> None:
        """Say an order in somebody's private chat."""
        said_s = time.time()  # before it is taken: a server that stands still is no free time
        message = await self._control.say(person, person, text)
        self._open.setdefault(person, {})[message] = said_s
        self.placed += 1

    @property
    def lost(self) -> int:
        """How many have not been told their end."""
        return sum(map(len, self._open.values()))

    async def look(self) -> int:
        """Read what was told since; return how many orders are not told yet."""
        for person, waiting in self._open.items():
            if waiting:
                found = await self._control.messages(person, by_bot=True, after=min(waiting))
                self._replies(waiting, found)
                self._absences(person, waiting, found)
        return self.lost

    def _replies(self, waiting: dict[int, float], found: Sequence[dict[str, Any]]) -> None:
        for message in found:
            said_s = waiting.get(message["reply_to"] or 0)
            if said_s is not None and is_told(message["text"] or ""):
                del waiting[message["reply_to"]]
                told_s = message["versions"][-1]["received_s"]
                self.told_ns.append((told_s - said_s) * 1e9)
                self.done += any(line.startswith(DONE) for line in message["text"].split("\n"))

    def _absences(
        self, person: int, waiting: dict[int, float], found: Sequence[dict[str, Any]]
    ) -> None:
        """Take those off that a summary counts: the oldest that came before it."""
        for message in found:
            counted = ABSENCE.search(message["text"] or "")
            key = person, message["message_id"]
            more = int(counted[1]) - self._summaries.get(key, 0) if counted else 0
            for number in [one for one in waiting if one < message["message_id"]][:more]:
                del waiting[number]
                self.summed += 1
                self._summaries[key] = self._summaries.get(key, 0) + 1


class SoakPlace(NamedTuple):
    """What a fault can reach.

    Attributes:
        admin: May stop and resume; has no robot.
        stranger: Is not known to the gateway.
        gateway: Its process.
        port: On which it says its figures.
    """

    control: Control
    admin: int
    stranger: int
    gateway: int
    port: int


async def _network_away(place: SoakPlace) -> None:
    await place.control.fail("reset", times=1_000_000)
    await asyncio.sleep(AWAY_S)
    await place.control.call("calm")


async def _too_many(place: SoakPlace) -> None:
    await place.control.fail("too_many_requests", "sendMessage", times=5, retry_after_s=2)


async def _internal_errors(place: SoakPlace) -> None:
    await place.control.fail("error", times=10)


async def _bad_gateway(place: SoakPlace) -> None:
    await place.control.fail("bad_gateway", "getUpdates", times=5)


async def _answers_lost(place: SoakPlace) -> None:
    await place.control.fail("drop_answer", "editMessageText", times=5)


async def _polls_hang(place: SoakPlace) -> None:
    await place.control.fail("hang", "getUpdates", times=1, seconds=AWAY_S)


async def _flood(place: SoakPlace) -> None:
    await place.control.backlog(place.stranger, place.stranger, "stop \ufdfa" * 600, 60)


async def _standstill(place: SoakPlace) -> None:
    os.kill(place.gateway, signal.SIGSTOP)
    try:
        await asyncio.sleep(STILL_S)
    finally:
        os.kill(place.gateway, signal.SIGCONT)


async def _full_outbox(place: SoakPlace) -> None:
    await place.control.backlog(place.admin, place.admin, "status", 25)


async def _stop_and_resume(place: SoakPlace) -> None:
    await place.control.say(place.admin, place.admin, "stop")
    await asyncio.sleep(AWAY_S)
    await place.control.say(place.admin, place.admin, "resume all")


async def _half_requests(place: SoakPlace) -> None:
    for _ in range(20):
        with suppress(OSError):
            _, writer = await asyncio.open_connection(LOCAL, place.port)
            writer.write(b"GET /metr")
            writer.close()
            await writer.wait_closed()


FAULTS: Final[tuple[tuple[str, Callable[[SoakPlace], Awaitable[None]]], ...]] = (
    (f"connections to the Bot API are reset for {AWAY_S:g} s", _network_away),
    ("five messages meet a 429 of 2 s", _too_many),
    ("ten calls meet a 500", _internal_errors),
    ("five polls meet a 502", _bad_gateway),
    ("five answers are lost after the call took effect", _answers_lost),
    (f"a poll hangs for {AWAY_S:g} s", _polls_hang),
    ("a stranger sends 60 messages of 3,600 characters", _flood),
    (f"the gateway stands still for {STILL_S:g} s, and robots miss its sign of life", _standstill),
    ("25 answers wait for one chat", _full_outbox),
    ("every robot is stopped, and resumed", _stop_and_resume),
    ("20 connections end in the middle of a request", _half_requests),
)


class Soak:
    """The load, and the faults.

    Attributes:
        orders: Of every order.
        faults: How often each fault was there.
    """

    def __init__(self, place: SoakPlace, people: Sequence[SoakPerson], *, faulty: bool) -> None:
        self.orders = PlacedOrders(place.control)
        self.faults = dict.fromkeys((name for name, _ in FAULTS), 0) if faulty else {}
        self._place, self._people = place, people

    async def run(self, lasts_s: float) -> None:
        """Give orders for so long, then wait until each is told, or too long for it."""
        end_s = time.monotonic() + lasts_s
        async with asyncio.TaskGroup() as together:
            for number, person in enumerate(self._people):
                later_s = person.every_s * number / len(self._people)
                together.create_task(self._command(person, later_s, end_s))
            together.create_task(self._look(end_s))
            if self.faults:
                together.create_task(self._disturb(end_s))
        with suppress(TimeoutError):
            async with asyncio.timeout(SETTLES_S):
                while await self.orders.look():  # noqa: ASYNC110 - another process
                    await asyncio.sleep(LOOK_S)

    async def _command(self, person: SoakPerson, later_s: float, end_s: float) -> None:
        """Say an order each time it is due, whatever became of the last: an open loop."""
        due_s, number = time.monotonic() + later_s, 0
        while due_s < end_s:
            await asyncio.sleep(max(0.0, due_s - time.monotonic()))
            await self.orders.place(person.account, person.says[number % len(person.says)])
            due_s, number = due_s + person.every_s, number + 1

    async def _look(self, end_s: float) -> None:
        cleared_s = time.monotonic()
        while time.monotonic() < end_s:
            await self.orders.look()
            if time.monotonic() - cleared_s > FORGETS_S:
                await self._place.control.call("clear_record")
                cleared_s = time.monotonic()
            await asyncio.sleep(LOOK_S)

    async def _disturb(self, end_s: float) -> None:
        number = 0
        while time.monotonic() + FAULT_EVERY_S < end_s:
            await asyncio.sleep(FAULT_EVERY_S)
            name, fault = FAULTS[number % len(FAULTS)]
            await fault(self._place)
            self.faults[name] += 1
            number += 1
