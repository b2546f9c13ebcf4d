"""What the first times cost whoever meets a robot by chat: taps, words, messages to read, seconds.

Scripted people; nobody's thinking or reading is timed. `tests/journeys/test_first_time.py` walks
the same paths, and `docs/first-time.md` shows them.
"""

from __future__ import annotations

import asyncio
import re
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.app import runtime
from rosic.bench.bot_api_process import TOKEN, stand_in
from rosic.bench.gateway_process import LOCAL, free_port, gateway_process
from rosic.bench.report import BenchReport, BenchTable, machine
from rosic.bench.soak import await_answer

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from rosic.bench.recorder import BenchRecorder
    from rosic.testing.telegram.newcomer import ChatReader, Newcomer

RUNS, QUICK_RUNS = 5, 1
LEASE_IDLE_S: Final = 1
CODE: Final = re.compile(r"start=([A-Za-z0-9_-]+)")
CONFIG: Final = """\
[gateway]
name = "bench"
data = "data"
lease_idle_s = {lease_idle_s}

[[messenger]]
kind = "telegram"
token = "{token}"
api_base = "{api_base}"

[metrics]
listen = "{listen}"

[[robot]]
profile = "omni"
link = "simulated"

[[principal]]
name = "Ada"
address = "telegram:{admin}"
role = "admin"
"""
METHOD: Final = (
    "Scripted people at a whole gateway (rosic run) with its record on disk and a simulated robot, "
    "over a stand-in for the Bot API with Telegram's published limits; {runs} runs of each path, "
    "by somebody new each time. No human was measured: seconds are of machines alone, from the "
    "first tap or word until the last expected answer can be read, the robot's motion included. "
    "p50 to max: that time."
)
FAILED: Final = "{name}: {why}"


class PathFigures(NamedTuple):
    """What one walk of a path took.

    Attributes:
        words: Typed.
        read: Messages of the bot, each form of one counted under which somebody tapped.
    """

    taps: int
    words: int
    read: int
    seconds: float


class FirstTimeSite(NamedTuple):
    """A gateway, and the admin, who invites and allows."""

    reader: ChatReader
    admin: Newcomer
    names: dict[str, int]

    async def newcomer(self, role: str, lasts: str = "2h") -> tuple[Newcomer, str]:
        """Make somebody with an invitation in their hand; return them and its code."""
        from rosic.testing.telegram.newcomer import Newcomer as Person  # noqa: PLC0415 - an extra

        name = f"Cy {len(self.names)}"
        self.names[name] = account = await self.reader.control.create_user(name)
        words = f"/invite {role} omni for {lasts}"
        said = await self.reader.ask(self.admin.account, words, "start=")
        (code,) = CODE.findall(said["text"])
        return Person(self.reader, account), code

    async def member(self, role: str, lasts: str = "2h") -> Newcomer:
        """Make somebody who has joined already, and has nothing counted yet."""
        person, code = await self.newcomer(role, lasts)
        await person.start(code, "You are invited")
        await person.tap("Join", "You are in")
        person.taps = 0
        return person


async def _join(place: FirstTimeSite) -> PathFigures:
    cy, code = await place.newcomer("operator")
    walk = await PathRun.begun(cy)
    await cy.start(code, "You are invited as operator on omni")
    await cy.tap("Join", "What should omni do?")
    return await walk.ended()


async def _first_motion(place: FirstTimeSite) -> PathFigures:
    cy, code = await place.newcomer("operator")
    walk = await PathRun.begun(cy)
    await cy.start(code, "You are invited as operator on omni")
    await cy.tap("Join", "What should omni do?")
    await cy.tap("🚗 Move in a straight line", "0.50 m forward?")
    await cy.tap("Do it", "moved 0.50 m forward")
    return await walk.ended()


async def _stop(place: FirstTimeSite) -> PathFigures:
    cy = await place.member("operator")
    await cy.type("omni move 2 m", "driving")
    walk = await PathRun.begun(cy)
    await cy.tap("STOP", "STOP: omni at rest")
    found = await walk.ended()
    await cy.reads("stopped before it ended")
    await cy.type("resume omni", "omni is ready again.")
    return found


async def _book(place: FirstTimeSite) -> PathFigures:
    cy = await place.member("operator", "3d")
    walk = await PathRun.begun(cy)
    await cy.type("book", "When, and for how long?")
    await cy.tap("Book omni, tomorrow 14:00 1h", "omni is yours on")
    found = await walk.ended()
    await cy.tap("Cancel it", "Cancelled: omni")
    return found


