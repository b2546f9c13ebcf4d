"""A message to a robot and its answer over Matrix, beside a bare echo at the same homeserver."""

from __future__ import annotations

import asyncio
import re
import sys
import tempfile
import time
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeVar

from msgspec import structs

from rosic.app import runtime
from rosic.bench.gateway_process import LOCAL, free_port, gateway_process
from rosic.bench.matrix_users import ChatFault, MatrixUser
from rosic.bench.peer_environment import Peer, default_folder, interpreter
from rosic.bench.report import (
    BenchCase,
    BenchRatio,
    BenchReport,
    BenchTable,
    machine,
    quantile,
    spread_of,
)
from rosic.errors import ConfigurationError
from rosic.testing.matrix import HomeserverFault, Synapse

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Coroutine, Iterator, Sequence

    from rosic.bench.recorder import BenchRecorder
    from rosic.testing.matrix import Account

T = TypeVar("T")
SYNAPSE: Final = Peer("matrix-synapse", ("matrix-synapse==1.163.2",))
ECHO, ROSIC = "echo", "ROSIC"
ENCRYPTED, PLAIN = "encrypted", "plain"
MEMBERS: Final = 4
AT_ONCE: Final = 4
PAUSE_S: Final = 0.1
STARTS_WITHIN_S: Final = 60.0
KIB: Final = 1 << 10
RESIDENT: Final = re.compile(r"VmRSS:\s+(\d+) kB")
METHOD: Final = (
    "From the moment at which a person's client begins to send until it has read the first answer; "
    "the client is matrix-nio's, the same for both, and so is the homeserver, a Synapse on this "
    "machine. ROSIC: a whole gateway (rosic run) with its record on disk; each message is an order "
    "that a robot in memory carries out. Echo: a bot of matrix-nio that sends back what it is "
    "sent. One at a time: {turns} turns of {messages} messages each, turn for turn, after one that "
    "is not counted; {pause_ms:.0f} ms between two, after the order has ended. In rooms: {rooms} "
    "encrypted rooms for each of both with {members} people each, {people} in all, {per_s:g} "
    "messages a second for {lasts_s:.0f} s; times count from when a message was due. Memory: what "
    "the process has resident, before the rooms and after, when each room has had its messages."
)
NOT_ANSWERED: Final = "{bot}: {lost} of {sent} messages were not answered in time."
SAID: Final = (
    "{mode}: {own_ms:.1f} ms at the median and {own_p99_ms:.1f} ms at p99; the echo {echo_ms:.1f} "
    "and {echo_p99_ms:.1f}."
)
GATEWAY: Final = """\
[gateway]
name = "bench"
data = "data"
lease_idle_s = 1

[limits]
burst = 10000
per_s = 10000

[metrics]
listen = "{listen}"

[[messenger]]
kind = "matrix"
name = "bench"
homeserver = "{url}"
user = "{user}"
password = "{password}"
folder = "{folder}"
require_verified = false
"""
PERSON: Final = """
[[principal]]
name = "Person {number}"
address = "matrix:{user}"
role = "operator"
"""
ROBOT: Final = """
[[robot]]
profile = "{profile}"
link = "memory"
"""
CELL: Final = """\
id: cell{number}
link: {{ kind: memory }}
skills:
  sort: {{ class: task }}
"""


class MatrixLoad(NamedTuple):
    """How much is measured.

    Attributes:
        turns: Of each case that is measured one at a time.
        messages: In each turn.
        rooms: For each of both bots.
        per_s: Messages a second, in all of these rooms together.
        lasts_s: So long in each of two turns.
    """

    turns: int = 20
    messages: int = 25
    rooms: int = 50
    per_s: float = 4.0
    lasts_s: float = 60.0

    @property
    def people(self) -> int:
        """How many there are."""
        return self.rooms * MEMBERS


QUICK: Final = MatrixLoad(turns=3, messages=8, rooms=4, per_s=2.0, lasts_s=6.0)


class ChatBot(NamedTuple):
    """One of both that are measured.

    Attributes:
        ends: What it says last of a message, where that is not its first answer.
        pid: Of its process.
    """

    name: str
    user: str
    ends: str
    pid: int


