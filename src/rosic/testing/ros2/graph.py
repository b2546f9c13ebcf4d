"""A ROS 2 graph of its own for one test, and the processes on it."""

from __future__ import annotations

import fcntl
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections import deque
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import IO, TYPE_CHECKING, Self

from rosic.errors import how_to_install

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from types import TracebackType


# ---- a ROS domain of one's own ----

# Ports of higher domains run into those that Linux lends to outgoing connections. 0 is where
# everybody's robots are who never thought about it.
_DOMAINS = range(1, 102)
_LOCKS = "rosic-ros-domains-{user}"


class NoDomainLeft(Exception):
    """Every domain is taken by another test on this machine."""


class Domain:
    """One domain, held by a lock on a file: it is free again when its process ends, however.

    Attributes:
        id: What ``ROS_DOMAIN_ID`` is set to.
    """

    def __init__(self) -> None:
        folder = Path(tempfile.gettempdir()) / _LOCKS.format(user=os.getuid())
        folder.mkdir(mode=0o700, exist_ok=True)
        first = os.getpid() % len(_DOMAINS)  # neighbours start apart, and rarely meet
        for offset in range(len(_DOMAINS)):
            self.id = _DOMAINS[(first + offset) % len(_DOMAINS)]
            lock = _take(folder / f"{self.id}.lock")
            if lock is not None:
                self._lock = lock
                return
        raise NoDomainLeft(f"All {len(_DOMAINS)} ROS domains are taken.")

    def release(self) -> None:
        """Give it back."""
        self._lock.close()


def _take(path: Path) -> IO[str] | None:
    file = path.open("a")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        return None
    return file


BOOTSTRAPPED = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"

_LIBRARIES = "LD_LIBRARY_PATH"
_ELSEWHERE = ("ROS_STATIC_PEERS", "ROS_DISCOVERY_SERVER")


def why_missing() -> str | None:
    """Return the sentence that says how to get ROS 2; None when it is here."""
    if find_spec("rclpy") is not None:
        return None
    return f"ROS 2 is not here: source your distribution, or run {how_to_install('ros2')}."


def environment_for_another_python(environ: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return an environment in which a Python of another virtual environment finds its own.

    Args:
        environ: What to start from; this process's by default.
    """
    environment = dict(os.environ if environ is None else environ)
    environment.pop(BOOTSTRAPPED, None)
    ours = Path(sys.prefix)
    kept = [
        entry
        for entry in environment.pop(_LIBRARIES, "").split(os.pathsep)
        if entry and not Path(entry).is_relative_to(ours)
    ]
    if kept:
        environment[_LIBRARIES] = os.pathsep.join(kept)
    return environment


def environment_of_a_graph(domain_id: int, log_folder: Path) -> dict[str, str | None]:
    """Return the variables that make a graph of its own on this machine; None takes one away."""
    return {
        "ROS_DOMAIN_ID": str(domain_id),
        # The older of the two is honoured first where it is known, and processes then find each
        # other in 0.1 s instead of 2 to 3 s; the newer one takes over where it is not.
        "ROS_LOCALHOST_ONLY": "1",
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(log_folder),
        "ROS_PYTHON_CHECK_FIELDS": "1",
        **dict.fromkeys(_ELSEWHERE, None),
    }


# ---- what Fast DDS leaves in ``/dev/shm`` ----

_FOLDER = Path("/dev/shm")  # noqa: S108 - where Fast DDS keeps its files
YOUNG_S = 2.0
_SEGMENT = re.compile(r"fastdds_[0-9a-f]{16}")
_PORT = re.compile(r"fastdds_port(\d+)")
# The ports of domain d, by the rules of RTPS.
_FIRST_PORT, _PORTS_OF_A_DOMAIN = 7400, 250


def sweep(domain_id: int) -> int:
    """Remove what nobody can miss, and return how many files that was.

    Not everything that looks abandoned is. A process that has ended may have been the reader of a
    port to which another still writes; without its file, that one's messages are lost in silence.
    So a file goes only when no process has it mapped, and besides

    - a segment (its name is random, so nobody will open it again) when the lock is free that its
      owner holds as long as it lives;
    - a port of ``domain_id``, which is ours alone.

    Files of the last seconds stay: their process may be about to lock them.
    """
    used = _mapped()
    free = [name for name in _old_names() if name not in used]
    return sum(
        _remove(name)
        for name in free
        if _is_port_of(domain_id, name) or (_SEGMENT.fullmatch(name) and _is_ownerless(name))
    )


def _old_names() -> list[str]:
    names = []
    for file in _FOLDER.glob("fastdds_*"):
        with suppress(FileNotFoundError):
            if time.time() - file.stat().st_ctime > YOUNG_S:
                names.append(file.name)
    return names


def _mapped() -> set[str]:
    found: set[str] = set()
    for maps in Path("/proc").glob("[0-9]*/maps"):
        with suppress(OSError):  # it has ended, or is not ours to look at
            found.update(re.findall(rf"{_FOLDER}/(fastdds_\w+)", maps.read_text()))
    return found


def _is_port_of(domain_id: int, name: str) -> bool:
    match = _PORT.fullmatch(name)
    return match is not None and domain_id == (int(match[1]) - _FIRST_PORT) // _PORTS_OF_A_DOMAIN


def _is_ownerless(segment: str) -> bool:
    try:
        with (_FOLDER / f"{segment}_el").open("r+") as companion:
            fcntl.flock(companion, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:  # held, or gone
        return False
    return True


def _remove(name: str) -> int:
    files = [_FOLDER / name, _FOLDER / f"{name}_el", _FOLDER / f"sem.{name}_mutex"]
    there = [file for file in files if file.exists()]
    for file in there:
        file.unlink(missing_ok=True)
    return len(there)


# ---- a graph for one test ----

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
        *,
        ends_with_input: bool = True,
    ) -> None:
        """Start it.

        Args:
            command: Program and arguments.
            environment: All of it.
            patience_s: How long each way of ending it is given.
            ends_with_input: It ends once its standard input does; else it is asked (SIGTERM).
        """
        self._patience_s = patience_s
        self._ends_with_input = ends_with_input
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

    def begin_to_stop(self) -> None:
        """Have it end, without waiting for that; `stop` must follow."""
        assert self.process.stdin is not None
        if self.process.stdin.closed:
            return
        with suppress(BrokenPipeError):
            self.process.stdin.close()
        if not self._ends_with_input:
            self.process.terminate()

    def stop(self) -> int:
        """End it: as it is used to, then by asking, then by force. Returns its exit code."""
        self.begin_to_stop()
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
            process.begin_to_stop()
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
        ends_with_input: bool = True,
    ) -> RosProcess:
        """Run a Python program on this graph, and wait until it says that it is ready.

        Args:
            command: A script and its arguments, or ``-m`` and a module; run by this Python.
            python_path: Folders that it needs besides, such as built interfaces.
            ready: How the line begins that it says when it is up; None does not wait.
            timeout_s: For that line.
            ends_with_input: As `RosProcess` has it.
        """
        environment = dict(self.environment)
        folders = [*map(str, python_path), *filter(None, [environment.get("PYTHONPATH")])]
        environment |= {"PYTHONPATH": os.pathsep.join(folders), "PYTHONUNBUFFERED": "1"}
        line = [sys.executable, *map(str, command)]
        process = RosProcess(line, environment, ends_with_input=ends_with_input)
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
