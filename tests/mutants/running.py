"""A plugin of pytest: collects tests once, then forks a run of them for each mutant.

A fork has everything loaded. It gets new code for the one function that is changed, runs the tests
that reach the changed line, the quickest first, and ends with the first that fails. That test then
runs without the change: only if it passes as the machine is now has it noticed the mutant.
"""

from __future__ import annotations

import ast
import gc
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from functools import partial
from inspect import CO_ITERABLE_COROUTINE
from pathlib import Path
from types import CodeType, FunctionType
from typing import TYPE_CHECKING

import msgspec
import pytest
from hypothesis import HealthCheck, Phase, settings

from tests.mutants.mutation import NOTHING, REACHED, Mutant, marked, mutants, mutated

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from io import FileIO

    Become = Callable[[], bool]
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
    PROFILE,
    deadline=None,
    database=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
    phases=[Phase.explicit, Phase.generate],
)


class Order(msgspec.Struct, frozen=True, kw_only=True):
    """What is to be tried.

    Attributes:
        source: The file that is changed, as it was imported.
        ids: Of its mutants.
        results: Where one `Result` a line goes.
        seconds: Tests go on for so long per mutant, at most: of processor time, for on a busy
            machine fewer tests would else be asked; or three times as long by the clock.
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
    """What became of one mutant.

    Attributes:
        id: Its name.
        line: Where its statement begins.
        end: One of the words above.
        tests: So many reach it.
        seconds: It took so long.
        by: The test that noticed it, if one did.
    """

    id: str
    line: int
    end: str
    tests: int
    seconds: float
    by: str = ""


class Reach(msgspec.Struct, frozen=True):
    """What one test did without a change: which statements it reached, and how it went.

    Attributes:
        lines: In which these statements begin.
        seconds: It took so long.
        passed: It did not fail.
    """

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
    reaches = _measured(
        session, functions, compile(marked(text), order.source, "exec", dont_inherit=True)
    )
    failing = [item for item, reach in zip(session.items, reaches, strict=True) if not reach.passed]
    with Path(order.results).open("ab", buffering=0) as results:
        results.write(msgspec.json.encode({"failing": [item.nodeid for item in failing]}) + b"\n")
        for name in order.ids:
            if time.time() > order.until_s:
                break
            mutant = known[name]
            began = time.monotonic()
            items = _that_reach(mutant, session.items, reaches)
            become = partial(_become, functions, text, mutant, order.source)
            end, by = _end_of(session, items, order, become)
            took = round(time.monotonic() - began, 2)
            result = Result(name, mutant.first, end, len(items), took, by)
            results.write(msgspec.json.encode(result) + b"\n")
    return True


# ---- without a change ----


def _measured(
    session: pytest.Session, functions: list[FunctionType], code: CodeType
) -> list[Reach]:
    """Run every test once, in a fork of its own, and see which statements of the source it reaches.

    The source says so by itself: a trace of all calls would cost so much that tests fail of it.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.close(reading)
        lines: set[int] = set()
        for function in functions:
            function.__globals__[REACHED] = lines.add
        _take_over(functions, code)
        with os.fdopen(writing, "wb") as out, _own_folder(session):
            for item, following in _in_turn(session.items):
                lines.clear()
                reach = _reach(session, item, following, lines)
                out.write(msgspec.json.encode(reach) + b"\n")
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as found:
        reaches = [msgspec.json.decode(line, type=Reach) for line in found]
    os.waitpid(child, 0)
    return reaches


def _in_turn(items: list[pytest.Item]) -> Iterator[tuple[pytest.Item, pytest.Item]]:
    """Go through tests, each with the next; a fork that ends need not take anything down."""
    return zip(items, [*items[1:], *items[-1:]], strict=True)


def _reach(
    session: pytest.Session, item: pytest.Item, following: pytest.Item, lines: set[int]
) -> Reach:
    failed, began = session.testsfailed, time.monotonic()
    _run(item, following)
    passed = session.testsfailed == failed
    return Reach(frozenset(lines), time.monotonic() - began, passed)


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


def _end_of(session: pytest.Session, items: Timed, order: Order, become: Become) -> tuple[str, str]:
    """Return what became of a mutant, and which test noticed it.

    A test that fails without the change too, on a machine that has much else to do, has noticed
    nothing: the others are then asked.
    """
    left = list(items)
    while left:
        end, ran = _tried(session, left, order, become)
        if end not in {KILLED, TIMED_OUT}:
            return end, ""
        noticed = left.pop(ran - 1)
        if _confirmed(session, noticed, order, become, end):
            return end, noticed[0].nodeid
    return (SURVIVED if items else UNREACHED), ""


def _confirmed(
    session: pytest.Session,
    noticed: tuple[pytest.Item, float],
    order: Order,
    become: Become,
    end: str,
) -> bool:
    """Return whether a test passes without the change, and, if it took too long, does so again."""
    unchanged, _ = _tried(session, [noticed], order, _stay)
    if unchanged != SURVIVED or end == KILLED:
        return unchanged == SURVIVED
    return _tried(session, [noticed], order, become)[0] != SURVIVED


