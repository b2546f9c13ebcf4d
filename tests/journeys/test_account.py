"""The gateway and its account: wrong, contested, taken away; and the end of the gateway."""

from __future__ import annotations

import asyncio
import signal
import time
from typing import TYPE_CHECKING

import aiohttp
import pytest

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.control_client import ask_gateway
from tests.journeys.fleet import TOKEN
from tests.journeys.lab import Lab, lab
from tests.pace import patience

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

SIMULATED = ['[[robot]]\nprofile = "omni"\nlink = "simulated"']
FROZEN = "You sent this while I could not listen. Nothing was done."


async def test_a_wrong_token_ends_the_start_with_a_sentence(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        text = place.config.read_text()
        place.config.write_text(text.replace(TOKEN, "4242424242:wrong-wrong-wrong-wrong-wrong"))

        gateway = await place.start(listens=False)

        assert await gateway.ends(120) == 1
        last = gateway.log().splitlines()[-1]
        assert last.startswith("rosic: Telegram does not accept the token of the messenger lab.")
        assert "wrong-wrong" not in gateway.log()
        assert "Traceback" not in gateway.log()


@pytest.mark.limit(400)
async def test_while_somebody_else_receives_nothing_moves_and_stops_work(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        gateway = await place.start()
        thief = asyncio.create_task(poll_for_ever(place))
        try:
            assert await gateway.says("Another program receives the messages of the bot")
            await place.ask(place.bo, "ant hop", FROZEN)
            await place.say(place.bo, "stop bee")
            await place.reads(place.bo, "STOP: Bee at rest")
        finally:
            thief.cancel()
            await asyncio.gather(thief, return_exceptions=True)
        assert place.acted() == 0

        assert await gateway.says("lab: listening", times=2)
        await place.ask(place.bo, "ant hop", "done ")
        await place.ask(place.bo, "bee hop", "is stopped")


async def poll_for_ever(place: Lab) -> None:
    """Ask for updates as somebody does who has the token; confirm none."""
    url = f"{place.control.api_base}{TOKEN}/getUpdates"
    async with aiohttp.ClientSession() as session:
        while True:
            async with session.post(url, json={"timeout": 2}) as response:
                await response.read()
            await asyncio.sleep(0.05)


async def test_sigterm_in_motion_brings_it_to_rest_and_tells(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher, robots=SIMULATED) as place:
        gateway = await place.start()
        card = await place.ask(place.bo, "omni move forward 3 m", "driving")
        began_s = time.monotonic()

        status = await gateway.ends(60, signal.SIGTERM)

        assert status == 0
        assert time.monotonic() - began_s < 5 * patience()
        [shown] = [
            message
            for message in await place.control.messages(place.bo, by_bot=True)
            if message["message_id"] == card["message_id"]
        ]
        assert "stopped before it ended" in shown["text"]
        assert "ROSIC was shut down" in shown["text"]
        assert "Traceback" not in gateway.log()

        again = await place.start()
        assert "interrupted" not in again.log()
        await place.ask(place.bo, "omni move forward 5 cm", "done ")


async def test_somebody_revoked_stays_revoked_over_a_kill(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        gateway = await place.start()
        place.counter.work_s = 20.0
        await place.say(place.bo, "ant hop")
        assert await place.counter.wait_for(1, 60)

        answers = [
            a async for a in ask_gateway(place.data, AdminRequest(AdminVerb.REVOKE, ("Bo",)), print)
        ]

        assert answers[-1].good, answers
        assert await place.until(lambda: place.counter.stops("ant")), "Bo's robot was not stopped"
        await place.ask(place.bo, "bee hop", "Your access here has ended.")
        gateway.kill()
        await place.start()
        await place.ask(place.bo, "bee hop", "Your access here has ended.")
        assert place.acted("bee") == 0