class ChatRoom(NamedTuple):
    """A room with a bot, and whoever writes there.

    Attributes:
        cell: The number of the robot that is ordered there.
    """

    id: str
    writer: MatrixUser
    cell: int


def measure(
    recorder: BenchRecorder, *, synapse: Path | None = None, no_install: bool = False
) -> BenchReport:
    """Measure it; where there is no homeserver and none may be installed, say so.

    Args:
        recorder: Of this bench.
        synapse: The Python of an environment with Synapse; None: one in the user's cache.
        no_install: That is not made where it is not there.

    Raises:
        ConfigurationError: Synapse cannot be installed, or it does not start.
    """
    load = QUICK if recorder.quick else MatrixLoad()
    if synapse is None:
        try:
            synapse = interpreter(SYNAPSE, default_folder(), install=not no_install)
        except ConfigurationError as missing:
            if not no_install:
                raise
            empty = MatrixBench(recorder, load).report()
            return structs.replace(empty, findings=(str(missing),))
    return measured(recorder, load, synapse)


def measured(recorder: BenchRecorder, load: MatrixLoad, python: Path) -> BenchReport:
    """Measure as much as is asked.

    Raises:
        ConfigurationError: Synapse, or a bot, does not start.
    """
    bench = MatrixBench(recorder, load)
    recorder.report_by(bench.report)
    try:
        runtime.run(bench.run(python))
    except HomeserverFault as trouble:
        raise ConfigurationError(str(trouble)) from trouble
    return bench.report()