def _stay() -> bool:
    """Become nothing else."""
    return True


def _tried(session: pytest.Session, items: Timed, order: Order, become: Become) -> tuple[str, int]:
    """Run tests in a fork that becomes a mutant; return its end, and how many tests it began."""
    each_s = [5 * seconds + order.slack_s for _, seconds in items]
    folder = tempfile.mkdtemp(prefix="mutant-", dir=FOLDER)
    beats, beating = os.pipe()
    child = os.fork()
    if not child:
        os.setsid()
        _fork(session, items, Path(folder), become, beating, order.seconds)
    os.close(beating)
    with open(beats, "rb", buffering=0) as heard:  # noqa: PTH123 - a pipe
        status, ran = _waited(child, heard, each_s)
    shutil.rmtree(folder, ignore_errors=True)
    assert status != UNFIT, "the mutant could not be tried; the log says why"
    return ENDS.get(status, KILLED), ran


def _waited(child: int, beats: FileIO, each_s: list[float]) -> tuple[int, int]:
    """Return how a fork ended, and how many tests it began.

    It is ended with whatever it began when a test takes too long.
    """
    os.set_blocking(beats.fileno(), False)
    until = time.monotonic() + each_s[0]
    ended = status = ran = 0
    while not ended:
        begun = len(beats.read(64) or b"")
        if begun:
            ran += begun
            until = time.monotonic() + each_s[ran - 1]
        if time.monotonic() > until:
            os.killpg(child, signal.SIGKILL)
            _, status = os.waitpid(child, 0)
            return os.waitstatus_to_exitcode(status), ran
        time.sleep(LOOK_EVERY_S)
        ended, status = os.waitpid(child, os.WNOHANG)
    _end_group(child)
    while begun := len(beats.read(64) or b""):
        ran += begun
    return os.waitstatus_to_exitcode(status), ran


def _end_group(leader: int) -> None:
    try:
        os.killpg(leader, signal.SIGKILL)
    except ProcessLookupError:
        return


def _fork(
    session: pytest.Session,
    items: Timed,
    folder: Path,
    become: Become,
    beating: int,
    within_s: float,
) -> None:
    """Be a mutant, run its tests, and say by the exit status whether one of them failed."""
    status = UNFIT
    try:
        session.config._tmp_path_factory._basetemp = folder  # type: ignore[attr-defined]
        used = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (_size() + MORE_BYTES, used[1]))
        status = _first_failure(session, items, within_s, beating) if become() else 3
    except BaseException:
        traceback.print_exc()
        raise
    finally:
        sys.stderr.flush()
        os._exit(status)


def _size() -> int:
    pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[0]
    return int(pages) * resource.getpagesize()


def _first_failure(session: pytest.Session, items: Timed, within_s: float, beating: int) -> int:
    until = time.monotonic() + 3 * within_s
    for item, following in _in_turn([item for item, _ in items]):
        os.write(beating, b".")
        _run(item, following)
        if session.testsfailed:
            return 1
        if time.process_time() > within_s or time.monotonic() > until:
            break
    return 0


def _become(functions: list[FunctionType], text: str, mutant: Mutant, source: str) -> bool:
    """Give changed functions their new code or default. Return whether anything changed."""
    if mutant.parameter:
        return _take_default(functions, mutant)
    compiled = compile(mutated(text, mutant.id), source, "exec", dont_inherit=True)
    return _take_over(functions, compiled) > 0


def _take_over(functions: list[FunctionType], compiled: CodeType) -> int:
    """Give functions their code in a changed source. Return how many changed."""
    codes = {(code.co_qualname, code.co_firstlineno): code for code in _codes(compiled)}
    changed = 0
    for function in functions:
        code = function.__code__
        new = codes.get((code.co_qualname, code.co_firstlineno))
        if new is None or new.co_freevars != code.co_freevars:
            continue
        # `types.coroutine` marks the code itself; without that it can be awaited no more.
        new = new.replace(co_flags=new.co_flags | code.co_flags & CO_ITERABLE_COROUTINE)
        if new != code:
            function.__code__ = new
            changed += 1
    return changed


def _take_default(functions: list[FunctionType], mutant: Mutant) -> bool:
    """Give a parameter another default, which was made when its module was loaded."""
    other = _do_nothing if mutant.after == NOTHING else ast.literal_eval(mutant.after)
    changed = False
    for function in functions:
        code, defaults = function.__code__, function.__defaults__ or ()
        if function.__qualname__ != mutant.function:
            continue
        if function.__kwdefaults__ is not None and mutant.parameter in function.__kwdefaults__:
            function.__kwdefaults__ = function.__kwdefaults__ | {mutant.parameter: other}
            changed = True
        named = code.co_varnames[: code.co_argcount][code.co_argcount - len(defaults) :]
        if mutant.parameter in named:
            index = named.index(mutant.parameter)
            function.__defaults__ = (*defaults[:index], other, *defaults[index + 1 :])
            changed = True
    return changed


def _do_nothing(*_: object, **__: object) -> None:
    """Stand in for whatever would be called."""


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
