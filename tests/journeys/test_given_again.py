"""A command that was claimed and then given out again: the kill came before it was confirmed."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from tests.journeys.lab import Lab, lab
from tests.journeys.reading import End, read_reply
from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

NOBODY_KNOWS = "It may or may not have been carried out; please look."


async def poll_begins(place: Lab) -> None:
    """Wait until the gateway has just asked for updates."""
    seq = await place.control.seq()
    async with asyncio.timeout(60 * pace()):
        while True:
            for call in await place.control.wait(seq, 5.0, ["call"]):
                if call["method"] == "getUpdates":
                    return
                seq = call["seq"]


@pytest.mark.parametrize(("text", "robots"), [("ant hop", 1), ("flies hop", 2)])
async def test_it_is_not_done_again_and_not_said_to_be_refused(
    text: str, robots: int, tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        gateway = await place.start()
        place.counter.work_s = 60.0
        # The poll that has just begun brings the command; the next one, which would confirm it,
        # is never answered.
        await poll_begins(place)
        await place.control.fail("hang", "getUpdates", seconds=60.0)
        message = await place.say(place.bo, text)
        assert await place.counter.wait_for(robots, 60)
        gateway.kill()
        assert await place.control.pending() == 1

        await place.start()

        await place.drained()
        await place.reads(place.bo, NOBODY_KNOWS, to=message)
        assert place.acted() == robots
        replies = [
            read_reply(reply)
            for reply in await place.control.messages(place.bo, by_bot=True)
            if reply["reply_to"] == message
        ]
        ended = [reply.last for reply in replies if reply.last]
        assert ended == [(End.UNKNOWN,) * robots], [reply.text for reply in replies]
        await place.ask(place.bo, text, "is stopped" if robots == 1 else "are stopped")
