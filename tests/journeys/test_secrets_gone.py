"""What holds a secret goes out of a chat: after its use, after its time, over a restart too."""

from __future__ import annotations

import base64
import re
import time
from typing import TYPE_CHECKING

from rosic.authoriser import two_factor
from tests.journeys.lab import Lab, lab
from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

OMNI = ('[[robot]]\nprofile = "omni"\nlink = "simulated"',)
CODE = re.compile(r"start=([A-Za-z0-9_-]+)")
BOT = 4242424242


async def gone(place: Lab, chat: int, message: int) -> None:
    """Wait until a message is no more."""

    async def look() -> bool:
        return bool((await place.control.message(chat, message))["deleted"])

    assert await place.until(look, 30.0 * pace()), "a secret is still there"


async def is_there(place: Lab, chat: int, message: int) -> bool:
    return not (await place.control.message(chat, message))["deleted"]


async def test_an_invitation_and_a_typed_code_go_once_they_are_used(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher, robots=OMNI) as place:
        gateway = await place.start()
        used = await place.ask(place.ada, "/invite operator omni for 2h", "start=")
        [code] = CODE.findall(used["text"])
        cy = await place.control.create_user("Cy")
        typed = await place.say(cy, code)
        offered = await place.reads(cy, "You are invited")
        assert await is_there(place, cy, typed), "it is not used yet"
        # A restart between showing and using: what was shown is remembered.
        gateway.kill()
        await place.start()
        kept = await place.ask(place.ada, "/invite viewer omni for 2h", "start=")
        typed = await place.say(cy, code)
        offered = await place.reads(cy, "You are invited", to=typed)
        await place.control.tap(cy, cy, offered["message_id"], "Join")
        await gone(place, place.ada, used["message_id"])
        await gone(place, cy, typed)
        assert await is_there(place, place.ada, kept["message_id"])
        await place.control.tap(place.ada, place.ada, kept["message_id"], "Take it back")
        await gone(place, place.ada, kept["message_id"])
        assert await place.control.violations() == []


async def test_an_invitation_that_was_taken_away_is_said_nowhere_again(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher, robots=OMNI) as place:
        await place.start()
        shown = await place.ask(place.ada, "/invite operator omni for 2h code 12s", "start=")
        [code] = CODE.findall(shown["text"])
        cy = await place.control.create_user("Cy")
        offered = await place.ask(cy, code, "You are invited")
        await place.control.tap(cy, cy, offered["message_id"], "Join")
        await gone(place, place.ada, shown["message_id"])

        async def buttons_are_due() -> bool:
            edits = [c for c in await place.control.calls() if "editMessage" in c["method"]]
            changed = {str(call["parameters"].get("message_id")) for call in edits}
            return str(shown["message_id"]) in changed

        assert await place.until(buttons_are_due, 30.0 * pace())
        await place.drained()
        for message in await place.control.messages(place.ada):
            assert message["deleted"] or code not in message["text"], "a secret is there again"


async def test_the_key_of_an_authenticator_and_its_codes_go(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher, robots=OMNI) as place:
        await place.start()
        shown = await place.ask(place.bo, "/authenticator", "otpauth://")
        wrong = await place.say(place.bo, "/code 000000")
        await gone(place, place.bo, wrong)
        assert await is_there(place, place.bo, shown["message_id"]), "it is not set up yet"
        found = re.search(r"secret=([A-Z2-7]+)", shown["text"])
        assert found is not None
        right = await place.say(place.bo, f"/code {code_of(found[1])}")
        await gone(place, place.bo, right)
        await gone(place, place.bo, shown["message_id"])
        for message in await place.control.messages(place.bo):
            assert message["deleted"] or "secret=" not in message["text"]


def code_of(key: str) -> str:
    """Return what a phone with this key shows now."""
    return two_factor.hotp(
        base64.b32decode(key + "=" * (-len(key) % 8)), two_factor.step_at(time.time_ns())
    )


async def test_a_code_in_a_group_is_burnt_and_taken_away_where_the_bot_may(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher, robots=OMNI) as place:
        await place.start()
        group = await place.control.create_chat("supergroup", "Lab", members=[place.ada, place.bo])
        for status, goes in (("member", False), ("administrator", True)):
            said = await place.ask(place.ada, "/invite operator omni for 2h", "start=")
            await place.control.call("set_member", chat=group, user=BOT, status=status)
            [code] = CODE.findall(said["text"])
            shown = await place.say(place.bo, f"/start {code}", group)
            await gone(place, place.ada, said["message_id"])
            if goes:
                await gone(place, group, shown)
            else:
                await place.drained()
                assert await is_there(place, group, shown)
