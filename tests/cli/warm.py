"""`rosic` in processes of its own that need not load everything first.

`python -m tests.cli.warm` loads once what the commands load, and forks a process for each that is
asked for: the same code as ``python -m rosic``, with its own arguments, environment, folder, input
and output. What has to be seen from the very beginning (what is loaded, what that costs, another
path) is run as a person runs it instead: ``cold``.
"""

from __future__ import annotations

import atexit
import gc
import io
import os
import random
import runpy
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import IO, TYPE_CHECKING

import msgspec

from rosic.cli.main import COMMANDS
from rosic.config.lexicons import known_phrases

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

WARM = (
    *sorted({command.function.partition(":")[0] for command in COMMANDS.values()}),
    "alembic.command",
    "alembic.context",
    "alembic.ddl.sqlite",
    "anyio._backends._asyncio",
    "httpcore",
    "rosic.messengers.telegram",
    "rosic.messengers.terminal",
    "rosic.robots.memory",
    "rosic_sim.robots.robot",
    "sqlalchemy.dialects.sqlite",
    "uvloop",
)
LARGEST = 1 << 17
STARTING = threading.Lock()


class Asked(msgspec.Struct, frozen=True, kw_only=True):
    """One process that is to be; its input, output, errors and its fate come along as files."""

    arguments: tuple[str, ...]
    cwd: str
    env: dict[str, str]


class Warmed:
    """One such process: as much of `subprocess.Popen` as is needed.

    Attributes:
        pid: Its id.
        returncode: None until it is known to have ended.
        stdin: What a test writes to it, if it was given a pipe.
    """

    def __init__(
        self,
        arguments: Sequence[str],
        files: tuple[int, int, int],
        asked_cwd: Path | None,
        env: Mapping[str, str],
    ) -> None:
        self.returncode: int | None = None
        self.stdin: IO[str] | None = None
        asked = Asked(arguments=tuple(arguments), cwd=str(asked_cwd or Path.cwd()), env=dict(env))
        fate, written = os.pipe()
        try:
            message = msgspec.json.encode(asked)
            assert len(message) < LARGEST
            with STARTING:
                server = _server()
            socket.send_fds(server, [message], [*files, written])
        finally:
            os.close(written)
        self._fate = os.fdopen(fate)
        self.pid = int(self._fate.readline())

    def poll(self) -> int | None:
        """Return how it ended, if it has."""
        with suppress(subprocess.TimeoutExpired):
            self.wait(0)
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        """Wait for the end, and return how that was."""
        if self.returncode is None:
            if not select.select([self._fate], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired("rosic", timeout or 0.0)
            self.returncode = int(self._fate.readline())
            self._fate.close()
        return self.returncode

    def send_signal(self, number: int) -> None:
        """Send a signal, unless it has ended."""
        if self.poll() is None:
            os.kill(self.pid, number)

    def terminate(self) -> None:
        """SIGTERM."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """SIGKILL."""
        self.send_signal(signal.SIGKILL)


@cache
def _server() -> socket.socket:
    """Return the way to the process that forks; that ends with this one."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 2 * LARGEST)
    source = str(Path(__file__).parents[2])
    path = os.pathsep.join(filter(None, [f"{source}/src", source, os.environ.get("PYTHONPATH")]))
    with theirs:
        process = subprocess.Popen(  # noqa: S603 - our own program
            [sys.executable, "-m", "tests.cli.warm", str(theirs.fileno())],
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": path},
        )

    def end() -> None:
        ours.close()
        process.wait(60)

    atexit.register(end)
    return ours


# ---- the process that forks ----


class _Server:
    """Forks what is asked for, and says how each ended."""

    def __init__(self, asking: socket.socket) -> None:
        self._asking = asking
        self._fates: dict[int, int] = {}
        self._woken, wake = os.pipe()
        for end in (self._woken, wake):
            os.set_blocking(end, False)
        signal.set_wakeup_fd(wake, warn_on_full_buffer=False)
        signal.signal(signal.SIGCHLD, lambda *_: None)

    def next(self) -> tuple[Asked, list[int]] | None:
        """Return what to become, in a new process; None: there is nothing left to do."""
        while True:
            asking, woken = self._asking.fileno(), self._woken
            ready, _, _ = select.select([asking, woken], [], [])
            if woken in ready:
                os.read(woken, LARGEST)
                self._reap()
            if asking not in ready:
                continue
            message, files, _, _ = socket.recv_fds(self._asking, LARGEST, 4)
            if not message:
                return None
            *standard, fate = files
            pid = os.fork()
            if not pid:
                signal.set_wakeup_fd(-1)
                signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                self._asking.close()
                for other in (fate, *self._fates.values()):
                    os.close(other)
                return msgspec.json.decode(message, type=Asked), standard
            for file in standard:
                os.close(file)
            self._fates[pid] = fate
            os.write(fate, f"{pid}\n".encode())

    def _reap(self) -> None:
        with suppress(ChildProcessError):
            while True:
                pid, status = os.waitpid(-1, os.WNOHANG)
                if not pid:
                    return
                fate = self._fates.pop(pid)
                with suppress(BrokenPipeError):
                    os.write(fate, f"{os.waitstatus_to_exitcode(status)}\n".encode())
                os.close(fate)


def main() -> None:
    """Serve, or become a command and end as it ends."""
    for module in WARM:
        import_module(module)
    known_phrases()
    gc.freeze()
    found = _Server(socket.socket(fileno=int(sys.argv[1]))).next()
    if found is None:
        return
    asked, standard = found
    for number, file in enumerate(standard):
        os.dup2(file, number)
        os.close(file)
    os.environ.clear()
    os.environ.update(asked.env)
    time.tzset()
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=sys.stdout.isatty())  # as it would have begun
    os.chdir(asked.cwd)
    random.seed()
    sys.argv[1:] = asked.arguments
    runpy.run_module("rosic", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
