"""ROSIC beside other chat bots, in one run: each in a process of its own, turn for turn."""

from __future__ import annotations

import asyncio
import sys
import tempfile
from contextlib import AsyncExitStack
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.app import runtime
from rosic.bench.comparison import budgets
from rosic.bench.orders import OrderLoad, OrderTurn
from rosic.bench.paired_runs import waiting
from rosic.bench.peer_environment import (
    AIOGRAM,
    ERRBOT,
    OPSDROID,
    PTB,
    Peer,
    default_folder,
    interpreter,
    last_line,
)
from rosic.bench.receiving import IN_MEMORY, PAUSE_S, received, synced
from rosic.bench.report import (
    BenchCase,
    BenchRatio,
    BenchReport,
    BenchTable,
    case_of,
    machine,
    spread_of,
)
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator, Sequence

    from rosic.bench.paired_runs import PairedProcess
    from rosic.bench.recorder import BenchRecorder

BENCH: Final = "peers"
TURNS, MESSAGES, UPDATES = 30, 1_000, 1_000
QUICK_TURNS, QUICK_MESSAGES, QUICK_UPDATES = 3, 300, 50
STRETCHES: Final = 5
"""Into so many the turns are parted, to see how far what was seen lies apart."""
UVLOOP, ASYNCIO = "uvloop", "asyncio"
ONE, SEVERAL = (1,), (1, 64)
ON_DISK = 256
MEASURED: Final = "measured"
NEVER_STARTED: Final = "{name} did not start: {why}"
ENDED_EARLY: Final = "{name} ended early: {why}"
METHOD: Final = (
    "Messages that were answered. Each bot runs in a process of its own and is handed messages in "
    "memory, no network, one or 64 at a time; turn for turn, {turns} turns of {messages} messages "
    "after one that is not counted, and between its turns it stands still. Messages of one case "
    "say the same words, but for the number of a skill where there are several. All of ROSIC: "
    "{people} people, one robot, a message understood, its author authenticated and admitted, the "
    "lease taken, the order claimed, relayed, acted on once, concluded and told. opsdroid: "
    "match_regex and message.respond. errbot: a botcmd, its ten threads, its back end in memory. "
    "python-telegram-bot and aiogram: from an update of the Bot API as JSON to the request that "
    "answers it, made and not sent. Processor: what the whole process used for each message. A "
    "ratio is of the faster of both ways of each, turn for turn. Receiving: from the bytes of an "
    "answer with one update to the robot's adapter, or to an empty handler; one at a time, "
    "{updates} of each. On disk: "
    "claims and outcomes in SQLite, {on_disk} in flight, beside one page written and synced for "
    "each group that was committed, on the same disk. Event loops: uvloop, which opsdroid alone "
    "has in one of its two rows; ROSIC: {loop}."
)


class PeerCase(NamedTuple):
    """One bot that is measured.

    Attributes:
        peer: Which; None: ROSIC, with a load.
        skills: How many it has.
        in_flight: Messages at the same time, of each of its cases.
    """

    name: str
    peer: Peer | None = None
    load: OrderLoad | None = None
    skills: int = 1
    loop: str = UVLOOP
    in_flight: tuple[int, ...] = SEVERAL


def _own(name: str, *, skills: int = 1, durable: bool = False) -> PeerCase:
    load = OrderLoad(name=name, orders=0, skills=skills, people=10, robots=1, durable=durable)
    if durable:
        load = msgspec.structs.replace(load, skills=500, robots=50, in_flight=ON_DISK)
    else:
        load = msgspec.structs.replace(load, in_flight=1)
    return PeerCase(name, load=load, in_flight=(ON_DISK,) if durable else SEVERAL)


ROSIC = _own("ROSIC, 1 skill")
MANY_SKILLS = _own("ROSIC, 5000 skills", skills=5_000)
DURABLE = _own("ROSIC, on disk", durable=True)
OPSDROID_CASE = PeerCase("opsdroid", OPSDROID, loop=ASYNCIO)
OPSDROID_FAST = PeerCase("opsdroid on uvloop", OPSDROID)
OPSDROID_MANY = PeerCase("opsdroid, 20 skills", OPSDROID, skills=20, loop=ASYNCIO)
ERRBOT_CASE = PeerCase("errbot", ERRBOT)
PTB_CASE = PeerCase("python-telegram-bot", PTB)
AIOGRAM_CASE = PeerCase("aiogram", AIOGRAM)
CASES = (
    ROSIC,
    OPSDROID_CASE,
    OPSDROID_FAST,
    MANY_SKILLS,
    OPSDROID_MANY,
    ERRBOT_CASE,
    PTB_CASE,
    AIOGRAM_CASE,
    DURABLE,
)
EMPTY_HANDLERS = (
    PeerCase("receiving: python-telegram-bot, empty handler", PTB, skills=0),
    PeerCase("receiving: aiogram, empty handler", AIOGRAM, skills=0),
)


