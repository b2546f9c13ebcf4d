"""A whole gateway over XMPP: a newcomer, orders, numbers, a stop, a picture, and restarts."""

from __future__ import annotations

import asyncio
import re
import time
from typing import TYPE_CHECKING

import pytest

from tests.cli.running import cold_rosic
from tests.journeys.gateway import Start
from tests.journeys.running import Gateway, Launcher
from tests.real.xmpp.person import Person
from tests.real.xmpp.prosody import LOOPBACK, Prosody

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from tests.real.xmpp.person import Seen
    from tests.real.xmpp.prosody import Account

CONFIG = """
[gateway]
data = "data"

[[messenger]]
kind = "xmpp"
name = "lab"
user = "{user}"
password = "{password}"
host = "{host}"
port = {port}

[limits]
burst = 1000
per_s = 1000

[[robot]]
profile = "omni"
link = "simulated"
"""


@pytest.fixture(scope="module")
def launcher() -> Iterator[Launcher]:
    launcher = Launcher()
    yield launcher
    launcher.close()


class Lab:
    """A gateway that may come and go, and Ada, who writes to it."""

    def __init__(self, folder: Path, launcher: Launcher, robots: Account, server: Prosody) -> None:
        self.robots, self.server = robots, server
        self.config = folder / "rosic.toml"
        self.gateways: list[Gateway] = []
        self._folder, self._launcher = folder, launcher
        where = {"host": LOOPBACK, "port": server.port}
        self.config.write_text(
            CONFIG.format(user=robots.user, password=robots.password, **where), encoding="utf-8"
        )
        self.config.chmod(0o600)

    async def start(self) -> Gateway:
        start = Start(config=str(self.config), log=str(self._folder / "gateway.log"))
        gateway = Gateway(self._launcher, start)
        self.gateways.append(gateway)
        await gateway.listens()
        return gateway

    async def invite(self) -> str:
        """Return the words by which somebody joins."""
        made = await asyncio.to_thread(
            cold_rosic, "invite", "--role", "operator", "--plain", "-c", self.config
        )
        found = re.search(r"join \S+", made.out)
        assert found is not None, made
        return found[0].rstrip(".")

    async def ask(self, ada: Person, text: str, expected: str) -> Seen:
        """Let Ada write; wait for something new, or newly changed, that says what is expected."""
        before = {one.message: one.text for one in ada.seen.values()}
        ada.say(self.robots.user, text)
        return await self.reads(ada, expected, before)

    async def tap(self, ada: Person, message: str, label: str, expected: str) -> Seen:
        """Let Ada type the number of a button."""
        found = re.search(rf"(\d+)\. [^\n\d]*{re.escape(label)}", ada.seen[message].text)
        assert found is not None, ada.seen[message]
        return await self.ask(ada, found[1], expected)

    async def reads(self, ada: Person, expected: str, before: dict[str, str]) -> Seen:
        def found() -> list[Seen]:
            return [
                one
                for one in ada.seen.values()
                if expected in one.text and before.get(one.message) != one.text
            ]

        try:
            await ada.until(found)
        except AssertionError:
            texts = [one.text for one in ada.seen.values()]
            raise AssertionError(f"no {expected!r} in {texts}; {self.gateways[-1].log()}") from None
        return found()[-1]


async def test_somebody_joins_orders_chooses_stops_and_everything_is_restarted(
    tmp_path: Path, launcher: Launcher
) -> None:
    folder = tmp_path / "server"
    folder.mkdir()
    with Prosody(folder) as server:
        robots, account = server.create_account("robots"), server.create_account("ada")
        lab = Lab(tmp_path, launcher, robots, server)
        try:
            first = await lab.start()
            async with Person(server, account) as ada:
                await _first_hour(lab, ada)
            async with Person(server, account) as ada:
                first.kill()
                ada.say(robots.user, "status omni")
                ada.say(robots.user, "omni move forward 1 m")
                await ada.arrived()
                await asyncio.to_thread(time.sleep, 1.1)  # its stamps are of whole seconds
                await lab.start()
                await lab.reads(ada, "omni: stopped by you", {})
                await lab.reads(ada, "You sent this while I could not listen.", {})
            server.kill()
            server.start()
            async with Person(server, account) as ada:
                await lab.ask(ada, "status omni", "omni: stopped by you")
                await lab.ask(ada, "resume omni", "omni")
                await lab.ask(ada, "omni move back 0.2 m", "done ")
        finally:
            for gateway in lab.gateways:
                gateway.kill()


async def _first_hour(lab: Lab, ada: Person) -> None:
    welcome = await lab.invite()
    hello = await lab.ask(ada, welcome, "Join")
    await lab.tap(ada, hello.message, "Join", "You are in")
    await lab.ask(ada, "omni move forward 0.5 m", "done ")
    menu = await lab.ask(ada, "/start", "What should omni do?")
    question = await lab.tap(ada, menu.message, "Move in a straight line", "0.50 m forward?")
    await lab.tap(ada, question.message, "Do it", "done ")
    ada.say(lab.robots.user, "picture omni")
    await ada.until(lambda: any(one.url for one in ada.seen.values()))
    [(name, content)] = await ada.files(lab.robots.user)
    assert name == "omni.jpg"
    assert content.startswith(b"\xff\xd8")
    await lab.ask(ada, "stop", "STOP: omni at rest")
