"""The page from BotFather to a first motion, followed word by word."""

from __future__ import annotations

import asyncio
import re
import shlex
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.interfaces.cache import KNOWN, ensure_built
from rosic.testing.telegram import FakeTelegram
from tests.cli.terminal import rosic_at
from tests.pace import pace
from tests.real.ros2.simulated import simulated
from tests.real.ros2.test_my_robot_page import Block, blocks

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rosic.testing.ros2.graph import RosGraph
    from tests.cli.terminal import Terminal

CODE = re.compile(r"\b[0-9A-Z]{4}-[0-9A-Z]{4}\b")
ROBOT = "rover"


@contextmanager
def terminal(line: str, folder: Path) -> Iterator[Terminal]:
    name, *words = shlex.split(line)
    assert name == "rosic"
    with rosic_at(words, folder) as opened:
        yield opened


def pairs(block: Block) -> list[tuple[str, str]]:
    return [(one.strip(), two.strip()) for one, _, two in (r.partition("|") for r in block.lines)]


def answer_the_questions(
    folder: Path, line: str, answers: list[tuple[str, str]], token: str
) -> None:
    with terminal(line, folder) as asked:
        for question, answer in answers:
            asked.wait_for(question)
            asked.type(token if answer == "TOKEN" else answer)
        assert asked.ended() == 0, asked.shown
        assert "Written: " in asked.shown


def follow_to_the_start(folder: Path, page: list[Block], server: FakeTelegram) -> None:
    """Do everything that stands before the gateway runs."""
    [init] = [block for block in page if block.about == "init"]
    [answers] = [block for block in page if block.language == "answers"]
    answer_the_questions(folder, init.lines[0], pairs(answers), server.token)
    config = folder / "rosic.toml"
    telegram = 'kind = "telegram"\n'
    text = config.read_text(encoding="utf-8")
    assert text.count(telegram) == 1
    config.write_text(text.replace(telegram, f'{telegram}api_base = "{server.api_base}"\n'))
    lines = [line for b in page if b.language == "sh" and not b.about for line in b.lines]
    assert [line.split()[1] for line in lines] == ["check", "doctor"]
    for line in lines:
        with terminal(line, folder) as ran:
            assert ran.ended() == 0, (line, ran.shown)
            assert "not measured: stop" not in ran.shown


async def speak(folder: Path, page: list[Block], server: FakeTelegram) -> None:
    """Run the gateway, hand the code in, and tap what the page says."""
    [run] = [block for block in page if block.about == "run"]
    [taps] = [block for block in page if block.language == "taps"]
    ada = server.create_user("Ada")
    with terminal(run.lines[0], folder) as running:
        await asyncio.to_thread(running.wait_for, "?start=")
        found = CODE.search(running.shown)
        assert found, running.shown
        head, *steps = pairs(taps)
        assert head == ("you", "then you see")
        for what, then in steps:
            if what == "START":
                server.say(ada, ada, f"/start {found[0]}")
            elif what.startswith('"'):
                server.say(ada, ada, what.strip('"'))
            else:
                server.tap(ada, ada, await shown(server, ada, what), what)
            await shown(server, ada, then)


async def shown(server: FakeTelegram, user: int, text: str) -> int:
    """Wait until somebody is told a text or offered a button; return the newest such message."""
    end_s = time.monotonic() + 20 * pace()
    while True:
        seq, seen = server.seq, server.messages(user, by_bot=True)
        for message in reversed(seen):
            labels = [key["text"] for row in message["buttons"] for key in row]
            if text in labels or text in (message["text"] or ""):
                return int(message["message_id"])
        told = [(m["text"], [k["text"] for row in m["buttons"] for k in row]) for m in seen]
        assert time.monotonic() < end_s, f"no {text!r} in: {told}"
        await server.wait(seq, 1.0)


@pytest.mark.limit(400)
async def test_the_page_leads_from_a_token_to_a_motion(
    graph: RosGraph,
    tmp_path: Path,
    interfaces: Path,  # noqa: ARG001 - built before
) -> None:
    for package in KNOWN.values():
        ensure_built(package)
    page = blocks("../ten-minutes.md")
    here = tmp_path / "here"
    here.mkdir()
    async with FakeTelegram() as server:
        try:
            with simulated(graph, tmp_path, ROBOT):
                await asyncio.to_thread(follow_to_the_start, here, page, server)
                await speak(here, page, server)
        finally:
            (here / "telegram-token.txt").unlink(missing_ok=True)  # no token is left behind
