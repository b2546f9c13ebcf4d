"""Telegram: the paper's Algorithm 11 under Telegram's limits, and what receiving costs."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from rosic.app import runtime
from rosic.bench.batches import (
    ENDED,
    ROUND_TRIP_S,
    BatchFigures,
    BatchSite,
    CommandBatch,
    through_rosic,
)
from rosic.bench.bot_api_process import TOKEN, stand_in
from rosic.bench.receiving import PEER, empty_handler, findings, received
from rosic.bench.report import BenchCase, BenchReport, case_of, machine
from rosic.messengers.telegram.bot_client import BotClient
from rosic.messengers.telegram.errors import ErrorKind, TelegramError
from rosic.messengers.telegram.settings import read_settings

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.bench.recorder import BenchRecorder
    from rosic.testing.telegram import Control


# ---- the naive sender ----


async def through_a_loop(control: Control, batch: CommandBatch) -> BatchFigures:
    """Have a plain loop answer the same commands: it sends at once, and waits when it is told to.

    It has no commands to follow and nothing to write down; each outcome is one message.
    """
    place = BatchSite(control, batch)
    await place.prepare()
    await place.command()
    settings = read_settings("bench", {"token": TOKEN, "api_base": control.api_base})
    line = BotClient(settings)
    said = {person: await control.messages(person) for person in place.people}
    waiting = [
        (person, said[person][number]["message_id"])
        for number in range(batch.commands // batch.chats)
        for person in place.people
    ]
    async with line.held():
        for person, message in waiting:
            await _send_at_once(line, person, message)
    return await place.found((), 0, 0)


async def _send_at_once(line: BotClient, person: int, message: int) -> None:
    while True:
        try:
            await line.ask(
                lambda bot: bot.send_message(
                    person, f"robot: go\n{ENDED}now", reply_to_message_id=message
                )
            )
        except TelegramError as trouble:
            if trouble.kind is not ErrorKind.TOO_FAST:
                raise
            await asyncio.sleep(trouble.wait_s)
        else:
            return


# ---- measuring ----

AT_LEAST = 0.95
SIZES = (10, 50, 100, 500)
FULL = (
    *(CommandBatch(name=f"{size} commands, 10 chats", commands=size) for size in SIZES),
    CommandBatch(name="500 commands, 50 chats", commands=500, chats=50),
)
QUICK = (CommandBatch(name="50 commands, 10 chats, 1.5 times as fast", commands=50, faster=1.5),)
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


class TelegramLoad(NamedTuple):
    """What is measured.

    Attributes:
        orders: Updates of each kind, where receiving is measured; 0: it is not.
        at_least: Share that is promised of what ROSIC lets itself say of the permitted rate.
    """

    batches: tuple[CommandBatch, ...]
    orders: int
    at_least: float = AT_LEAST


def measure(recorder: BenchRecorder) -> BenchReport:
    """Run every batch through ROSIC and through the naive sender, then measure receiving."""
    with recorder.turn("batches"):
        load = TelegramLoad(QUICK, 200) if recorder.quick else TelegramLoad(FULL, 2_000)
        return measured(recorder, load)


def measured(recorder: BenchRecorder, asked: TelegramLoad) -> BenchReport:
    """Measure all that is asked, whatever did not hold of it."""
    log = logging.getLogger("rosic")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        cases, failures, seen = runtime.run(_run(recorder, asked))
    finally:
        log.setLevel(level)
    method = METHOD.format(
        round_trip_ms=ROUND_TRIP_S * 1e3, loop=runtime.name(), orders=asked.orders
    )
    return BenchReport(
        machine=machine(),
        method=method,
        cases=tuple(cases),
        findings=seen,
        failures=tuple(failures),
    )


async def _run(
    recorder: BenchRecorder, asked: TelegramLoad
) -> tuple[list[BenchCase], list[str], tuple[str, ...]]:
    cases: list[BenchCase] = []
    failures: list[str] = []
    async with stand_in() as control:
        for batch in asked.batches:
            try:
                found = await through_rosic(control, batch)
            except (AssertionError, TimeoutError) as error:
                failures.append(f"{batch.name}: nothing could be measured: {error!r}")
            else:
                cases += recorder.see(_cases(batch, found))
                least = asked.at_least * batch.kept_per_s / batch.permitted_per_s
                failures += [f"{batch.name}: {one}" for one in _broken(found, least)]
            naive = await through_a_loop(control, batch)
            name = f"{batch.name}: naive, {naive.too_many} times 429"
            cases += recorder.see([_case(name, naive)])
        if not asked.orders:
            return cases, failures, ()
        async with empty_handler(control) as handle:
            times_of = await received(asked.orders, {PEER: handle})
    cases += [
        case_of(name, [(1e9 * len(times) / sum(times), times)]) for name, times in times_of.items()
    ]
    return cases, failures, findings(times_of)


def _cases(batch: CommandBatch, found: BatchFigures) -> list[BenchCase]:
    stops = [(1e9 * len(found.stop_ns) / sum(found.stop_ns), found.stop_ns)]
    return [_case(batch.name, found), case_of(f"{batch.name}: stops meanwhile", stops)]


def _case(name: str, found: BatchFigures) -> BenchCase:
    case = case_of(name, [(found.rate_per_s, found.waited_ns)])
    return msgspec.structs.replace(case, permitted_share=round(found.share, 3))


def _broken(found: BatchFigures, at_least: float) -> Iterator[str]:
    """Yield what is not as it was promised."""
    yield from found.wrong
    if found.too_many:
        yield f"Telegram said 429 {found.too_many} times."
    if found.overtaken:
        yield f"{found.overtaken} outcomes went before a stop."
    if found.share < at_least:
        yield f"{found.share:.1%} of what is permitted, and {at_least:.0%} is promised."
