"""A newcomer's first hour, typed and tapped for real: docs/first-hour.md is what they saw.

With ROSIC_PICTURES=draw (`make pictures`) the page is written anew.
"""

from __future__ import annotations

import asyncio
import os
import re
from difflib import unified_diff
from typing import TYPE_CHECKING, Final

import pytest

from rosic.testing.telegram import FakeTelegram
from rosic.testing.telegram.transcript import START, TranscriptView, transcript
from tests.cli.following import CODE, answer_the_questions, lead_to, shown
from tests.cli.terminal import rosic_at
from tests.journeys.pictures import ASKED_TO_DRAW, DOCS, steady

if TYPE_CHECKING:
    from pathlib import Path

    from tests.cli.terminal import Terminal

PAGE: Final = DOCS / "first-hour.md"
ANSWERS: Final = (
    ("Name of this place?", "lab"),
    ("Its time zone?", ""),
    ("Telegram bot token", "TOKEN"),
    ("Simulate", ""),
    ("Your Telegram id", ""),
)
DEMO: Final = (
    ("omni move 50 cm left", "[4] Menu"),
    ("omni mvoe 1 m", "Did you mean move?"),
    ("kuka1 grasp force=20", "KUKA iiwa: done"),
    ("omni move 4 m", "driving 0 %"),
    ("stop", "STOP: "),
)
HEAD: Final = """# A newcomer's first hour

What somebody new types and reads, from a clean clone to a student who is refused. Nobody wrote
this page: a test walks it and holds it (`make pictures` writes it anew).
Times, codes and figures of one run stand for those of yours.

"""
HERE: Final = ". .venv/bin/activate"
STAND_IN: Final = f"""{HERE}
pip install -e '.[testing]'
python -m rosic.testing.telegram --port 8081"""
INIT: Final = f"{HERE}\nrosic init --robot omni"
KEYS = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
PROGRESS = re.compile(r": [a-z ]+ \d+ %$")
TOOK = re.compile(r"ready in [\d.]+ s")
LINK = re.compile(r"start=[\w-]+")
BLOCKS = re.compile(r"[█▀▄]")


class Page:
    """The page as it is written."""

    def __init__(self) -> None:
        self.text = HEAD

    def part(self, title: str, *says: str) -> None:
        """Begin a part."""
        self.text += "\n".join((f"## {title}\n", *says, ""))
        self.text += "\n" if says else ""

    def block(self, lines: str, language: str = "") -> None:
        """Show what stood there."""
        self.text += f"```{language}\n{lines.strip()}\n```\n\n"


def plain(shown_there: str) -> str:
    """Return what a terminal shows, a line once, without colours and progress in between."""
    text = TOOK.sub("ready in 1.0 s", KEYS.sub("", shown_there))
    text = CODE.sub("ABCD-EFGH", LINK.sub("start=...", text))
    lines = map(str.rstrip, text.replace("\r", "\n").split("\n"))
    kept = (one for one in lines if one and not PROGRESS.search(one) and not BLOCKS.search(one))
    return "\n".join(kept)


@pytest.mark.limit(300)
async def test_the_first_hour_is_what_the_page_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERM", "dumb")
    page = Page()
    await asyncio.to_thread(demonstrate, page, tmp_path)
    async with FakeTelegram() as server:
        await asyncio.to_thread(found, page, tmp_path, server)
        try:
            await serve(page, tmp_path, server)
        finally:
            (tmp_path / "telegram-token.txt").unlink()  # no token is left behind
    text = page.text.replace(server.url, "http://127.0.0.1:8081").rstrip() + "\n"
    if os.environ.get(ASKED_TO_DRAW):
        PAGE.write_text(text, encoding="utf-8")
    written = [steady(line) for line in PAGE.read_text(encoding="utf-8").splitlines()]
    now = [steady(line) for line in text.splitlines()]
    assert written == now, "\n".join(unified_diff(written, now, "the page", "today", n=1))


def demonstrate(page: Page, folder: Path) -> None:
    """See it move, as `make demo` shows it."""
    with rosic_at(["demo", "--plain"], folder) as demo:
        demo.wait_for("Ctrl-D leaves.", 40)
        wait_for_silence(demo)
        for line, seen in DEMO:
            demo.type(line)
            demo.wait_for(seen)
            wait_for_silence(demo)
        demo.type("", end="\x04")
        assert demo.ended() == 0
    page.part("See it move", "In a clean clone; installing takes a minute or two.")
    page.block("make demo", "console")
    page.block(plain(demo.shown))


