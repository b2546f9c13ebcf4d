"""The walk in docs/architecture.md is the one that a real order goes.

A gateway of its own is followed function by function (`tests.tracing`): the real Telegram
adapter against the server for tests, the record on disk, a robot as a ROS 2 node.
"""

from __future__ import annotations

import asyncio
import re
import signal
import subprocess
import sys
from contextlib import contextmanager
from itertools import pairwise
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.interfaces.cache import ensure_built, make_importable
from rosic.testing.ros2.graph import why_missing
from tests.architecture import PAGE
from tests.journeys.lab import WITHIN_S, Lab, lab
from tests.journeys.ros import onlooker
from tests.journeys.running import ROOT, environment
from tests.journeys.test_single_ros2 import OMNI, is_there, listens

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from tests.journeys.ros import Onlooker
    from tests.journeys.running import Launcher

BEGIN, END = "<!-- walk: ", "<!-- end of walk -->"
NAME = re.compile(r"`((?:\w+\.)+\w+)`")
# Where a leg begins, and which time of those that it begins.
LEGS = (
    "messengers.telegram.bot_client._Polling.parse_json_payload",
    "gateway.pipeline.Pipeline.receive",
    "gateway.order_execution.OrderExecutor._serve",
    "robots.ros2.bindings.binding_call.BindingCall.received",
    "gateway.order_execution.OrderExecutor.ended",
)
# Others begin these as well, at any time: they are looked for behind what stands before them. The
# heartbeat publishes; menus and other edits are calls of the Bot API.
OFTEN = {
    "robots.ros2.client.topics.Publisher.send",
    "messengers.telegram.bot_client.BotClient.ask",
    "messengers.telegram.bot_client._Request.do_request",
}

pytestmark = [
    pytest.mark.limit(480),
    pytest.mark.skipif(why_missing() is not None, reason=why_missing() or ""),
]


def walk() -> list[str]:
    """Return the functions of the page, in order."""
    text = PAGE.read_text(encoding="utf-8").partition(BEGIN)[2].partition(END)[0]
    steps = [line for line in text.splitlines() if line.startswith("1. ")]
    return [name for line in steps for name in NAME.findall(line)]


def strays(page: list[str], begun: list[str]) -> list[str]:
    """Return what a page names that did not begin, or not behind all that it names before.

    Args:
        page: The walk.
        begun: What began, in order, without ``rosic.``.
    """
    receive = len(begun) - 1 - begun[::-1].index(LEGS[1])
    at = max(n for n in range(receive) if begun[n] == LEGS[0]) - 1
    leg, wrong = at, []
    for name in page:
        if name in LEGS:
            leg = at
        behind = at if name in OFTEN else leg
        found = next((n for n in range(behind + 1, len(begun)) if begun[n] == name), -1)
        if found <= at:
            wrong.append(name)
        else:
            at = found
    return wrong


@pytest.fixture(scope="module")
def _interfaces() -> None:
    make_importable()
    ensure_built()


@contextmanager
def followed(
    place: Lab, file: Path, variables: dict[str, str]
) -> Iterator[subprocess.Popen[bytes]]:
    """Run a gateway that is followed while inside; what began is in a file once it has ended."""
    told = (str(file), "run", "-c", str(place.config))
    with (place.folder / "gateway.log").open("wb") as log:
        process = subprocess.Popen(  # noqa: S603 - our own program
            [sys.executable, "-m", "tests.tracing", *told],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=log,
            cwd=ROOT,
            env={**environment(), **variables},
        )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


async def traced(place: Lab, looking: Onlooker, variables: dict[str, str]) -> list[str]:
    """Let one order be carried out by a gateway that is followed; return what began in it."""
    file = place.folder / "begun"
    with followed(place, file, variables) as process:
        await listens(place)
        await is_there(place, looking)
        card = await place.ask(place.bo, "omni drive 0.2 m/s for 1 s", "done ")
        assert "drove for 1 s" in card["text"]
        process.send_signal(signal.SIGTERM)
        await asyncio.to_thread(process.wait, WITHIN_S)
    return [name.removeprefix("rosic.") for name in file.read_text(encoding="utf-8").split("\n")]


@pytest.mark.usefixtures("_interfaces")
async def test_an_order_goes_the_way_that_the_page_says(tmp_path: Path, launcher: Launcher) -> None:
    page = walk()
    assert len(page) == len(set(page)) > 60
    async with (
        onlooker(tmp_path, "omni") as (looking, variables),
        lab(tmp_path, launcher, robots=OMNI) as place,
    ):
        begun = await traced(place, looking, variables)

    assert strays(page, begun) == []
    for name in page[1:]:
        if name in LEGS:  # where to look is found by these: without one there is nothing to compare
            continue
        renamed = [f"{n}_anew" if n == name else n for n in begun]
        assert name in strays(page, renamed), f"another name for {name} is not noticed"
    for one, other in pairwise(page):
        if {one, other}.isdisjoint(OFTEN.union(LEGS)):
            turned = {one: other, other: one}
            assert strays(page, [turned.get(n, n) for n in begun]), f"{other} before {one}"
