"""`python -m tests.journeys.gateway`: forks gateways that a test may kill as often as it likes.

It imports everything once, then reads one JSON object a line from standard input and answers each
with one line. ``{"start": ...}`` forks a process that runs `rosic run -c FILE`, the same code as
the command, with nothing but the importing already done; or, with a fault, the same composition
with one faulty part; or, with options, the fake server of Telegram. ``{"reap": PID}`` waits for the
end of one and says how it ended.

The robots of these gateways are reached by the link ``counting``, an adapter found by its entry
point as any other that is installed beside ROSIC.
"""

from __future__ import annotations

import asyncio
import gc
import os
import signal
import sys
import tempfile
from pathlib import Path

import msgspec

from tests.journeys.counting import PORT
from tests.journeys.faults import FAULTS, serve

ENTRY_POINT = """[rosic.robots]
counting = tests.journeys.counting:CountingRobot
"""
WARM = (
    "rosic.cli.gateway",
    "rosic.messengers.telegram",
    "rosic.robots.memory",
    "rosic_sim.robots.robot",
    "sqlalchemy.dialects.sqlite",
    "tests.journeys.counting",
)
# What these load when it is first used, and the server: processes that live for a second or two
# would load it anew every time.
WARMER = (
    "alembic.command",
    "alembic.context",
    "alembic.ddl.sqlite",
    "anyio._backends._asyncio",
    "httpcore",
    "rosic.testing.telegram.__main__",
    "uvloop",
)
COLD = "cold"
"""The argument of a launcher for one gateway, whose start is measured: it loads what that does."""


class Start(msgspec.Struct, frozen=True, kw_only=True):
    """One gateway to start, or the fake server.

    Attributes:
        config: Its TOML file.
        log: Where its standard error goes; appended to.
        counter_port: Where `CountingRobot` finds its counter.
        fault: Name of a faulty part; empty for none.
        environment: What is different for it: the ROS domain of its robots.
        server: Options of the fake server, which it is then; what that prints goes to the log, too.
    """

    config: str = ""
    log: str
    counter_port: int = 0
    fault: str = ""
    environment: dict[str, str] = {}
    server: tuple[str, ...] | None = None


class Command(msgspec.Struct, frozen=True):
    """One line to the launcher."""

    start: Start | None = None
    reap: int = 0


def main() -> None:
    """Serve until standard input ends; then end every gateway that is left."""
    with tempfile.TemporaryDirectory() as folder:
        _install(Path(folder))
        _warm_up()
        _say("ready")
        alive: set[int] = set()
        for line in sys.stdin:
            command = msgspec.json.decode(line, type=Command)
            if command.start is not None:
                pid = os.fork()
                if not pid:
                    _become(command.start)
                alive.add(pid)
                _say(str(pid))
            else:
                _, status = os.waitpid(command.reap, 0)
                alive.discard(command.reap)
                _say(str(os.waitstatus_to_exitcode(status)))
        for pid in alive:
            os.kill(pid, signal.SIGKILL)
            os.waitpid(pid, 0)


def _install(folder: Path) -> None:
    """Make the adapter known, as installing a package would."""
    package = folder / "rosic_counting-1.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: rosic-counting\nVersion: 1\n")
    (package / "entry_points.txt").write_text(ENTRY_POINT)
    sys.path.append(str(folder))


def _warm_up() -> None:
    for module in WARM:
        __import__(module)
    from rosic.config.profiles import known_units  # noqa: PLC0415 - after the path was set

    known_units()
    if COLD not in sys.argv:
        from rosic.config.lexicons import known_phrases  # noqa: PLC0415 - after the path was set

        known_phrases()
        for module in WARMER:
            __import__(module)
    gc.freeze()  # what all of them share is no litter of any of them


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def _become(start: Start) -> None:
    """Be the gateway, and nothing else any more."""
    status = 70
    try:
        _settle_in(start)
        if start.server is not None:
            from rosic.testing.telegram import __main__ as server  # noqa: PLC0415 - loaded before

            os.dup2(2, 1)
            sys.argv[1:] = start.server
            asyncio.run(server.serve(server.arguments()))
            status = 0
        elif start.fault:
            asyncio.run(serve(start.config, FAULTS[start.fault]))
            status = 0
        else:
            from rosic.cli import main as rosic  # noqa: PLC0415 - only here

            status = rosic(["run", "-c", start.config])
    finally:
        sys.stderr.flush()
        os._exit(status)


def _settle_in(start: Start) -> None:
    """Take leave of the launcher: own log, no input, own process group for nobody's Ctrl-C."""
    log = os.open(start.log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.dup2(nothing, 1)
    os.dup2(log, 2)
    os.close(log)
    os.close(nothing)
    os.environ[PORT] = str(start.counter_port)
    os.environ.update(start.environment)


if __name__ == "__main__":
    main()
