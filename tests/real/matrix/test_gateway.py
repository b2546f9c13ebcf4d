"""A whole gateway in an encrypted room: orders, buttons, a stop, pictures, files, and restarts."""

from __future__ import annotations

import re
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest

from rosic.messengers.matrix.signs import KEYS
from tests.journeys.gateway import Start
from tests.journeys.running import Gateway, Launcher
from tests.real.matrix.database import found_in
from tests.real.matrix.person import Person
from tests.real.matrix.synapse import synapse_in

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator
    from pathlib import Path

    from tests.real.matrix.person import Seen
    from tests.real.matrix.synapse import Account, Synapse

HALL = b"P5\n300 300\n255\n" + b"a wall of this hall is here; " * 3_104
PICTURE = (b"\x89PNG", b"\xff\xd8\xff")
SHORT = 8
"""What is shorter may stand anywhere by chance."""
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
require_verified = false

[limits]
burst = 1000
per_s = 1000

[[robot]]
profile = "omni"
link = "{link}"

[[principal]]
name = "Ada"
address = "matrix:{ada}"
role = "admin"
"""


@pytest.fixture(scope="module")
def launcher() -> Iterator[Launcher]:
    launcher = Launcher()
    yield launcher
    launcher.close()


class Place:
    """A gateway that may come and go, and Ada, in an encrypted room with it."""

    def __init__(
        self, folder: Path, launcher: Launcher, robots: Account, ada: Person, link: str
    ) -> None:
        self.ada = ada
        self.robots = robots
        self.room = ""
        self._folder = folder
        self._launcher = launcher
        self.gateways: list[Gateway] = []
        (folder / "rosic.toml").write_text(
            CONFIG.format(
                url=robots.url,
                user=robots.user,
                password=robots.password,
                folder=folder / "matrix",
                ada=ada.user,
                link=link,
            )
        )

    async def start(self) -> Gateway:
        start = Start(
            config=str(self._folder / "rosic.toml"), log=str(self._folder / "gateway.log")
        )
        gateway = Gateway(self._launcher, start)
        self.gateways.append(gateway)
        await gateway.listens()
        return gateway

    async def meet(self) -> None:
        self.room = await self.ada.create_room(self.robots.user, direct=True)
        await self.ada.until(
            lambda: (
                self.robots.user in self.ada.client.rooms[self.room].users
                and not self.ada.client.rooms[self.room].invited_users
            )
        )

    def said(self) -> list[Seen]:
        messages = self.ada.timeline(self.room).messages.values()
        return [seen for seen in messages if seen.sender == self.robots.user]

    async def ask(self, text: str, expected: str) -> Seen:
        """Let Ada write; wait for something new, or newly changed, that says what is expected."""
        before = {seen.id: seen.text for seen in self.said()}
        await self.ada.say(self.room, text)
        return await self.reads(expected, before)

    async def tap(self, message: str, label: str, expected: str) -> Seen:
        """Let Ada tap the button with this label, by putting its sign beneath the message."""

        def key() -> str:
            text = self.ada.timeline(self.room).messages[message].text
            found = [
                key
                for n, key in enumerate(KEYS, 1)
                if re.search(rf"(?<!\d){n}\. {re.escape(label)}", text)
            ]
            signs = self.ada.timeline(self.room).messages[message].reactions
            return next((one for one in found if signs.get(one) == {self.robots.user}), "")

        try:
            await self.ada.until(lambda: bool(key()), 10)
        except AssertionError:
            seen = self.ada.timeline(self.room).messages[message]
            raise AssertionError(f"no {label!r} in {seen}; {self.gateways[-1].log()}") from None
        before = {seen.id: seen.text for seen in self.said()}
        await self.ada.react(self.room, message, key())
        return await self.reads(expected, before)

    async def reads(self, expected: str, before: dict[str, str]) -> Seen:
        def found() -> list[Seen]:
            return [
                seen
                for seen in self.said()
                if expected in seen.text and before.get(seen.id) != seen.text
            ]

        try:
            await self.ada.until(lambda: bool(found()))
        except AssertionError:
            texts = [seen.text for seen in self.said()]
            raise AssertionError(f"no {expected!r} in {texts}; {self.gateways[-1].log()}") from None
        return found()[-1]


@asynccontextmanager
async def place(
    synapse: Synapse, folder: Path, launcher: Launcher, *, link: str = "memory"
) -> AsyncIterator[Place]:
    robots = synapse.create_account("robots")
    async with Person(synapse.create_account("ada"), folder / "ada") as ada:
        found = Place(folder, launcher, robots, ada, link)
        try:
            yield found
        finally:
            for gateway in found.gateways:
                gateway.kill()


async def test_a_person_orders_taps_stops_and_the_gateway_is_restarted(
    synapse: Synapse, tmp_path: Path, launcher: Launcher
) -> None:
    async with place(synapse, tmp_path, launcher) as lab:
        first = await lab.start()
        await lab.meet()

        done = await lab.ask("omni move forward 0.5 m", "done ")
        assert done.encrypted
        menu = await lab.ask("/start", "What should omni do?")
        question = await lab.tap(menu.id, "🚗 Move in a straight line", "0.50 m forward?")
        await lab.tap(question.id, "Do it", "done ")
        await lab.ask("stop", "STOP: omni at rest")

        device = await devices(lab)
        first.kill()
        told = {seen.id: seen.text for seen in lab.said()}
        await lab.ada.say(lab.room, "status omni")
        await lab.ada.say(lab.room, "omni move forward 1 m")
        await lab.start()
        await lab.reads("omni: stopped by you", told)
        await lab.reads("You sent this while I could not listen.", told)

        await lab.ask("resume omni", "omni")
        await lab.ask("omni move back 0.2 m", "0.20 m back\nsent")
        assert await devices(lab) == device, "it came back as another device"
        assert not lab.ada.timeline(lab.room).unreadable
        texts = [seen.text for seen in lab.said() if seen.id not in told]
        assert len(texts) == len(set(texts)), f"something was said twice: {texts}"
        assert all(seen.encrypted for seen in lab.said())


async def test_a_picture_and_files_go_over_restarts_and_the_homeserver_keeps_no_word(
    tmp_path: Path, launcher: Launcher
) -> None:
    (tmp_path / "synapse").mkdir()
    with synapse_in(tmp_path / "synapse") as own:
        async with place(own, tmp_path, launcher, link="simulated") as lab:
            gateway = await lab.start()
            await lab.meet()
            await lab.ask("omni move forward 0.3 m", "done ")
            await lab.ask("/picture omni", "omni, camera, ")
            await lab.ada.send_file(lab.room, "hall.pgm", HALL)
            await lab.reads("hall.pgm (pgm, 90 KB) is kept", {})
            own.restart()
            await lab.ask("status omni", "omni: at rest")
            gateway.kill()
            await lab.start()
            await lab.ask("/files get hall.pgm", "hall.pgm, 90 KB")

            files = dict(await lab.ada.files(lab.room, lab.robots.user))
            assert files.pop("hall.pgm") == HALL
            (picture,) = files.values()
            assert picture.startswith(PICTURE)
            assert all(seen.encrypted for seen in lab.ada.timeline(lab.room).messages.values())
            said = [seen.text for seen in lab.ada.timeline(lab.room).messages.values()]
            lines = {line for text in said for line in text.splitlines() if len(line) > SHORT}
            assert len(lines) > 10, lines
            kept = [HALL[64:96].decode("latin-1"), *sorted(lines)]
            assert {line: where for line in kept if (where := found_in(own, line))} == {}


async def devices(lab: Place) -> list[str]:
    lab.ada.client.olm.users_for_key_query.add(lab.robots.user)
    await lab.ada.look()
    return [one.id for one in lab.ada.client.device_store.active_user_devices(lab.robots.user)]
