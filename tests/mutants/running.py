"""A plugin of pytest: collects tests once, then forks a run of them for each mutant.

A fork has everything loaded. It gets new code for the one function that is changed, runs the tests
that reach the changed line, the quickest first, and ends with the first that fails.
"""

from __future__ import annotations

import gc
import os
import resource
import shutil
import signal
import sys
import tempfile
import threading
import time
import traceback
from functools import partial
from pathlib import Path
from types import CodeType, FunctionType
from typing import TYPE_CHECKING

import msgspec
import pytest
from hypothesis import HealthCheck, Phase, settings

from tests.mutants.mutation import Mutant, mutants, mutated

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from io import FileIO
    from types import FrameType

    from _typeshed import TraceFunction

    Become = Callable[[], float | None]
    Timed = list[tuple[pytest.Item, float]]

ORDER = "ROSIC_MUTANTS_ORDER"
PROFILE = "mutants"
KILLED, SURVIVED, TIMED_OUT = "killed", "survived", "timed out"
UNREACHED = "unreached"  # no test reaches the line: it survived
SAME = "same"  # compiled, nothing has changed
ENDS = {0: SURVIVED, 1: KILLED, 3: SAME, -signal.SIGKILL: TIMED_OUT}
# In memory, where there is such a place: no test of a mutant has to wait for a real disk.
FOLDER = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None  # noqa: S108
UNFIT = 4  # it is not the mutant that failed
MORE_BYTES = 2 << 30  # a mutant that never stops collecting comes to its end
LOOK_EVERY_S = 0.005

# Every run of a mutant tries the same examples: what one run kills, the next one kills.
settings.register_profile(
    PROFILE, deadline=None, database=None, derandomize=True,
    suppress_health_check=[HealthCheck.too_slow], phases=[Phase.explicit, Phase.generate],
)  # fmt: skip


class Order(msgspec.Struct, frozen=True, kw_only=True):
    """What is to be tried.

    Attributes:
        source: The file that is changed, as it was imported.
        ids: Of its mutants.
        results: Where one `Result` a line goes.
        seconds: Tests go on for so long per mutant, at most.
        slack_s: They may take so much longer than they took without a change.
        until_s: By the wall clock; none is begun after it.
    """

    source: str
    ids: tuple[str, ...]
    results: str
    seconds: float
    slack_s: float
    until_s: float


class Result(msgspec.Struct, frozen=True):
    """What became of one mutant."""

    id: str
    line: int
    end: str
    tests: int
    seconds: float


class Reach(msgspec.Struct, frozen=True):
    """What one test did without a change: the lines that it reached, and how it went."""

    lines: frozenset[int]
    seconds: float
    passed: bool


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> bool:
    """Run every mutant instead of every test once."""
    order = msgspec.json.decode(Path(os.environ[ORDER]).read_bytes(), type=Order)
    text = Path(order.source).read_text(encoding="utf-8")
    known = mutants(text)
    functions = _functions_of(order.source)
    reaches = _measured(session, order.source)
    failing = [item for item, reach in zip(session.items, reaches, strict=True) if not reach.passed]
    with Path(order.results).open("ab", buffering=0) as results:
        results.write(msgspec.json.encode({"failing": [item.nodeid for item in failing]}) + b"\n")
        for name in order.ids:
            if time.time() > order.until_s:
                break
            mutant = known[name]
            began = time.monotonic()
            items = _that_reach(mutant, session.items, reaches)
            end = _end_of(session, items, order, partial(_become, functions, text, mutant, order))
            took = round(time.monotonic() - began, 2)
            result = Result(name, mutant.first, end, len(items), took)
            results.write(msgspec.json.encode(result) + b"\n")
    return True


# ---- without a change ----


