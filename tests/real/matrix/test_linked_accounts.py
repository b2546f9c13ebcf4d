"""One person on Telegram and on Matrix: one code, then one lease, one plan, one dashboard each."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest

from tests.journeys.lab import Lab, lab
from tests.journeys.running import Launcher
from tests.real.matrix.person import Person

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from tests.real.matrix.person import Seen
    from tests.real.matrix.synapse import Account, Synapse

CODE = re.compile(r"\b[0-9A-Z]{4}-[0-9A-Z]{4}\b")
ROBOTS = ('[[robot]]\nprofile = "omni"\nlink = "simulated"',)
MATRIX = """

[[messenger]]
kind = "matrix"
name = "rooms"
homeserver = "{url}"
user = "{user}"
password = "{password}"
folder = "{folder}"
require_verified = false
"""


@pytest.fixture(scope="module")
def launcher() -> Iterator[Launcher]:
    launcher = Launcher()
    yield launcher
    launcher.close()


class TwoChats:
    """Bo with a phone on Telegram, and in an encrypted room on Matrix."""

    def __init__(self, place: Lab, bo: Person, robots: Account) -> None:
        self.place, self.bo, self.robots, self.room = place, bo, robots, ""

    async def meet(self) -> None:
        """Open a private room with the robots."""
        self.room = await self.bo.create_room(self.robots.user, direct=True)
        await self.bo.until(
            lambda: (
                self.robots.user in self.bo.client.rooms[self.room].users
                and not self.bo.client.rooms[self.room].invited_users
            )
        )

    def said(self) -> list[Seen]:
        """Return what Bo reads in the room."""
        messages = self.bo.timeline(self.room).messages.values()
        return [seen for seen in messages if seen.sender == self.robots.user]

    async def ask(self, text: str, expected: str) -> Seen:
        """Write in the room, and wait for something new that says what is expected."""
        before = {seen.id: seen.text for seen in self.said()}
        await self.bo.say(self.room, text)
        return await self.reads(expected, before)

    async def reads(self, expected: str, before: dict[str, str] | None = None) -> Seen:
        """Wait in the room for something that says what is expected, perhaps something new."""
        old = before or {}

        def found() -> list[Seen]:
            return [s for s in self.said() if expected in s.text and old.get(s.id) != s.text]

        try:
            await self.bo.until(lambda: bool(found()))
        except AssertionError:
            texts = [seen.text for seen in self.said()]
            log = (self.place.folder / "gateway.log").read_text()
            raise AssertionError(f"no {expected!r} in {texts}; {log}") from None
        return found()[-1]

    async def link(self) -> None:
        """Make the account on Matrix Bo's: one code, said once."""
        offered = await self.place.ask(self.place.bo, "/link", "Your code:")
        found = CODE.search(offered["text"])
        assert found is not None
        here = await self.ask(f"link {found[0]}", "This account belongs to Bo now")
        assert here.encrypted
        await self.place.reads(self.place.bo, "is now one of your accounts")
        await self.place.reads(
            self.place.ada, f"Bo has one more account now: Matrix {self.bo.user}"
        )


@pytest.mark.limit(400)
async def test_a_person_on_telegram_and_on_matrix_shares_a_robot_with_themselves(
    synapse: Synapse, tmp_path: Path, launcher: Launcher
) -> None:
    robots = synapse.create_account("robots")
    async with (
        lab(tmp_path, launcher, robots=ROBOTS) as place,
        Person(synapse.create_account("bo"), tmp_path / "bo") as bo,
    ):
        table = MATRIX.format(
            url=robots.url, user=robots.user, password=robots.password, folder=tmp_path / "matrix"
        )
        config = place.config.read_text().replace("lease_idle_s = 1.0", "lease_idle_s = 60.0")
        place.config.write_text(config.replace("\n[limits]", f"{table}\n[limits]"))
        gateway = await place.start()
        chats = TwoChats(place, bo, robots)
        await chats.meet()
        await chats.ask("omni move forward 0.2 m", "I do not know you yet")
        await chats.link()

        await one_lease(chats)
        await one_plan(chats)
        await one_dashboard_each(chats)
        gateway.kill()
        gateway = await place.start()
        assert await gateway.says("rooms: listening"), gateway.log()
        await notices_where_bo_was_last(chats)
        await the_account_is_lost(chats)
        assert await place.control.violations() == []


async def one_lease(chats: TwoChats) -> None:
    """What Bo has, Bo has in both chats, and nobody else."""
    place = chats.place
    await place.ask(place.bo, "omni move 0.2 m", "done")
    await chats.ask("omni move back 0.2 m", "done")
    await place.ask(place.ada, "omni move 0.2 m", "Bo")
    await place.ask(place.bo, "omni move 0.2 m", "done")


async def one_plan(chats: TwoChats) -> None:
    """A time that is booked in one chat is booked in the other."""
    await chats.ask("/book omni tomorrow 14:00 1h", "omni")
    await chats.place.ask(chats.place.bo, "/slots", "omni: tomorrow 14:00 to 15:00")
    await chats.place.ask(chats.place.bo, "/book omni tomorrow 16:00 1h", "omni")
    await chats.ask("/slots", "omni: tomorrow 16:00 to 17:00")


async def one_dashboard_each(chats: TwoChats) -> None:
    """Each chat has a card of its own, and both say the same."""
    place = chats.place
    await place.say(place.bo, "/card omni")
    await place.reads(place.bo, "updated")
    await chats.ask("/card omni", "updated")


async def notices_where_bo_was_last(chats: TwoChats) -> None:
    """After a restart, and once Bo has spoken elsewhere."""
    place = chats.place
    before = {seen.id: seen.text for seen in chats.said()}
    await place.ask(place.ada, "/grant Bo senior for 1h", "Bo")
    await chats.reads("senior", before)
    told = await place.control.messages(place.bo, by_bot=True)
    assert not any("senior" in (one["text"] or "") for one in told)
    await place.ask(place.bo, "/me", "You are Bo.")
    await place.ask(place.ada, "/grant Bo viewer for 1h", "Bo")
    await place.reads(place.bo, "viewer")


async def the_account_is_lost(chats: TwoChats) -> None:
    """Said in both chats and to the admins; nothing moves from there any more."""
    place, account = chats.place, chats.bo.user
    question = await place.ask(place.bo, "/unlink matrix", f"Take Matrix {account} away")
    await place.control.tap(place.bo, place.bo, question["message_id"], "Take it away")
    await place.reads(place.bo, f"Matrix {account} is taken away.")
    await chats.reads("This account does not belong to Bo any more.")
    await place.reads(place.ada, "Bo has taken the account")
    await chats.ask("omni move forward 0.2 m", "I do not know you yet")
    await place.ask(place.bo, "omni move 0.2 m", "done")
