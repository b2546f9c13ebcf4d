"""Processes of a journey: the fake server, the launcher, gateways. Each is gone in the end."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import time
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rosic.testing.telegram import Control
from tests.journeys.fleet import TOKEN
from tests.journeys.gateway import COLD, Command, Start
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

ROOT = Path(__file__).parents[2]
STARTING_S = 120.0 * pace()
WITHIN_S = 60.0 * pace()
LOOK_EVERY_S = 0.01
LISTENING = "lab: listening"


def environment() -> dict[str, str]:
    """Return the environment of a process that finds ROSIC and these journeys."""
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    # What the caller asks for comes first: a copy of the source in which a guard is taken out.
    paths = [*filter(None, [own.get("PYTHONPATH")]), str(ROOT / "src"), str(ROOT)]
    return own | {"PYTHONPATH": os.pathsep.join(paths), "TZ": "UTC"}


class Launcher:
    """`tests.journeys.gateway` in a process of its own.

    Args:
        options: `COLD`, or nothing.
    """

    def __init__(self, *options: str) -> None:
        self._process = subprocess.Popen(  # noqa: S603 - our own program
            [sys.executable, "-m", "tests.journeys.gateway", *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
            cwd=ROOT,
            env=environment(),
        )
        self._expect_ready()

    def _expect_ready(self) -> None:
        assert self._process.stdout is not None
        said = self._process.stdout.readline()
        assert said == "ready\n", f"the launcher said {said!r}"

    def ask(self, command: Command) -> int:
        """Give one command and return its answer."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(msgspec.json.encode(command).decode() + "\n")
        self._process.stdin.flush()
        return int(self._process.stdout.readline())

    def close(self) -> None:
        """End it, and with it whatever gateways are left."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()


class Forked:
    """A gateway's process, or that of the fake server.

    Args:
        cold: Start a launcher of its own for it: what is measured includes importing everything.

    Attributes:
        pid: Its id.
        began_s: Monotonic clock when it was started.
    """

    def __init__(self, launcher: Launcher, start: Start, *, cold: bool = False) -> None:
        self._log = Path(start.log)
        self._log.touch()
        self._from = self._log.stat().st_size
        self._ended: int | None = None
        self.began_s = time.monotonic()
        self._own = Launcher(COLD) if cold else None
        self._launcher = self._own or launcher
        self.pid = self._launcher.ask(Command(start=start))

    def log(self) -> str:
        """Return what it has said so far."""
        with self._log.open("rb") as file:
            file.seek(self._from)
            return file.read().decode(errors="replace")

    async def says(self, text: str, within_s: float = WITHIN_S, *, times: int = 1) -> bool:
        """Wait until its log has a text so many times. Return whether it has, in time."""
        end_s = time.monotonic() + within_s
        while self.log().count(text) < times:
            if time.monotonic() > end_s or self.is_gone():
                return self.log().count(text) >= times
            await asyncio.sleep(LOOK_EVERY_S)
        return True

    def is_gone(self) -> bool:
        """Whether the process has ended, reaped or not."""
        if self._ended is not None:
            return True
        try:
            state = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return True
        return state == "Z"

    def kill(self) -> int:
        """SIGKILL, now; return the exit status."""
        return self.end(signal.SIGKILL)

    def end(self, number: signal.Signals = signal.SIGTERM) -> int:
        """Send a signal and wait for the end; return the exit status. Blocks for seconds."""
        if self._ended is None:
            os.kill(self.pid, number)
        return self._reap()

    def _reap(self) -> int:
        if self._ended is None:
            self._ended = self._launcher.ask(Command(reap=self.pid))
            if self._own is not None:
                self._own.close()
        return self._ended

    async def ends(self, within_s: float, number: signal.Signals | None = None) -> int:
        """Wait for it to end, perhaps after a signal; return the exit status.

        Raises:
            AssertionError: It has not ended in time. It still runs.
        """
        if number is not None:
            os.kill(self.pid, number)
        end_s = time.monotonic() + within_s
        while not self.is_gone():
            assert time.monotonic() < end_s, f"it has not ended: {self.log()}"
            await asyncio.sleep(LOOK_EVERY_S)
        return self._reap()


class Gateway(Forked):
    """One gateway's process."""

    async def listens(self, within_s: float = WITHIN_S) -> float:
        """Wait until it listens; return how long that took since it was started, in seconds."""
        assert await self.says(LISTENING, within_s), f"it does not listen: {self.log()}"
        return time.monotonic() - self.began_s


@asynccontextmanager
async def fake_telegram(folder: Path, launcher: Launcher, *options: str) -> AsyncIterator[Control]:
    """Let the fake server run in a process of its own while inside; its log is in the folder."""
    start = Start(log=str(folder / "telegram.log"), server=("--token", TOKEN, *options))
    server = Forked(launcher, start)
    try:
        assert await server.says("ready ", STARTING_S), f"no server: {server.log()}"
        async with Control(server.log().removeprefix("ready ").strip()) as control:
            yield control
    finally:
        try:
            await server.ends(10, signal.SIGTERM)
        except AssertionError:
            server.kill()