class MatrixBench:
    """Lets both bots be asked in turns, and keeps what was seen."""

    def __init__(self, recorder: BenchRecorder, load: MatrixLoad) -> None:
        self._recorder = recorder
        self._load = load
        self._seen: dict[tuple[str, str], list[list[int]]] = {}
        self._lost: dict[str, int] = {}
        self._sent: dict[str, int] = {}
        self._resident: dict[str, tuple[int, int]] = {}

    async def run(self, python: Path) -> None:
        """Measure everything.

        Raises:
            HomeserverFault: The homeserver does not start.
            ConfigurationError: A bot does not.
        """
        async with AsyncExitStack() as stack:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="rosic-bench-")))
            (folder / "synapse").mkdir()
            server = stack.enter_context(Synapse(folder / "synapse", python))
            accounts = [server.create_account(f"p{n}") for n in range(self._load.people)]
            bots = (
                await stack.enter_async_context(_echo(server.create_account("echo"), folder)),
                stack.enter_context(
                    _gateway(server.create_account("robots"), accounts, self._load.rooms, folder)
                ),
            )
            people = [MatrixUser(one, folder / f"p{n}") for n, one in enumerate(accounts)]
            for person in people:
                stack.push_async_callback(person.close)
            await _all_of([person.log_in() for person in people])
            writers = people[::MEMBERS]
            for writer in writers:
                await stack.enter_async_context(writer.listening())
            await self._one_at_a_time(bots, writers[0])
            await self._in_rooms(bots, people)

    async def _one_at_a_time(self, bots: Sequence[ChatBot], writer: MatrixUser) -> None:
        rooms = {
            (mode, bot): await _opened(bot, writer, (), encrypted=mode == ENCRYPTED)
            for mode in (PLAIN, ENCRYPTED)
            for bot in bots
        }
        for turn in range(self._load.turns + 1):
            for (mode, bot), room in rooms.items():
                times_ns = []
                with self._recorder.turn(f"{bot.name}, {mode}", of=self._load.turns) as told:
                    for _ in range(self._load.messages):
                        await asyncio.sleep(PAUSE_S)
                        times_ns.append(await writer.ask(room, "cell0 sort", ends=bot.ends))
                    if turn:
                        told.saw(len(times_ns) / (sum(times_ns) / 1e9), times_ns)
                        self._seen.setdefault((mode, bot.name), []).append(times_ns)

    # ---- many rooms ----

    async def _in_rooms(self, bots: Sequence[ChatBot], people: Sequence[MatrixUser]) -> None:
        before = {bot: resident_bytes(bot.pid) for bot in bots}
        rooms = {bot: await self._open_rooms(bot, people) for bot in bots}
        for bot in bots:  # whoever is there learns of everybody's keys outside of what is timed
            await _all_of([_first(bot, room) for room in rooms[bot]])
        for _ in range(2):
            for bot in bots:
                await self._load_turn(bot, rooms[bot])
        for bot in bots:
            self._resident[bot.name] = before[bot], resident_bytes(bot.pid)

    async def _open_rooms(self, bot: ChatBot, people: Sequence[MatrixUser]) -> list[ChatRoom]:
        async def one(cell: int) -> ChatRoom:
            writer, *others = people[cell * MEMBERS : (cell + 1) * MEMBERS]
            return ChatRoom(await _opened(bot, writer, others, encrypted=True), writer, cell)

        return await _all_of([one(cell) for cell in range(self._load.rooms)])

    async def _load_turn(self, bot: ChatBot, rooms: Sequence[ChatRoom]) -> None:
        load = self._load
        times_ns: list[int] = []
        with self._recorder.turn(f"{bot.name}, {load.rooms} rooms", of=2) as told:
            begun_s = time.monotonic()
            async with asyncio.TaskGroup() as asked:
                for number in range(int(load.per_s * load.lasts_s)):
                    due_s = begun_s + number / load.per_s
                    await asyncio.sleep(max(0.0, due_s - time.monotonic()))
                    room = rooms[number % len(rooms)]
                    asked.create_task(self._due(bot, room, due_s, times_ns))
            told.saw(len(times_ns) / (time.monotonic() - begun_s), times_ns or [0])
            self._seen.setdefault((f"{load.rooms} rooms", bot.name), []).append(times_ns)

    async def _due(self, bot: ChatBot, room: ChatRoom, due_s: float, times_ns: list[int]) -> None:
        self._sent[bot.name] = self._sent.get(bot.name, 0) + 1
        late_ns = int((time.monotonic() - due_s) * 1e9)
        try:
            took_ns = await room.writer.ask(room.id, f"cell{room.cell} sort", ends=bot.ends)
        except ChatFault:
            self._lost[bot.name] = self._lost.get(bot.name, 0) + 1
        else:
            times_ns.append(late_ns + took_ns)

    # ---- what was seen ----

    def report(self) -> BenchReport:
        """Return what was seen until now."""
        load = self._load
        return BenchReport(
            machine=machine(),
            method=METHOD.format(
                turns=load.turns,
                messages=load.messages,
                pause_ms=PAUSE_S * 1e3,
                rooms=load.rooms,
                members=MEMBERS,
                people=load.people,
                per_s=load.per_s,
                lasts_s=2 * load.lasts_s,
            ),
            cases=tuple(self._cases()),
            tables=self._memory(),
            ratios=tuple(self._ratios()),
            findings=tuple(self._told(mode) for mode in self._modes()),
            failures=tuple(
                NOT_ANSWERED.format(bot=bot, lost=lost, sent=self._sent[bot])
                for bot, lost in self._lost.items()
            ),
        )

    def _cases(self) -> list[BenchCase]:
        cases = []
        for case in self._recorder.cases(tails=True):
            bot = case.name.partition(",")[0]
            if case.name.endswith(" rooms"):
                lost = self._lost.get(bot, 0) / max(1, self._sent.get(bot, 0))
                cases.append(structs.replace(case, lost_share=lost))
            else:
                cases.append(case)
        return cases

    def _modes(self) -> list[str]:
        modes = dict.fromkeys(mode for mode, _ in self._seen)
        return [mode for mode in modes if all((mode, bot) in self._seen for bot in (ROSIC, ECHO))]

    def _ratios(self) -> list[BenchRatio]:
        found = []
        for mode in self._modes():
            own, echo = self._seen[mode, ROSIC], self._seen[mode, ECHO]
            for name, share in (("p50", 0.5), ("p99", 0.99)):
                by_turn = [
                    quantile(one, share) / quantile(other, share)
                    for one, other in zip(own, echo, strict=False)
                    if one and other
                ]
                if by_turn:
                    value = quantile(_all(own), share) / quantile(_all(echo), share)
                    found.append(
                        BenchRatio(
                            name=f"{mode}: {name} beside the echo",
                            value=round(value, 3),
                            spread=spread_of(by_turn),
                            of="from a message until its answer is read: ROSIC, by a bare echo",
                        )
                    )
        return found

    def _told(self, mode: str) -> str:
        own, echo = (_all(self._seen[mode, bot]) for bot in (ROSIC, ECHO))
        return SAID.format(
            mode=mode.capitalize(),
            own_ms=quantile(own, 0.5) / 1e6,
            own_p99_ms=quantile(own, 0.99) / 1e6,
            echo_ms=quantile(echo, 0.5) / 1e6,
            echo_p99_ms=quantile(echo, 0.99) / 1e6,
        )

    def _memory(self) -> tuple[BenchTable, ...]:
        rows = tuple(
            (
                bot,
                round(before / KIB**2, 1),
                round(after / KIB**2, 1),
                round((after - before) / KIB / self._load.rooms, 1),
            )
            for bot, (before, after) in self._resident.items()
        )
        columns = ("bot", "before, MiB", "with its rooms, MiB", "each room, KiB")
        return (BenchTable(title="Memory", columns=columns, rows=rows),) if rows else ()


