"""docs/howto/add-a-messenger.md, followed word by word: a package with an entry point suffices."""

from __future__ import annotations

import asyncio
import json
import os
import re
import signal
import socket
import subprocess
import sys
from contextlib import asynccontextmanager, suppress
from importlib import import_module, invalidate_caches
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from rosic.core.message import Chat, MessageValidity
from rosic.errors import ConfigurationError
from rosic.system import SystemClock
from rosic.testing.messenger_harness import SeenMessage
from rosic.testing.messengers import MessengerConformance
from tests.cli.running import ROSIC, cold_rosic, environment
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.contracts.messenger import Messenger

PAGE = Path(__file__).parents[2] / "docs" / "howto" / "add-a-messenger.md"
FILE = re.compile(r"^`([\w./-]+)`[^\n]*:\n\n```\w+\n(.*?)^```", re.MULTILINE | re.DOTALL)
TABLE = re.compile(r"```toml\n(\[\[messenger.*?)```", re.DOTALL)
INSTALL = ("install", "--quiet", "--no-index", "--no-deps", "--no-build-isolation", "--target")


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port: int = one.getsockname()[1]
        return port


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the package of the page, and install it into a folder beside ROSIC's environment."""
    source, target = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("installed")
    for name, content in FILE.findall(PAGE.read_text(encoding="utf-8")):
        path = source / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    pip = (sys.executable, "-m", "pip", *INSTALL, str(target), str(source))
    done = subprocess.run(  # noqa: S603 - pip, with a package that the page writes
        pip, capture_output=True, text=True, timeout=120 * pace(), check=False
    )
    assert done.returncode == 0, done.stderr
    assert (target / "lines_messenger-1.0.dist-info" / "entry_points.txt").exists()
    return target