class PeerLoad(NamedTuple):
    """How much is measured.

    Attributes:
        updates: Of each kind, where receiving is measured; 0: it is not.
        folder: Where the environments of peers are kept.
        install: Make those that are not there.
    """

    cases: tuple[PeerCase, ...]
    turns: int
    updates: int
    folder: Path
    install: bool = True
    messages: int = MESSAGES


def measure(
    recorder: BenchRecorder, *, environment: Path | None = None, no_install: bool = False
) -> BenchReport:
    """Measure ROSIC and each peer that can be installed.

    Args:
        recorder: Of this bench.
        environment: Where the environments of peers are kept; None: in the user's cache.
        no_install: Those that are not there are left out.
    """
    folder = default_folder() if environment is None else environment
    load = PeerLoad(CASES, TURNS, UPDATES, folder, install=not no_install)
    if recorder.quick:
        load = load._replace(turns=QUICK_TURNS, updates=QUICK_UPDATES, messages=QUICK_MESSAGES)
    return measured(recorder, load)


def measured(recorder: BenchRecorder, load: PeerLoad) -> BenchReport:
    """Measure all that is asked."""
    bench = PeerBench(recorder, load)
    runtime.run(bench.run())
    own = ROSIC.load
    method = METHOD.format(
        turns=load.turns,
        messages=load.messages,
        people=own.people if own else 0,
        updates=load.updates,
        on_disk=ON_DISK,
        loop=runtime.name(),
    )
    ratios = tuple(bench.ratios())
    return BenchReport(
        machine=machine(),
        method=method,
        cases=tuple(bench.cases()),
        tables=(bench.table(),),
        ratios=ratios,
        findings=tuple(findings(ratios)),
        failures=tuple(bench.failures()),
    )


def _each_s(turn: OrderTurn) -> float:
    return turn.seconds / len(turn.times_ns)


def _processor_s(turn: OrderTurn) -> float:
    return turn.processor_s / len(turn.times_ns)


def _processor_us(turns: Sequence[OrderTurn]) -> float:
    return round(1e6 * median(map(_processor_s, turns)), 1)