def _all(turns: Sequence[Sequence[int]]) -> list[int]:
    return [time_ns for turn in turns for time_ns in turn]


# ---- the parts ----


def _gateway_config(account: Account, people: Sequence[Account], cells: int, folder: Path) -> str:
    text = GATEWAY.format(
        listen="{listen}",
        url=account.url,
        user=account.user,
        password=account.password,
        folder=folder / "keys",
    )
    for number, person in enumerate(people):
        text += PERSON.format(number=number, user=person.user)
    for number in range(cells):
        file = folder / f"cell{number}.yaml"
        file.write_text(CELL.format(number=number), encoding="utf-8")
        text += ROBOT.format(profile=file.name)
    return text


@contextmanager
def _gateway(
    account: Account, people: Sequence[Account], cells: int, folder: Path
) -> Iterator[ChatBot]:
    """Run a gateway for everybody, with so many robots."""
    place = folder / "gateway"
    place.mkdir()
    port = free_port()
    config = _gateway_config(account, people, cells, place).replace("{listen}", f"{LOCAL}:{port}")
    with gateway_process(place, config, port) as process:
        yield ChatBot(ROSIC, account.user, "done", process.pid)


@asynccontextmanager
async def _echo(account: Account, folder: Path) -> AsyncIterator[ChatBot]:
    """Run the bot that sends back what it is sent.

    Raises:
        ConfigurationError: It does not start.
    """
    place = folder / "echo"
    place.mkdir()
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *("-m", "rosic.bench.matrix_echo"),
        *(account.url, account.user, account.password, str(place)),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
    )
    try:
        assert process.stdout is not None  # noqa: S101 - asked for just above
        async with asyncio.timeout(STARTS_WITHIN_S):
            if not await process.stdout.readline():
                raise ConfigurationError("The echo beside ROSIC did not start.")
        yield ChatBot(ECHO, account.user, "", process.pid)
    finally:
        if process.returncode is None:
            process.kill()
        await process.wait()


async def _opened(
    bot: ChatBot, writer: MatrixUser, others: Sequence[MatrixUser], *, encrypted: bool
) -> str:
    """Make a room with a bot and people in it; return its identifier."""
    room = await writer.create_room(*(other.user for other in others), encrypted=encrypted)
    for other in others:
        await other.join(room)
    await writer.invite(room, bot.user)
    await writer.until_joined(room, bot.user)
    return room


async def _first(bot: ChatBot, room: ChatRoom) -> None:
    await room.writer.ask(room.id, f"cell{room.cell} sort", ends=bot.ends)


async def _all_of(asked: Sequence[Coroutine[Any, Any, T]]) -> list[T]:
    """Wait for all of them, a few at a time."""
    places = asyncio.Semaphore(AT_ONCE)

    async def one(waiting: Coroutine[Any, Any, T]) -> T:
        async with places:
            return await waiting

    return await asyncio.gather(*map(one, asked))


def resident_bytes(pid: int) -> int:
    """Return what a process has resident."""
    found = RESIDENT.search(Path(f"/proc/{pid}/status").read_text(encoding="ascii"))
    return int(found[1]) * KIB if found else 0
