"""The page from BotFather to a first motion, followed word by word."""

from __future__ import annotations

import asyncio
import shlex
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.interfaces.cache import KNOWN, ensure_built
from rosic.testing.telegram import FakeTelegram
from tests.cli.following import CODE, answer_the_questions, lead_to, shown
from tests.cli.terminal import rosic_at
from tests.real.ros2.simulated import simulated
from tests.real.ros2.test_my_robot_page import Block, blocks

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rosic.testing.ros2.graph import RosGraph
    from tests.cli.terminal import Terminal

ROBOT = "rover"


@contextmanager
def terminal(line: str, folder: Path) -> Iterator[Terminal]:
    name, *words = shlex.split(line)
    assert name == "rosic"
    with rosic_at(words, folder) as opened:
        yield opened


def pairs(block: Block) -> list[tuple[str, str]]:
    return [(one.strip(), two.strip()) for one, _, two in (r.partition("|") for r in block.lines)]


def follow_to_the_start(folder: Path, page: list[Block], server: FakeTelegram) -> None:
    """Do everything that stands before the gateway runs."""
    [init] = [block for block in page if block.about == "init"]
    [answers] = [block for block in page if block.language == "answers"]
    _, *words = shlex.split(init.lines[0])
    answer_the_questions(folder, words, pairs(answers), server.token)
    lead_to(server, folder / "rosic.toml")
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