class PeerBench:
    """Lets bots take turns, and keeps what was seen of each."""

    def __init__(self, recorder: BenchRecorder, load: PeerLoad) -> None:
        self._recorder = recorder
        self._load = load
        self._seen: dict[tuple[str, int], list[OrderTurn]] = {}
        self._synced_s: list[float] = []
        self._received: dict[str, list[int]] = {}
        self._told: dict[str, tuple[str, str]] = {}
        self._pythons: dict[Peer, Path | str] = {}

    # ---- processes ----

    async def run(self) -> None:
        """Let all take turns; one that does not start or ends is left out from then on."""
        async with AsyncExitStack() as stack:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="rosic-bench-")))
            running = [
                (case, process)
                for case in self._load.cases
                if (process := await self._start(case, folder, stack)) is not None
            ]
            for turn in range(self._load.turns + 1):
                for case, process in tuple(running):
                    if not await self._turn(case, process, folder, counted=turn > 0):
                        running.remove((case, process))
        if self._load.updates:
            await self._receive()

    async def _start(
        self, case: PeerCase, folder: Path, stack: AsyncExitStack
    ) -> PairedProcess | None:
        """Return a process that is ready; nothing where there is none, which the table says."""
        with self._errors(case, folder).open("wb") as errors:
            try:
                command = self._command(case)
                process = await stack.enter_async_context(waiting(*command, errors=errors))
                version = msgspec.json.decode(await process.line(), type=str)
            except ConfigurationError as trouble:
                self._told[case.name] = ("", str(trouble))
            except (OSError, RuntimeError, TimeoutError, msgspec.MsgspecError) as trouble:
                self._told[case.name] = ("", self._why(NEVER_STARTED, case, folder, trouble))
            else:
                self._told[case.name] = (version, MEASURED)
                return process
        return None

    def _command(self, case: PeerCase) -> tuple[str, ...]:
        """Return what runs a bot.

        Raises:
            ConfigurationError: It is not installed, and cannot be.
        """
        if case.peer is None:
            wanted = msgspec.json.encode(case.load).decode()
            return sys.executable, "-m", "rosic.bench.orders", wanted
        if case.peer not in self._pythons:
            self._pythons[case.peer] = self._python(case.peer)
        python = self._pythons[case.peer]
        if isinstance(python, str):
            raise ConfigurationError(python)
        # Isolated: nothing of ROSIC's folders, nor of what PYTHONPATH names, is seen.
        words = (case.peer.name, str(case.skills), case.loop)
        return str(python), "-I", str(case.peer.script), *words

    def _python(self, peer: Peer) -> Path | str:
        """Return a peer's interpreter, or why there is none."""
        with self._recorder.turn(f"installing {peer.name}"):
            try:
                return interpreter(peer, self._load.folder, install=self._load.install)
            except ConfigurationError as trouble:
                return str(trouble)

    @staticmethod
    def _errors(case: PeerCase, folder: Path) -> Path:
        return folder / f"{case.name}.txt".replace(" ", "_")

    def _why(self, sentence: str, case: PeerCase, folder: Path, trouble: Exception) -> str:
        """Return what the row of a bot says that went wrong: its own last words, if it had any."""
        errors = self._errors(case, folder)
        said = last_line(errors.read_bytes()) if errors.exists() else ""
        return sentence.format(name=case.name, why=said or str(trouble) or repr(trouble))

    async def _turn(
        self, case: PeerCase, process: PairedProcess, folder: Path, *, counted: bool
    ) -> bool:
        """Let a bot take one turn of each of its cases; return whether it did."""
        for in_flight in case.in_flight:
            with self._recorder.turn(case_name(case, in_flight), of=self._load.turns) as turn:
                try:
                    said = await process.turn(f"{self._load.messages} {in_flight}")
                    seen = msgspec.json.decode(said, type=OrderTurn)
                except (OSError, RuntimeError, TimeoutError, msgspec.MsgspecError) as trouble:
                    version, _ = self._told[case.name]
                    why = self._why(ENDED_EARLY, case, folder, trouble)
                    self._told[case.name] = (version, why)
                    return False
                if not counted:
                    continue
                turn.saw(len(seen.times_ns) / seen.seconds, seen.times_ns)
                self._seen.setdefault((case.name, in_flight), []).append(seen)
            if seen.commits:
                page = folder / "page"
                self._synced_s.append(
                    sum([await synced(page, n) for n in range(seen.commits)]) / 1e9
                )
        return True

    async def _receive(self) -> None:
        """Measure receiving: ROSIC in this process, empty handlers in theirs."""
        async with AsyncExitStack() as stack:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="rosic-bench-")))
            beside: dict[str, Callable[[int], Awaitable[int]]] = {}
            wanted = {case.peer for case in self._load.cases}
            for case in EMPTY_HANDLERS:
                if case.peer in wanted and (process := await self._start(case, folder, stack)):
                    beside[case.name] = handling(process)
            with self._recorder.turn("receiving"):
                self._received = await received(self._load.updates, beside)

    # ---- what was seen ----

    def cases(self) -> Iterator[BenchCase]:
        """Yield what each bot came to, with what it needed of processors."""
        seen = {
            case_name(case, in_flight): self._seen[case.name, in_flight]
            for case in self._load.cases
            for in_flight in case.in_flight
            if (case.name, in_flight) in self._seen
        }
        for case in self._recorder.cases():
            yield msgspec.structs.replace(case, processor_us=_processor_us(seen[case.name]))
        for name, times in self._received.items():
            yield case_of(name, [(1e9 * len(times) / sum(times), times)])

    def failures(self) -> Iterator[str]:
        """Yield why ROSIC itself was not measured; that another bot was not says its row."""
        for case in self._load.cases:
            _, came = self._told[case.name]
            if case.peer is None and came != MEASURED:
                yield came

    def table(self) -> BenchTable:
        """Return each bot, at the faster of its ways, or why there is nothing of it."""
        rows = tuple(self._row(name) for name in self._told)
        columns = ("bot", "version", "in flight", "messages/s", "processor, us each", "what came")
        return BenchTable(title="Bots", columns=columns, rows=rows)

    def _row(self, name: str) -> tuple[str | float | None, ...]:
        version, came = self._told[name]
        if not (in_flight := self._faster(name)):
            return name, version, None, None, None, came
        turns = self._seen[name, in_flight]
        rate = round(1 / median(map(_each_s, turns)), 1)
        return name, version, in_flight, rate, _processor_us(turns), came

    def _faster(self, name: str) -> int:
        """Return how many in flight a bot is fastest with; 0 where nothing was seen of it."""
        ways = {
            in_flight: median(map(_each_s, turns))
            for (case, in_flight), turns in self._seen.items()
            if case == name
        }
        return min(ways, key=ways.__getitem__, default=0)

    def _each(self, case: PeerCase, cost: Callable[[OrderTurn], float] = _each_s) -> list[float]:
        """Return what a message took in each turn, at the faster of a bot's ways."""
        return list(map(cost, self._seen.get((case.name, self._faster(case.name)), ())))

    def ratios(self) -> Iterator[BenchRatio]:
        """Yield how many times one is the other, for what was seen of both."""
        for peer in (OPSDROID_CASE, OPSDROID_FAST, ERRBOT_CASE, PTB_CASE, AIOGRAM_CASE):
            of = f"messages a second of ROSIC, by those of {peer.name}"
            yield from ratio_of(RATES + peer.name, self._each(peer), self._each(ROSIC), of)
            of = f"what {peer.name} uses of a processor for a message, by what ROSIC does"
            used, ours = (self._each(one, _processor_s) for one in (peer, ROSIC))
            yield from ratio_of(f"processor, beside {peer.name}", used, ours, of)
        many, one = self._each(MANY_SKILLS), self._each(ROSIC)
        yield from ratio_of("5000 skills beside 1", many, one, SKILLS)
        many, one = self._each(OPSDROID_MANY), self._each(OPSDROID_CASE)
        yield from ratio_of("opsdroid, 20 skills beside 1", many, one, SKILLS)
        durable = [each.seconds for each in self._seen.get((DURABLE.name, ON_DISK), ())]
        yield from ratio_of("on disk beside fdatasync", durable, self._synced_s, SYNCED)
        own: Sequence[float] = self._received.get(IN_MEMORY, [])
        for case in EMPTY_HANDLERS:
            of = "what receiving takes ROSIC, with all that follows until the robot's adapter"
            name = f"receiving beside {case.peer.name if case.peer else case.name}"
            yield from ratio_of(name, own, self._received.get(case.name, []), of)


