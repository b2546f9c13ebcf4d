"""Telegram: the paper's Algorithm 11 under Telegram's limits, and what receiving costs."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import msgspec

from rosic.app import loop
from rosic.bench.batches import ROUND_TRIP_S, Batch, Found, through_a_loop, through_rosic
from rosic.bench.receiving import findings, received
from rosic.bench.report import Case, Report, case_of, machine
from rosic.bench.stand_in import stand_in

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.testing.telegram import Control

AT_LEAST = 0.95
SIZES = (10, 50, 100, 500)
FULL = (
    *(Batch(name=f"{size} commands, 10 chats", commands=size) for size in SIZES),
    Batch(name="500 commands, 50 chats", commands=500, chats=50),
)
QUICK = (Batch(name="50 commands, 10 chats, 1.5 times as fast", commands=50, faster=1.5),)
METHOD = (
    "Algorithm 11: each batch is said at once, in equal shares, by people in chats of their own to "
    "robots in memory, through a gateway with its record on disk, over a stand-in for Telegram's "
    "Bot API in a process of its own with the published limits (1 message or edit a second in a "
    "chat, 30 in all; bursts of 5, a guess) and {round_trip_ms:.0f} ms for every call. Rate: "
    "outcomes a second after the burst, and the share of what is permitted is that of messages "
    "and edits; where all fits into the burst, over the whole time. p50 and p99: from a command "
    "to its outcome, as the server dates them. A run with a 429, a lost or a doubled outcome, or "
    "a stop answered after an outcome that waited is no result. Stops are said while outcomes "
    "wait in the same chat; their times run to the first answer. The naive sender is a plain loop "
    "over the same outcomes, ready from the start: it sends each at once, waits as a 429 asks and "
    "goes on; rate and share are over the whole time, bursts included. Receiving: from an update "
    "as the connection gives it, until the robot's adapter has the order; one at a time, {orders} "
    "updates of each kind in turns; python-telegram-bot's side is Update.de_json and "
    "process_update until an empty handler is called, without its queue; the disk's own time for "
    "one page is beside them, as a durable claim takes at least that, and so is such a claim on "
    "a file system in memory. Event loop: {loop}."
)


def measure(*, quick: bool = False) -> Report:
    """Run every batch through ROSIC and through the naive sender, then measure receiving."""
    logging.getLogger("rosic").setLevel(logging.ERROR)
    orders = 200 if quick else 2_000
    cases, seen = loop.run(_run(QUICK if quick else FULL, orders))
    method = METHOD.format(round_trip_ms=ROUND_TRIP_S * 1e3, loop=loop.name(), orders=orders)
    return Report(machine=machine(), method=method, cases=tuple(cases), findings=seen)


async def _run(batches: Iterable[Batch], orders: int) -> tuple[list[Case], tuple[str, ...]]:
    cases: list[Case] = []
    async with stand_in() as control:
        for batch in batches:
            cases += await _batch(control, batch)
        found = await received(control, orders)
    cases += [
        case_of(name, [(1e9 * len(times) / sum(times), times)]) for name, times in found.items()
    ]
    return cases, findings(found)


async def _batch(control: Control, batch: Batch) -> list[Case]:
    found = await through_rosic(control, batch)
    _check(batch, found)
    naive = await through_a_loop(control, batch)
    stops = [(1e9 * len(found.stop_ns) / sum(found.stop_ns), found.stop_ns)]
    return [
        _case(batch.name, found),
        case_of(f"{batch.name}: stops meanwhile", stops),
        _case(f"{batch.name}: naive, {naive.too_many} times 429", naive),
    ]


def _case(name: str, found: Found) -> Case:
    case = case_of(name, [(found.rate_per_s, found.waited_ns)])
    return msgspec.structs.replace(case, permitted_share=round(found.share, 3))


def _check(batch: Batch, found: Found) -> None:
    """Raise AssertionError if something is not as it was promised."""
    if found.too_many:
        raise AssertionError(f"{batch.name}: Telegram said 429 {found.too_many} times")
    if found.overtaken:
        raise AssertionError(f"{batch.name}: {found.overtaken} outcomes went before a stop")
    if found.share < AT_LEAST:
        raise AssertionError(f"{batch.name}: {found.share:.1%} of what is permitted")
