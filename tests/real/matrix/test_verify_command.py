"""From nobody verified to orders that count: at the machine first, then in chats.

A gateway that follows verified devices alone, and two people at matrix-js-sdk in its strict mode.
"""

from __future__ import annotations

import asyncio
import sys
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest

from rosic.features.verification import messages as words
from rosic.gateway.unverified_messages import MAY_LOOK
from tests.cli.running import environment
from tests.journeys.gateway import Start
from tests.journeys.running import Gateway, Launcher
from tests.pace import pace
from tests.real.matrix.js_client import JsClient

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator
    from pathlib import Path

    from tests.real.matrix.js_client import JsSeen
    from tests.real.matrix.synapse import Account, Synapse

CONFIG = """
[gateway]
data = "data"

[[messenger]]
kind = "matrix"
name = "lab"
homeserver = "{url}"
user = "{user}"
password = "{password}"
folder = "{folder}"

[limits]
burst = 1000
per_s = 1000

[[robot]]
profile = "omni"
link = "memory"

[[principal]]
name = "Ada"
address = "matrix:{ada}"
role = "admin"

[[principal]]
name = "Bo"
address = "matrix:{bo}"
role = "operator"
"""


@pytest.fixture(scope="module")
def launcher() -> Iterator[Launcher]:
    launcher = Launcher()
    yield launcher
    launcher.close()


class Talk:
    """Somebody at a client, in an encrypted room with the robots."""

    def __init__(self, client: JsClient, robots: Account, room: str) -> None:
        self.client = client
        self.room = room
        self._robots = robots

    async def reads(self, expected: str, after: int = 0) -> JsSeen:
        """Wait until the robots have said something with this in it."""

        def found(seen: list[JsSeen]) -> list[JsSeen]:
            ours = [one for one in seen if one.sender == self._robots.user]
            return [one for one in ours[after:] if expected in one.text]

        shown = await self.client.until(self.room, lambda seen: bool(found(seen)))
        return found(shown)[-1]

    async def asks(self, text: str, expected: str) -> JsSeen:
        """Write, and wait for something new that says what is expected."""
        before = len(await self.client.sees(self.room, self._robots.user))
        await self.client.say(self.room, text)
        return await self.reads(expected, before)

    async def compares(self) -> str:
        """Accept what ROSIC asks, and return the emoji that are shown here."""
        asked = await self.client.verification(self._robots.user, "requested")
        await self.client.accept_verification(asked["transaction"])
        return "".join((await self.client.verification(self._robots.user, "emoji"))["emoji"])

    async def confirms(self) -> None:
        shown = await self.client.verification(self._robots.user, "emoji")
        await self.client.confirm(shown["transaction"])


@asynccontextmanager
async def talking(synapse: Synapse, robots: Account, name: str, log: Path) -> AsyncIterator[Talk]:
    async with JsClient(synapse.create_account(name), log) as client:
        yield Talk(client, robots, "")


async def met(talk: Talk, robots: Account) -> None:
    talk.room = await talk.client.create_room(robots.user, direct=True)


def signs_of(text: str) -> str:
    """Return the emoji of a line that shows each with its name."""
    return "".join(word for word in text.split() if not word[0].isascii())


class VerifyCommand:
    """``rosic verify``, as somebody runs it at the machine."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process
        self.out = ""

    async def shows(self, expected: str) -> str:
        assert self._process.stdout is not None
        async with asyncio.timeout(60 * pace()):
            while expected not in self.out:
                read = await self._process.stdout.read(1_000)
                assert read, self.out
                self.out += read.decode()
        return self.out

    async def answers(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(f"{line}\n".encode())
        await self._process.stdin.drain()

    async def ended(self) -> int:
        async with asyncio.timeout(60 * pace()):
            return await self._process.wait()


@asynccontextmanager
async def verifying(folder: Path, name: str) -> AsyncIterator[VerifyCommand]:
    process = await asyncio.create_subprocess_exec(
        *(
            sys.executable,
            "-m",
            "rosic",
            "verify",
            *filter(None, [name]),
            "-c",
            str(folder / "rosic.toml"),
        ),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
        env=environment(),
    )
    try:
        yield VerifyCommand(process)
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


@asynccontextmanager
async def place(
    synapse: Synapse, folder: Path, launcher: Launcher
) -> AsyncIterator[tuple[Talk, Talk, Gateway]]:
    robots = synapse.create_account("robots")
    async with (
        talking(synapse, robots, "ada", folder / "ada.log") as ada,
        talking(synapse, robots, "bo", folder / "bo.log") as bo,
    ):
        (folder / "rosic.toml").write_text(
            CONFIG.format(
                url=robots.url,
                user=robots.user,
                password=robots.password,
                folder=folder / "matrix",
                ada=ada.client.user,
                bo=bo.client.user,
            )
        )
        gateway = Gateway(
            launcher, Start(config=str(folder / "rosic.toml"), log=str(folder / "gateway.log"))
        )
        try:
            await gateway.listens()
            await met(ada, robots)
            await met(bo, robots)
            yield ada, bo, gateway
        finally:
            gateway.kill()


async def test_the_first_at_the_machine_and_she_then_compares_for_others(
    synapse: Synapse, tmp_path: Path, launcher: Launcher
) -> None:
    async with place(synapse, tmp_path, launcher) as (ada, bo, _):
        await ada.asks("status", "omni")
        await ada.asks("/me", "encrypted, unverified")
        refused = await ada.asks("omni move forward 0.5 m", MAY_LOOK)
        assert "/verify" in refused.text
        assert words.NOBODY_COMPARES in (await ada.asks("/verify", "accept it there")).text

        async with verifying(tmp_path, "Ada") as command:
            await command.shows("Waiting for Ada")
            theirs = await ada.compares()
            shown = await command.shows("[y/N]")
            assert signs_of(shown.split("\n\n    ")[1].split("\n")[0]) == theirs
            await command.answers("y")
            await ada.confirms()
            await command.shows("Ada is verified")
            assert await command.ended() == 0

        await ada.reads(words.YOU_ARE)
        await ada.asks("/me", "This chat: encrypted, verified.")
        await ada.asks("omni move forward 0.5 m", "done ")

        assert "Shown the same: Ada." in (await bo.asks("/verify", "accept it there")).text
        theirs = await bo.compares()
        shown = (await ada.reads("Bo is to be verified")).text
        assert signs_of(shown.split("\n")[1].partition("If all")[0]) == theirs
        await ada.asks("they match", words.SAID_SAME)
        await bo.confirms()
        await bo.reads(words.YOU_ARE)
        await ada.reads("Bo is verified")
        await bo.asks("omni move back 0.5 m", "omni is taken by Ada")


async def test_one_that_somebodys_client_begins_and_an_admin_says_differs(
    synapse: Synapse, tmp_path: Path, launcher: Launcher
) -> None:
    async with place(synapse, tmp_path, launcher) as (_, bo, _):
        await bo.asks("status", "omni")
        robots = bo._robots
        name = await bo.client.request_verification(robots.user, room=bo.room)
        async with verifying(tmp_path, "") as command:
            await bo.client.verification(robots.user, "ready")
            await bo.client.compare_emoji(name)
            await bo.reads(words.NOBODY_COMPARES)
            await command.shows("[y/N]")
            await command.answers("n")
            assert await command.ended() == 1
        await bo.reads(words.YOU_ARE_NOT)
        await bo.asks("omni move forward 0.5 m", MAY_LOOK)
        await bo.asks("stop", "STOP: omni at rest")