RATES: Final = "messages/s, beside "
SKILLS: Final = "what a message takes with so many skills, by what it takes with one"
SYNCED: Final = "durable orders, by one page written and synced for each group of them"


def case_name(case: PeerCase, in_flight: int) -> str:
    """Return what a case of a bot is called."""
    return f"{case.name}, {in_flight} in flight"


def handling(process: PairedProcess) -> Callable[[int], Awaitable[int]]:
    """Return what lets a process handle one update, and says how long it took, in ns."""

    async def handle(_number: int) -> int:
        seen = msgspec.json.decode(await process.turn("1 1"), type=OrderTurn)
        await asyncio.sleep(PAUSE_S)
        return seen.times_ns[0]

    return handle


def ratio_of(
    name: str, some: Sequence[float], others: Sequence[float], of: str
) -> Iterator[BenchRatio]:
    """Yield how many times some are others, turn for turn; nothing where nothing was seen."""
    turns = min(len(some), len(others))
    if not turns:
        return
    pairs = [one / other for one, other in zip(some, others, strict=False)]
    size = max(1, turns // STRETCHES)
    stretches = [median(pairs[at : at + size]) for at in range(0, size * (turns // size), size)]
    yield BenchRatio(name=name, value=round(median(pairs), 3), spread=spread_of(stretches), of=of)


def findings(ratios: Sequence[BenchRatio]) -> Iterator[str]:
    """Yield what was promised beside what was seen, and where ROSIC loses."""
    promised = {one.ratio: one for one in budgets() if one.bench == BENCH}
    for ratio in ratios:
        budget = promised.get(ratio.name)
        if budget is not None:
            kept = "kept" if budget.holds(ratio.value) else "not kept"
            yield f"{ratio.name}: {ratio.value:.2f}; promised: {budget.bound()}; {kept}."
        if ratio.name.startswith(RATES) and ratio.value < 1:
            peer = ratio.name.removeprefix(RATES)
            yield f"ROSIC loses to {peer}: {ratio.value:.2f} times its messages a second."
