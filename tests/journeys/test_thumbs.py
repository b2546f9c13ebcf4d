"""A thumb beside an alarm, all the way: Telegram, a real `rosic run`, and what the others read."""

from __future__ import annotations

from typing import TYPE_CHECKING

import yaml

from rosic.config.profiles import shipped_profiles
from rosic.features.alerts.active_alerts import TOLD
from tests.journeys.lab import Lab, lab
from tests.journeys.record import ask_record

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

OMNI = ('[[robot]]\nprofile = "warm.yaml"\nlink = "simulated"',)
RULE = {
    "name": "on_battery",
    "when": "battery > 1 %",
    "for": "1 s",
    "say": "It runs on its battery",
    "severity": "info",
    "tell": "operators",
}
# What says which message tells of an alarm, behind the message itself; one for each who reads it.
PLACED = f"select key from facts where kind = '{TOLD}' and length(body) > 0"  # noqa: S608 - ours
TOLD_HERE = ("Ada", "Bo")
ALARM = "omni: It runs on its battery."


def write_profile(folder: Path) -> None:
    """Write an omni whose alarm is raised as soon as it reports."""
    profile = yaml.safe_load(shipped_profiles()["omni"].read_text())
    (folder / "warm.yaml").write_text(yaml.safe_dump(profile | {"alerts": [RULE]}))


async def reactions(place: Lab, chat: int, message: int) -> dict[str, list[str]]:
    """Return who put what beside a message."""
    found: dict[str, list[str]] = (await place.control.message(chat, message))["reactions"]
    return found


async def test_a_thumb_has_seen_an_alarm_and_the_bot_nods(
    tmp_path: Path, launcher: Launcher
) -> None:
    write_profile(tmp_path)
    async with lab(tmp_path, launcher, robots=OMNI) as place:
        await place.start()
        bo, ada = place.bo, place.ada
        told = await place.reads(bo, ALARM)
        await place.reads(ada, ALARM)
        thumb = {"chat": bo, "user": bo, "message": told["message_id"]}
        await place.control.call("react", **thumb, emoji=["👎"])
        await place.drained()
        await place.control.call("react", **thumb, emoji=["👍"])
        await place.reads(ada, "It runs on its battery: Bo has seen it.")

        async def nodded() -> bool:
            return ["👌"] in (await reactions(place, bo, told["message_id"])).values()

        assert await place.until(nodded)
        await place.ask(ada, "/alerts", "seen by Bo")
        asked = [c for c in await place.control.calls() if c["method"] == "getUpdates"]
        assert all("message_reaction" in c["parameters"]["allowed_updates"] for c in asked)
        assert await place.control.violations() == []


async def test_a_thumb_counts_beside_what_was_said_before_a_kill(
    tmp_path: Path, launcher: Launcher
) -> None:
    write_profile(tmp_path)
    async with lab(tmp_path, launcher, robots=OMNI) as place:
        gateway = await place.start()
        told = await place.reads(place.bo, ALARM)
        await place.reads(place.ada, ALARM)
        assert await place.until(lambda: len(ask_record(place.data, PLACED)) == len(TOLD_HERE))
        gateway.kill()
        thumb = {"chat": place.bo, "user": place.bo, "message": told["message_id"]}
        await place.control.call("react", **thumb, emoji=["👍"])
        await place.start()
        await place.reads(place.ada, "It runs on its battery: Bo has seen it.")
        assert await place.control.violations() == []


async def test_an_alarm_that_a_kill_cut_off_is_said_with_its_button_and_takes_a_thumb(
    tmp_path: Path, launcher: Launcher
) -> None:
    write_profile(tmp_path)
    async with lab(tmp_path, launcher, robots=OMNI) as place:
        bo, ada = place.bo, place.ada
        await place.control.fail("bad_gateway", "sendMessage", times=1_000, chat_id=bo)
        gateway = await place.start()
        await place.reads(ada, ALARM)
        await place.ask(ada, "/alerts", "It runs on its battery")
        gateway.kill()
        assert await place.control.messages(bo, by_bot=True) == []
        await place.control.call("calm")
        await place.start()
        told = await place.reads(bo, ALARM)
        assert told["text"].endswith("(Said again: ROSIC was restarted.)")
        labels = [button["text"] for row in told["buttons"] for button in row]
        assert labels == ["Seen", "Mute 1 h", "Status"]
        thumb = {"chat": bo, "user": bo, "message": told["message_id"]}
        await place.control.call("react", **thumb, emoji=["👍"])
        await place.reads(ada, "It runs on its battery: Bo has seen it.")
        await place.control.tap(bo, bo, told["message_id"], "Seen")
        await place.reads(bo, "omni: It runs on its battery: Bo has seen it already")
        assert await place.control.violations() == []
