"""A ROS 2 graph of its own for one test, and the processes on it."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING, Self

from rosic.testing.ros2.domain import Domain
from rosic.testing.ros2.environment import environment_of_a_graph
from rosic.testing.ros2.shared_memory import sweep

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path
    from types import TracebackType

READY = "ready"

_LINES_KEPT = 2000
_LAST_WORDS = 30


class RosProcess:
    """A program in a process of its own, and what it says.

    A node for tests says `READY` on a line when it is up, takes commands as lines on its standard
    input, and ends when that ends: then it does not outlive a test that was killed.

    Attributes:
        process: The process itself.
        lines: The last lines it wrote, to standard output and standard error alike.
    """

    def __init__(
        self,
        command: Sequence[str],
        environment: dict[str, str],
        patience_s: float = 3.0,
    ) -> None:
        """Start it.

        Args:
            command: Program and arguments.
            environment: All of it.
            patience_s: How long each way of ending it is given.
        """
        self._patience_s = patience_s
        self.lines: deque[str] = deque(maxlen=_LINES_KEPT)
        self._unseen: deque[str] = deque(maxlen=_LINES_KEPT)
        self._over = False
        self._heard = threading.Condition()
        self.process = subprocess.Popen(  # noqa: S603 - the test names the program
            command,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            bufsize=1,
        )
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    def say(self, line: str) -> None:
        """Write one line to its standard input."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()

    def expect(self, beginning: str, *, timeout_s: float = 60.0) -> str:
        """Wait for a line, from the first not yet looked at, and return what follows ``beginning``.

        It blocks: on an event loop, call it through `asyncio.to_thread`.

        Raises:
            AssertionError: The process ended, or the time did. Carries its last lines.
        """
        end = time.monotonic() + timeout_s
        with self._heard:
            while True:
                while self._unseen:
                    line = self._unseen.popleft()
                    if line.startswith(beginning):
                        return line.removeprefix(beginning).strip()
                if self._over or not self._heard.wait(end - time.monotonic()):
                    raise AssertionError(self._silence(beginning, timeout_s))

    def stop(self) -> int:
        """End it: by closing its input, then by asking, then by force. Returns its exit code."""
        assert self.process.stdin is not None
        with suppress(BrokenPipeError):
            self.process.stdin.close()
        code = self._ended()
        for persuade in (self.process.terminate, self.process.kill):
            if code is None:
                persuade()
                code = self._ended()
        self._listener.join(self._patience_s)
        assert self.process.stdout is not None
        self.process.stdout.close()
        return self.process.wait()

    def _ended(self) -> int | None:
        try:
            return self.process.wait(self._patience_s)
        except subprocess.TimeoutExpired:
            return None

    def kill(self) -> None:
        """End it as a power cut would."""
        self.process.kill()
        self.process.wait()
        self.stop()

    def _silence(self, beginning: str, timeout_s: float) -> str:
        last = "\n".join(list(self.lines)[-_LAST_WORDS:]) or "(nothing)"
        code = self._ended() if self._over else self.process.poll()
        how = f"it ended with {code}" if code is not None else f"{timeout_s:g} s went by"
        return f"no line began with {beginning!r}, and {how}; it said:\n{last}"

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            with self._heard:
                self.lines.append(line.rstrip("\n"))
                self._unseen.append(self.lines[-1])
                self._heard.notify_all()
        with self._heard:
            self._over = True
            self._heard.notify_all()


class RosGraph:
    """A ROS domain that no other test has, reached from this machine only.

    While it is open this process is on it too: the variables are set in ``os.environ``.

    Attributes:
        domain_id: The domain.
        environment: For processes that are started some other way.
    """

    def __init__(self, folder: Path) -> None:
        """Take a domain; logs of ROS go to ``folder``."""
        self._domain = Domain()
        self.domain_id = self._domain.id
        self._variables = environment_of_a_graph(self.domain_id, folder)
        self._before = {name: os.environ.get(name) for name in self._variables}
        self._processes: list[RosProcess] = []
        self.environment: dict[str, str] = {}

    def __enter__(self) -> Self:
        _set(self._variables)
        self.environment = dict(os.environ)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for process in self._processes:
            process.stop()
        _set(self._before)
        sweep(self.domain_id)
        self._domain.release()

    def start(
        self,
        *command: str | Path,
        python_path: Sequence[Path] = (),
        ready: str | None = READY,
        timeout_s: float = 60.0,
    ) -> RosProcess:
        """Run a Python program on this graph, and wait until it says that it is ready.

        Args:
            command: A script and its arguments, or ``-m`` and a module; run by this Python.
            python_path: Folders that it needs besides, such as built interfaces.
            ready: How the line begins that it says when it is up; None does not wait.
            timeout_s: For that line.
        """
        environment = dict(self.environment)
        folders = [*map(str, python_path), *filter(None, [environment.get("PYTHONPATH")])]
        environment |= {"PYTHONPATH": os.pathsep.join(folders), "PYTHONUNBUFFERED": "1"}
        process = RosProcess([sys.executable, *map(str, command)], environment)
        self._processes.append(process)
        if ready is not None:
            process.expect(ready, timeout_s=timeout_s)
        return process


def _set(variables: dict[str, str | None]) -> None:
    for name, value in variables.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