def _measured(session: pytest.Session, source: str) -> list[Reach]:
    """Run every test once, in a fork of its own, and see which lines of the source it reaches."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.close(reading)
        with os.fdopen(writing, "wb") as out, _own_folder(session):
            for item, following in _in_turn(session.items):
                reach = _reach(session, item, following, source)
                out.write(msgspec.json.encode(reach) + b"\n")
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as found:
        reaches = [msgspec.json.decode(line, type=Reach) for line in found]
    os.waitpid(child, 0)
    return reaches


class Tracer:
    """Sees which lines of one source are reached, in every thread."""

    def __init__(self, source: str) -> None:
        self.lines: set[int] = set()
        self._source = source

    def enter(self, frame: FrameType, _event: str, _argument: object) -> TraceFunction | None:
        """A function is called."""
        return self.note if frame.f_code.co_filename == self._source else None

    def note(self, frame: FrameType, _event: str, _argument: object) -> TraceFunction | None:
        """A line is reached."""
        self.lines.add(frame.f_lineno)
        return self.note


def _in_turn(items: list[pytest.Item]) -> Iterator[tuple[pytest.Item, pytest.Item]]:
    """Go through tests, each with the next; a fork that ends need not take anything down."""
    return zip(items, [*items[1:], *items[-1:]], strict=True)


def _reach(
    session: pytest.Session, item: pytest.Item, following: pytest.Item, source: str
) -> Reach:
    failed, began = session.testsfailed, time.monotonic()
    tracer = Tracer(source)
    threading.settrace(tracer.enter)
    sys.settrace(tracer.enter)
    try:
        _run(item, following)
    finally:
        sys.settrace(None)
        threading.settrace(None)
    passed = session.testsfailed == failed
    return Reach(frozenset(tracer.lines), time.monotonic() - began, passed)


def _run(item: pytest.Item, following: pytest.Item) -> None:
    """Run one test; what the following one needs as well stays."""
    item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)


def _that_reach(mutant: Mutant, items: list[pytest.Item], reaches: list[Reach]) -> Timed:
    lines = set(range(mutant.first, mutant.last + 1))
    found = [
        (item, reach.seconds)
        for item, reach in zip(items, reaches, strict=True)
        if reach.passed and not lines.isdisjoint(reach.lines)
    ]
    return sorted(found, key=lambda each: each[1])


# ---- with a change ----


def _end_of(session: pytest.Session, items: Timed, order: Order, become: Become) -> str:
    """Run tests in a fork that becomes a mutant; return what became of it."""
    if not items:
        return UNREACHED
    within_s = 5 * max(seconds for _, seconds in items) + order.slack_s
    folder = tempfile.mkdtemp(prefix="mutant-", dir=FOLDER)
    beats, beating = os.pipe()
    child = os.fork()
    if not child:
        os.setsid()
        _fork(session, items, Path(folder), become, beating)
    os.close(beating)
    with open(beats, "rb", buffering=0) as heard:  # noqa: PTH123 - a pipe
        status = _waited(child, heard, within_s)
    shutil.rmtree(folder, ignore_errors=True)
    assert status != UNFIT, "the mutant could not be tried; the log says why"
    return ENDS.get(status, KILLED)


def _waited(child: int, beats: FileIO, within_s: float) -> int:
    """Return how a fork ended. It is ended with whatever it began when a test takes too long."""
    os.set_blocking(beats.fileno(), False)
    until = time.monotonic() + within_s
    ended = status = 0
    while not ended:
        if beats.read(64):
            until = time.monotonic() + within_s
        if time.monotonic() > until:
            os.killpg(child, signal.SIGKILL)
            _, status = os.waitpid(child, 0)
            return os.waitstatus_to_exitcode(status)
        time.sleep(LOOK_EVERY_S)
        ended, status = os.waitpid(child, os.WNOHANG)
    _end_group(child)
    return os.waitstatus_to_exitcode(status)


def _end_group(leader: int) -> None:
    try:
        os.killpg(leader, signal.SIGKILL)
    except ProcessLookupError:
        return


def _fork(
    session: pytest.Session, items: Timed, folder: Path, become: Become, beating: int
) -> None:
    """Be a mutant, run its tests, and say by the exit status whether one of them failed."""
    status = UNFIT
    try:
        session.config._tmp_path_factory._basetemp = folder  # type: ignore[attr-defined]
        used = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (_size() + MORE_BYTES, used[1]))
        until = become()
        status = 3 if until is None else _first_failure(session, items, until, beating)
    except BaseException:
        traceback.print_exc()
        raise
    finally:
        sys.stderr.flush()
        os._exit(status)


def _size() -> int:
    pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[0]
    return int(pages) * resource.getpagesize()


def _first_failure(session: pytest.Session, items: Timed, until: float, beating: int) -> int:
    for item, following in _in_turn([item for item, _ in items]):
        os.write(beating, b".")
        _run(item, following)
        if session.testsfailed:
            return 1
        if time.monotonic() > until:
            break
    return 0


def _become(functions: list[FunctionType], text: str, mutant: Mutant, order: Order) -> float | None:
    """Give changed functions their new code. Return until when to try; None if nothing changed."""
    compiled = compile(mutated(text, mutant.id), order.source, "exec", dont_inherit=True)
    codes = {(code.co_qualname, code.co_firstlineno): code for code in _codes(compiled)}
    changed = 0
    for function in functions:
        code = function.__code__
        new = codes.get((code.co_qualname, code.co_firstlineno))
        if new is not None and new != code and new.co_freevars == code.co_freevars:
            function.__code__ = new
            changed += 1
    return time.monotonic() + order.seconds if changed else None


def _codes(code: CodeType) -> Iterator[CodeType]:
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant
            yield from _codes(constant)


def _functions_of(source: str) -> list[FunctionType]:
    return [
        found
        for found in gc.get_objects()
        if isinstance(found, FunctionType) and found.__code__.co_filename == source
    ]


class _own_folder:  # noqa: N801 - used as a context
    """Keeps what tests write out of the folder of the whole run."""

    def __init__(self, session: pytest.Session) -> None:
        self._factory = session.config._tmp_path_factory  # type: ignore[attr-defined]
        self._folder = tempfile.mkdtemp(prefix="mutants-", dir=FOLDER)

    def __enter__(self) -> None:
        self._factory._basetemp = Path(self._folder)

    def __exit__(self, *_error: object) -> None:
        shutil.rmtree(self._folder, ignore_errors=True)
