"""The real command, as a person runs it: in a process of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from tests.cli.warm import Warmed
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

ROSIC = (sys.executable, "-m", "rosic")
SOURCE = Path(__file__).parents[2] / "src"


class Ran(NamedTuple):
    """What a command said and returned."""

    status: int
    out: str
    err: str


# What a person is sent lies there for them to open, and is not taken away when they leave.
SENT = tempfile.TemporaryDirectory(prefix="tests-of-rosic-")


def environment(extra: Mapping[str, str] | None = None) -> dict[str, str]:
    own = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    paths = [str(SOURCE), *filter(None, [own.get("PYTHONPATH")])]
    ours = {"PYTHONPATH": os.pathsep.join(paths), "TZ": "UTC", "TMPDIR": SENT.name}
    return own | ours | dict(extra or {})


def rosic(
    *arguments: str | Path,
    stdin: str = "",
    cwd: Path | None = None,
    within_s: float = 150,
    env: Mapping[str, str] | None = None,
) -> Ran:
    """Run a command to its end, in a process that has loaded what it needs."""
    with (
        tempfile.TemporaryFile("w+") as asks,
        tempfile.TemporaryFile("w+") as out,
        tempfile.TemporaryFile("w+") as err,
    ):
        asks.write(stdin)
        asks.seek(0)
        files = (asks.fileno(), out.fileno(), err.fileno())
        process = Warmed([*map(str, arguments)], files, cwd, environment(env))
        try:
            status = process.wait(within_s * pace())
        finally:
            process.kill()
        out.seek(0)
        err.seek(0)
        return Ran(status, out.read(), err.read())


def cold_rosic(
    *arguments: str | Path,
    stdin: str = "",
    cwd: Path | None = None,
    within_s: float = 150,
    env: Mapping[str, str] | None = None,
) -> Ran:
    """Run a command to its end, as a person runs it."""
    done = subprocess.run(  # noqa: S603 - our own command
        [*ROSIC, *map(str, arguments)],
        input=stdin,
        capture_output=True,
        text=True,
        timeout=within_s * pace(),
        check=False,
        cwd=cwd,
        env=environment(env),
    )
    return Ran(done.returncode, done.stdout, done.stderr)


class Gateway:
    """A running ``rosic run``.

    Attributes:
        process: Its standard input stays open until it is closed.
    """

    def __init__(self, process: Warmed, log: Path, out: Path) -> None:
        self.process = process
        self._log = log
        self._out = out

    def err(self) -> str:
        return self._log.read_text()

    def out(self) -> str:
        return self._out.read_text()

    def say(self, line: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()

    def wait_for(self, text: str, *, within_s: float = 60, log: bool = False) -> None:
        end_s = time.monotonic() + within_s * pace()
        while text not in (self.err() if log else self.out()):
            assert self.process.poll() is None, f"it ended: {self.err()}"
            assert time.monotonic() < end_s, f"no {text!r} in: {self.err()}{self.out()}"
            time.sleep(0.02)

    def end(self, number: signal.Signals = signal.SIGTERM, *, within_s: float = 60) -> int:
        self.process.send_signal(number)
        return self.process.wait(within_s * pace())


@contextmanager
def gateway(
    config: Path,
    env: Mapping[str, str] | None = None,
    *,
    ready: bool = True,
    begin_anew: bool = False,
) -> Iterator[Gateway]:
    """Let a gateway run while inside."""
    log, out = config.with_suffix(".err"), config.with_suffix(".out")
    with log.open("w") as err, out.open("w") as told:
        hears, says = os.pipe()
        files = (hears, told.fileno(), err.fileno())
        anew = ["--begin-anew"] if begin_anew else []
        process = Warmed(["run", "-c", str(config), *anew], files, None, environment(env))
        process.stdin = os.fdopen(says, "w")
        os.close(hears)
        running = Gateway(process, log, out)
        try:
            if ready:
                running.wait_for("ready in", log=True, within_s=120)
            yield running
        finally:
            process.kill()
            process.wait()
            with suppress(BrokenPipeError):
                process.stdin.close()


CONFIG = """
[[messenger]]
kind = "terminal"

[[robot]]
profile = "omni"
link = "simulated"

[[robot]]
profile = "kuka1"
link = "simulated"

[[principal]]
name = "Ada"
address = "terminal:{uid}"
role = "admin"

[[principal]]
name = "Bob"
address = "terminal:99999"
role = "operator"
"""

TELEGRAM = """
[[messenger]]
kind = "telegram"
token = {{ env = "LAB_TOKEN" }}
api_base = "{api_base}"
[[robot]]
profile = "omni"
link = "memory"
"""


def write_config(folder: Path, text: str = CONFIG, **changes: str) -> Path:
    """Write a configuration and return where it is."""
    path = folder / "rosic.toml"
    path.write_text(text.format(uid=os.getuid(), **changes))
    return path


def write_neighbours(folder: Path) -> Path:
    """Write a configuration with two robots more, in one namespace; return where it is."""
    for name in ("ant", "bee"):
        (folder / f"{name}.yaml").write_text(
            f"id: {name}\nlink: {{ kind: memory, namespace: /hill }}\n"
            "skills: { home: { class: task } }\n"
        )
    more = "".join(f'\n[[robot]]\nprofile = "{folder}/{name}.yaml"\n' for name in ("ant", "bee"))
    return write_config(folder, CONFIG + more)
