"""One person with two accounts: linked by one code, over a crash, and one of them lost again."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from tests.journeys.lab import lab

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.lab import Lab
    from tests.journeys.running import Launcher

CODE = re.compile(r"\b[0-9A-Z]{4}-[0-9A-Z]{4}\b")
ROBOTS = ('[[robot]]\nprofile = "omni"\nlink = "simulated"',)


async def test_two_accounts_are_one_person_over_a_crash_until_one_is_lost(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher, robots=ROBOTS) as place:
        config = place.config.read_text().replace("lease_idle_s = 1.0", "lease_idle_s = 60.0")
        place.config.write_text(config)
        other = await place.control.create_user("Bo's second phone")
        gateway = await place.start()
        await place.ask(other, "omni move 0.2 m", "I do not know you yet")
        offered = await place.ask(place.bo, "/link", "Your code:")
        found = CODE.search(offered["text"])
        assert found is not None
        assert f"?start={found[0]}" in offered["text"], "no link that opens the other chat"
        await place.say(other, f"/start {found[0]}")
        await place.reads(other, "This account belongs to Bo now")
        await place.reads(place.bo, f"Telegram {other} is now one of your accounts")
        await place.reads(place.ada, f"Bo has one more account now: Telegram {other}")

        await place.ask(place.bo, "omni move 0.2 m", "done")
        await place.ask(other, "omni move 0.2 m", "done")
        await place.ask(place.ada, "omni move 0.2 m", "Bo")
        gateway.kill()
        await place.start()
        await place.ask(other, "/me", f"Your accounts: Telegram {place.bo} and Telegram {other}")
        await place.ask(other, "omni move 0.2 m", "done")

        await take_away(place, other)
        await place.ask(other, "omni move 0.2 m", "I do not know you yet")
        await place.ask(place.bo, "omni move 0.2 m", "done")
        assert await place.control.violations() == []


async def take_away(place: Lab, other: int) -> None:
    """Have the admin take the second account away, who names it."""
    line = f"/unlink Bo telegram:{other}"
    question = await place.ask(place.ada, line, f"Take Telegram {other} away from Bo?")
    await place.control.tap(place.ada, place.ada, question["message_id"], "Take it away")
    await place.reads(place.ada, f"Telegram {other} is taken away.")
    await place.reads(other, "This account does not belong to Bo any more.")
    await place.reads(place.bo, f"Ada has taken Telegram {other} away")