def wait_for_silence(terminal: Terminal) -> None:
    """Let what belongs to an answer come, before the next line is typed."""
    before = ""
    while before != terminal.shown:
        before = terminal.shown
        terminal.look(0.7)


def found(page: Page, folder: Path, server: FakeTelegram) -> None:
    """Answer the questions of `rosic init`, with a bot of the stand-in."""
    said = answer_the_questions(folder, ["init", "--robot", "omni"], ANSWERS, server.token)
    page.part("A place of one's own", "With the stand-in for Telegram in another shell:")
    page.block(STAND_IN, "console")
    page.text += (
        "It says the token that it takes, when asked with `--help`. In the first shell:\n\n"
    )
    page.block(INIT, "console")
    page.block(plain(said))
    lead_to(server, folder / "rosic.toml")
    page.text += "The address of the stand-in is written below `kind` into `rosic.toml`:\n\n"
    page.block(f'api_base = "{server.api_base}"', "toml")


async def serve(page: Page, folder: Path, server: FakeTelegram) -> None:
    """Run it; be the admin; invite a student, who is refused and stops."""
    ada, bo = server.create_user("Ada"), server.create_user("Bo")
    with rosic_at(["run"], folder) as running:
        await asyncio.to_thread(running.wait_for, "?start=")
        code = CODE.search(running.shown)
        assert code, running.shown
        phone, student = Phone(server, ada), Phone(server, bo)
        invited = await lead(phone, code[0])
        hers = phone.saw("Ada")  # once Bo is in, the code is taken out of it
        await follow(student, invited)
        shown_there = running.shown
    page.part("Run it", "`rosic run` shows a code, as a picture too, which is left out here.")
    page.block("rosic run", "console")
    page.block("\n".join(line for line in plain(shown_there).splitlines() if " info " not in line))
    page.part("Ada's phone: the code, a first motion, an invitation")
    page.block(hers)
    page.part("Bo's phone: what a student may, and what not")
    page.block(student.saw("Bo"))


async def lead(phone: Phone, code: str) -> str:
    """Be the admin, move the robot and invite somebody; return the code for them."""
    await phone.types(f"{START} {code}", "Join")
    await phone.taps("Join", "You are in, as admin")
    await phone.types("omni move 50 cm", "done")
    await phone.types("/end omni", "Session ended")
    await phone.types("/invite student omni for 2h", "To make such a role")
    await phone.taps("Make the role student", "Make it so")
    await phone.taps("Make it so", "The role student gives now")
    await phone.types("/invite student omni for 2h", "Invitation as student")
    found_code = CODE.search((await phone.newest("Invitation as student"))["text"])
    assert found_code
    return found_code[0]


async def follow(phone: Phone, code: str) -> None:
    """Be the student: move, be refused, and stop."""
    await phone.types(f"{START} {code}", "Join")
    await phone.taps("Join", "You are in, as student")
    await phone.types("omni move 30 cm", "done")
    await phone.types("omni arm home", "Ask for it")
    await phone.types("stop", "STOP: ")


class Phone:
    """One person's private chat with the bot."""

    def __init__(self, server: FakeTelegram, user: int) -> None:
        self._server = server
        self._user = user

    async def types(self, text: str, then: str) -> None:
        """Write, and wait for what comes of it."""
        self._server.say(self._user, self._user, text)
        await shown(self._server, self._user, then)

    async def taps(self, label: str, then: str) -> None:
        """Tap the newest button that says this, and wait for what comes of it."""
        message = await shown(self._server, self._user, label)
        self._server.tap(self._user, self._user, message, label)
        await shown(self._server, self._user, then)

    async def newest(self, text: str) -> dict[str, str]:
        """Return the newest message with a text."""
        number = await shown(self._server, self._user, text)
        return dict(self._server.message(self._user, number))

    def saw(self, title: str) -> str:
        """Return the conversation, with codes covered."""
        view = TranscriptView(title=title, reader=self._user)
        chat = transcript(self._server.messages(self._user), self._server.presses(self._user), view)
        return plain("\n".join(chat.lines()))