@pytest.fixture
def installed(package: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.syspath_prepend(str(package))
    monkeypatch.delitem(sys.modules, "lines_messenger", raising=False)
    invalidate_caches()
    return package


class Person:
    """Somebody who connects as soon as there is somebody to connect to, and reads."""

    def __init__(self, name: str, port: int) -> None:
        self.read: list[SeenMessage] = []
        self.away = asyncio.Event()
        self._changed = asyncio.Condition()
        self._writer: asyncio.StreamWriter | None = None
        self._name, self._port = name, port
        self._task = asyncio.create_task(self._live())

    async def _live(self) -> None:
        while True:
            if not self.away.is_set():
                with suppress(OSError):
                    await self._once()
            await asyncio.sleep(0.01)

    async def _once(self) -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", self._port, limit=2**20)
        try:
            writer.write(f"{self._name}\n".encode())
            await self._tell(writer)
            while line := await reader.readline():
                message, _, text = line.decode().partition(" ")
                self.read.append(SeenMessage(message, json.loads(text)))
                await self._tell(writer)
        finally:
            writer.close()
            await self._tell(None)

    async def _tell(self, writer: asyncio.StreamWriter | None) -> None:
        async with self._changed:
            self._writer = writer
            self._changed.notify_all()

    async def say(self, text: str) -> None:
        async with asyncio.timeout(10 * pace()), self._changed:
            await self._changed.wait_for(lambda: self._writer is not None)
        assert self._writer is not None
        self._writer.write(f"{text}\n".encode())

    async def hears(self, text: str) -> str:
        def found() -> str:
            return next((seen.text for seen in self.read if text in seen.text), "")

        try:
            async with asyncio.timeout(10 * pace()), self._changed:
                await self._changed.wait_for(found)
        except TimeoutError:
            raise AssertionError(f"{text!r} was not said: {self.read}") from None
        return found()

    async def left(self) -> None:
        """Wait until the connection has ended: then everything is read."""
        async with asyncio.timeout(10 * pace()), self._changed:
            await self._changed.wait_for(lambda: self._writer is None)

    async def hang_up(self) -> None:
        self.away.set()
        if self._writer is not None:
            self._writer.close()
        await self.left()

    async def end(self) -> None:
        self._task.cancel()
        await asyncio.gather(self._task, return_exceptions=True)


class LinesStage:
    people: tuple[str, ...] = ("ada", "bob")
    patience_s = 30.0
    keeps = False
    taps = True
    unusual: tuple[MessageValidity, ...] = ()

    def __init__(self) -> None:
        port = free_port()
        made = import_module("lines_messenger").lines_messenger
        self.messenger: Messenger = made("lines", {"port": port}, SystemClock())
        self.connected = {name: Person(name, port) for name in self.people}

    def chat(self, person: str) -> Chat:
        return Chat("lines", person)

    async def write(self, person: str, text: str) -> None:
        await self.connected[person].say(text)

    async def tap(self, person: str, message: str, label: str) -> None:
        await self.connected[person].hears(label)
        text = next(seen.text for seen in self.connected[person].read if seen.message == message)
        number = re.search(rf"(\d+)\. {re.escape(label)}", text)
        assert number is not None
        await self.connected[person].say(number[1])

    async def screen(self, person: str) -> list[SeenMessage]:
        await self.connected[person].left()
        return self.connected[person].read

    async def files(self, _: str) -> list[tuple[str, bytes]]:
        return []

    async def enclose(self, *_: object) -> None:
        raise AssertionError("lines have no files")

    async def pinned(self, _: str) -> list[str]:
        return []

    async def unconfirmed(self) -> int:
        return 0

    @asynccontextmanager
    async def outage(self) -> AsyncIterator[None]:
        for person in self.connected.values():
            await person.hang_up()
        yield
        for person in self.connected.values():
            person.away.clear()


class TestLines(MessengerConformance):
    @pytest.fixture
    async def stage(self, installed: Path) -> AsyncIterator[LinesStage]:
        assert (installed / "lines_messenger").is_dir()
        stage = LinesStage()
        yield stage
        for person in stage.connected.values():
            await person.end()


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize(
    ("settings", "wrong"),
    [({}, "port"), ({"port": "x"}, "port"), ({"port": 1, "colour": "red"}, "colour")],
)
def test_the_adapter_says_what_is_wrong_with_its_table(
    settings: dict[str, Any], wrong: str
) -> None:
    made = import_module("lines_messenger").lines_messenger
    with pytest.raises(ConfigurationError, match=wrong):
        made("lines", settings, SystemClock())


async def test_somebody_joins_moves_a_robot_and_stops_it(tmp_path: Path, package: Path) -> None:
    port = free_port()
    [table] = TABLE.findall(PAGE.read_text(encoding="utf-8"))
    config = tmp_path / "rosic.toml"
    config.write_text(
        table.replace("7007", str(port)) + '\n[[robot]]\nprofile = "omni"\nlink = "simulated"\n'
    )
    config.chmod(0o600)
    env = {"PYTHONPATH": f"{environment()['PYTHONPATH']}{os.pathsep}{package}"}
    checked = await asyncio.to_thread(cold_rosic, "check", "-c", config, env=env)
    assert checked.status == 0, checked.err
    running = await asyncio.create_subprocess_exec(
        *ROSIC, "run", "-c", str(config), env=environment(env), stderr=asyncio.subprocess.PIPE
    )
    eve = Person("eve", port)
    try:
        assert running.stderr is not None
        while b"ready in" not in (line := await running.stderr.readline()):
            assert line, "it ended"
        made = await asyncio.to_thread(
            cold_rosic, "invite", "--role", "operator", "--plain", "-c", config, env=env
        )
        found = re.search(r"join \S+", made.out)
        assert found is not None, made
        await _use(eve, found[0].rstrip("."))
    finally:
        await eve.end()
        with suppress(ProcessLookupError):
            running.send_signal(signal.SIGTERM)
        await running.wait()


async def _use(eve: Person, code: str) -> None:
    await eve.say(code)
    await eve.hears("You are invited as operator")
    await eve.hears("1. Join")
    await eve.say("1")
    await eve.hears("You are in, as operator")
    await eve.say("omni move 10 cm at 0.2 m/s")
    await eve.hears("done")
    await eve.say("omni move 5 m at 0.1 m/s")
    await eve.hears("5.00 m, 0.1 m/s forward: accepted")
    await eve.say("stop")
    await eve.hears("STOP: omni at rest")
