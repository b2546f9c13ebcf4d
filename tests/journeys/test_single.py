"""One command, all the way and back: as a message, and with buttons alone."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import pytest

from tests.journeys.hops import hop_report, hops_of
from tests.journeys.lab import Lab, lab

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

OMNI = ['[[robot]]\nprofile = "omni"\nlink = "simulated"']
TIME = r"\d\d:\d\d:\d\d"
LIFE = re.compile(
    rf"omni: move, 0\.50 m forward\nsent {TIME} · received by the robot {TIME}\n"
    rf"done {TIME}: moved 0\.50 m forward"
)
ON_THE_WAY = ("accepted", "sent", "received by the robot", "driving", "done")


async def test_a_message_moves_a_robot_and_its_reply_lives(
    tmp_path: Path, launcher: Launcher, capsys: pytest.CaptureFixture[str]
) -> None:
    async with lab(tmp_path, launcher, robots=OMNI) as place:
        await place.start()

        card = await place.ask(place.bo, "omni move forward 0.5 m", "done ")

        check_life(card)
        await check_where(place, 0.5)
        [begun] = [
            change
            for change in await place.control.call("changes", kinds=["said"])
            if change["message_id"] == card["reply_to"]
        ]
        hops = await hops_of(place, begun, card["message_id"], {})
        report(capsys, hop_report("omni move forward 0.5 m, as a message", hops))
        assert await place.control.violations() == []


async def test_buttons_alone_move_a_robot(
    tmp_path: Path, launcher: Launcher, capsys: pytest.CaptureFixture[str]
) -> None:
    async with lab(tmp_path, launcher, robots=OMNI) as place:
        await place.start()

        menu = await place.ask(place.bo, "/start", "What should omni do?")
        under = menu["message_id"]
        await press(place, under, "🚗 Move in a straight line", "0.50 m forward?")
        await place.control.tap(place.bo, place.bo, under, "Do it")
        card = await place.reads(place.bo, "done ")

        check_life(card)
        await check_where(place, 0.5)
        begun = (await place.control.call("changes", kinds=["pressed"]))[-1]
        hops = await hops_of(place, begun, card["message_id"], {})
        report(capsys, hop_report("omni move 0.5 m, with buttons alone", hops))
        assert await place.control.violations() == []


async def press(place: Lab, message: int, button: str, expected: str) -> None:
    """Press a button and wait until the message says something else."""
    await place.control.tap(place.bo, place.bo, message, button)
    await place.reads(place.bo, expected)


def check_life(card: dict[str, Any]) -> None:
    """The reply was edited through its life: it only ever got further, and reads well now."""
    assert LIFE.fullmatch(card["text"]), card["text"]
    texts = [str(version["text"]) for version in card["versions"]]
    while not any(word in texts[0] for word in ON_THE_WAY):
        texts.pop(0)  # what was asked there before
    stages = [max(n for n, word in enumerate(ON_THE_WAY) if word in text) for text in texts]
    assert stages == sorted(stages), texts
    assert len(texts) >= 2
    assert all("done" not in text for text in texts[:-1])


async def check_where(place: Lab, x_m: float) -> None:
    """The robot says where it is, in the chat."""
    told = await place.ask(place.bo, "status omni", "omni: at rest")
    found = re.search(r"x (-?\d+\.\d+) m", told["text"])
    assert found is not None
    assert float(found[1]) == pytest.approx(x_m, abs=0.01)


def report(capsys: pytest.CaptureFixture[str], lines: str) -> None:
    with capsys.disabled():
        print(f"\n{lines}")  # noqa: T201 - the figures are the point
