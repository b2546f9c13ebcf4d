"""`python -m tests.planted.nursery`: forks runs of pytest in which everything foreign is loaded.

It reads one JSON object a line from standard input, `Run`, and answers each with one line: the
exit status. Nothing of ROSIC is loaded before a run, which brings a source of its own; what other
people wrote is the same for all, and takes longer to load than most faults to be caught.
"""

from __future__ import annotations

import gc
import os
import random
import signal
import sys
from contextlib import suppress
from functools import partial
from importlib import import_module
from importlib.metadata import entry_points
from typing import TYPE_CHECKING

import msgspec
import pytest

if TYPE_CHECKING:
    from types import FrameType

# What is missing here is loaded in each run that needs it, and takes its time.
WARM = (
    "hypothesis",
    "hypothesis.strategies",
    "hypothesis.internal.conjecture.engine",
    "nacl.pwhash",
    "nacl.secret",
    "PIL.Image",
    "scipy.optimize",
    "segno",
    "sqlalchemy",
    "telegram",
    "telegram.ext",
    "aiohttp.web",
    "dateutil.rrule",
    "graphlib",
    "packaging.version",
    "pdb",
    "readline",
    "yaml",
)
# What they bring is used by none of the tests that catch a fault, and takes long to load.
UNUSED = ("faker", "schemathesis", "xdist", "xdist.looponfail")
# The rewriting of assertions wants to see plugins before they are loaded. It need not see these.
QUIETLY = ("-W", "ignore::pytest.PytestAssertRewriteWarning")


class Run(msgspec.Struct, frozen=True, kw_only=True):
    """One run.

    Attributes:
        arguments: Of pytest.
        paths: Where modules are looked for first.
        log: Where all goes that it says.
        within_s: It is killed when it takes longer.
    """

    arguments: tuple[str, ...]
    paths: tuple[str, ...]
    log: str
    within_s: int


def main() -> None:
    """Serve until standard input ends."""
    for module in WARM:
        with suppress(ModuleNotFoundError):
            import_module(module)
    for plugin in entry_points(group="pytest11"):
        if plugin.name not in UNUSED:
            plugin.load()
    assert "rosic" not in sys.modules, "each run brings its own"
    gc.freeze()  # what is loaded here is no litter of a run, which need not look for any in it
    for line in sys.stdin:
        run = msgspec.json.decode(line, type=Run)
        child = os.fork()
        if not child:
            _become(run)
        sys.stdout.write(f"{_end_of(child, run.within_s)}\n")
        sys.stdout.flush()


def _end_of(child: int, within_s: int) -> int:
    """Return how it ended; a negative number is the signal that ended it."""
    signal.signal(signal.SIGALRM, partial(_kill, child))
    signal.alarm(within_s)
    _, status = os.waitpid(child, 0)
    signal.alarm(0)
    return os.waitstatus_to_exitcode(status)


def _kill(child: int, _signal: int, _frame: FrameType | None) -> None:
    os.kill(child, signal.SIGKILL)


def _become(run: Run) -> None:
    """Be that run, and nothing else any more."""
    status = 70
    try:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        nothing = os.open(os.devnull, os.O_RDONLY)
        log = os.open(run.log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        os.dup2(nothing, 0)
        os.dup2(log, 1)
        os.dup2(log, 2)
        os.environ["PYTHONPATH"] = os.pathsep.join(run.paths)
        sys.path[:0] = run.paths
        random.seed()
        gc.disable()  # until all is loaded: none of that is litter
        without = [f"-pno:{name}" for name in UNUSED]
        status = int(pytest.main([*QUIETLY, *without, *run.arguments]))
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


if __name__ == "__main__":
    main()