async def _ask(place: FirstTimeSite) -> PathFigures:
    cy = await place.member("viewer")
    walk = await PathRun.begun(cy)
    await cy.type("omni move 0.5 m", "needs the right")
    await cy.tap("Ask for it", "I have asked Ada")
    await place.admin.tap("Allow 1 h", "may now")
    await cy.reads("Ada allows it. You may now")
    await cy.type("omni move 0.5 m", "moved 0.50 m forward")
    return await walk.ended()


PATHS: Final[tuple[tuple[str, Callable[[FirstTimeSite], Awaitable[PathFigures]]], ...]] = (
    ("join by invitation", _join),
    ("join, and a first safe motion", _first_motion),
    ("stop a motion", _stop),
    ("book a time", _book),
    ("ask for a right, and use it", _ask),
)


class PathRun(NamedTuple):
    """A walk that has begun."""

    who: Newcomer
    before: PathFigures

    @classmethod
    async def begun(cls, who: Newcomer) -> PathRun:
        """Begin to count."""
        return cls(who, await _now(who))

    async def ended(self) -> PathFigures:
        """Return what there was since."""
        after = await _now(self.who)
        past = (later - sooner for later, sooner in zip(after, self.before, strict=True))
        taps, words, read, seconds = past
        return PathFigures(int(taps), int(words), int(read), seconds)


async def _now(who: Newcomer) -> PathFigures:
    at_s = time.monotonic()
    return PathFigures(who.taps, who.words, (await who.saw()).read, at_s)


def measure(recorder: BenchRecorder) -> BenchReport:
    """Walk every path.

    Args:
        recorder: Is told how far it is; keeps what was seen if it is interrupted.

    Raises:
        ConfigurationError: The gateway does not start.
    """
    runs = QUICK_RUNS if recorder.quick else RUNS
    walked: dict[str, list[PathFigures]] = {name: [] for name, _ in PATHS}
    failures: list[str] = []

    def so_far() -> BenchReport:
        return report_of(recorder, walked, failures, runs)

    recorder.report_by(so_far)
    runtime.run(_walk(recorder, walked, failures, runs))
    return so_far()


async def _walk(
    recorder: BenchRecorder,
    walked: dict[str, list[PathFigures]],
    failures: list[str],
    runs: int,
) -> None:
    with tempfile.TemporaryDirectory(prefix="rosic-bench-") as name:
        folder = Path(name)
        async with stand_in() as control:
            from rosic.testing.telegram.newcomer import ChatReader as Reader  # noqa: PLC0415
            from rosic.testing.telegram.newcomer import Newcomer as Person  # noqa: PLC0415

            admin = await control.create_user("Ada")
            port = free_port()
            config = CONFIG.format(
                token=TOKEN,
                api_base=control.api_base,
                listen=f"{LOCAL}:{port}",
                admin=admin,
                lease_idle_s=LEASE_IDLE_S,
            )
            reader = Reader(control)
            with gateway_process(folder, config, port):
                await await_answer(control, admin)
                place = FirstTimeSite(reader, Person(reader, admin), {})
                for _ in range(runs):
                    for path, walk in PATHS:
                        try:
                            with recorder.turn(path, of=runs) as turn:
                                found = await walk(place)
                                turn.saw(1 / found.seconds, [found.seconds * 1e9])
                            walked[path].append(found)
                            if path != PATHS[-1][0] or len(walked[path]) < runs:
                                await asyncio.sleep(1.5 * LEASE_IDLE_S)  # the robot is free again
                        except AssertionError as why:
                            failures.append(FAILED.format(name=path, why=why))


def report_of(
    recorder: BenchRecorder,
    walked: dict[str, list[PathFigures]],
    failures: Sequence[str],
    runs: int,
) -> BenchReport:
    """Return what follows from the walks."""
    columns = ("path", "taps", "words typed", "messages read", "seconds of machines")
    rows = tuple(
        (
            name,
            *(median(getattr(one, what) for one in found) for what in ("taps", "words", "read")),
            round(median(one.seconds for one in found), 2),
        )
        for name, found in walked.items()
        if found
    )
    return BenchReport(
        machine=machine(),
        method=METHOD.format(runs=runs),
        cases=recorder.cases(tails=True),
        failures=tuple(failures),
        tables=(BenchTable(title="First times", columns=columns, rows=rows),),
    )
