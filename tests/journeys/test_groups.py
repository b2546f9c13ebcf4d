"""A group in Telegram's privacy mode, from the day the bot comes to the day it is put out."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from tests.journeys.lab import lab

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.lab import Lab
    from tests.journeys.running import Launcher

PRIVATE_MODE = ("--no-limits",)
BOT = 4242424242
AT_BOT = "@rosic_test_bot"
TRIED_AT_MOST = 3


async def _group(place: Lab, **more: object) -> int:
    members = [place.ada, place.bo]
    return await place.control.create_chat("supergroup", "Lab", members=members, **more)


async def test_it_says_what_it_hears_and_stop_works_all_the_same(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher, options=PRIVATE_MODE) as place:
        await place.start()
        await place.reads(place.ada, "/stop and a reply with stop do arrive")
        group = await _group(place)
        await place.reads(group, "Being in this group gives nobody any")
        await place.reads(group, "say /stop, not stop")
        await place.reads(place.ada, "Ada put me into Lab")

        await place.say(place.bo, "ant hop", chat=group)  # Telegram keeps it to itself
        await place.ask(place.bo, f"{AT_BOT} ant hop", "done ", chat=group)
        life = await place.reads(group, "Ant: ")
        again = await place.say(place.bo, "hop", chat=group, reply_to=life["message_id"])
        await place.reads(group, "done ", to=again)
        assert place.acted("ant") == 2

        await place.say(place.bo, "stop", chat=group, reply_to=life["message_id"])
        await place.reads(group, "at rest")
        await place.ask(place.ada, "resume", "")
        await place.say(place.bo, "/stop", chat=group)
        await place.drained()
        await place.ask(place.bo, "bee hop", "is stopped")


async def test_put_out_of_the_group_it_ends_quietly_and_goes_on_elsewhere(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        await place.start()
        group = await _group(place)
        await place.reads(group, "gives nobody any")
        for _ in range(5):
            await place.say(place.bo, "bee hop", chat=group)
        await place.control.call("set_member", chat=group, user=BOT, status="kicked")
        await place.drained()
        await place.ask(place.bo, "cat hop", "done ")

        async def silent() -> bool:
            return place.acted("bee") == 5

        assert await place.until(silent)
        await place.ask(place.bo, "status", "Bee")
        refused = [
            call
            for call in await place.control.calls()
            if call["code"] == 403 and str(group) in str(call["parameters"].get("chat_id"))
        ]
        assert len(refused) <= TRIED_AT_MOST
        await place.control.call("set_member", chat=group, user=BOT, status="member")
        await place.say(place.bo, "ant hop", chat=group)
        await place.reads(group, "Ant: hop")


async def test_a_live_card_goes_on_where_its_group_has_moved(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        gateway = await place.start()
        group = await place.control.create_chat(
            "group", "Lab", members=[place.ada], bot="administrator"
        )
        await place.say(place.ada, "/card pin ant", chat=group)
        old = await place.reads(group, "updated ")

        async def pinned(chat: int) -> dict[str, Any] | None:
            shown = await place.control.messages(chat, by_bot=True)
            found = [one for one in shown if one["pinned"] and "updated " in (one["text"] or "")]
            return found[0] if found else None

        assert await place.until(lambda: pinned(group))
        await place.ask(place.ada, "ant hop", "done ", chat=group)  # written behind the pin
        gateway.kill()  # it hears of the move when it is back
        new = await place.control.call("migrate", group=group)
        await place.start()
        card = await place.until(lambda: pinned(new))
        assert card is not None, "the card is there and pinned"
        await place.ask(place.ada, "ant hop", "done ", chat=new)
        await place.reads(new, "now: done")
        left = await place.control.message(group, old["message_id"])
        assert "This card has ended" not in left["text"], "nobody can write there any more"
        await place.ask(place.ada, "/card off", "The card has ended.", chat=new)
        await place.reads(new, "This card has ended.")
        assert await place.control.violations() == []


async def test_a_topic_is_about_a_robot_and_is_answered_where_it_was_asked(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        await place.start()
        group = await _group(place, topics=["Ants", "Bees"])
        topics = await place.control.call("topics", chat=group)
        for name, robot in (("Ants", "ant"), ("Bees", "bee")):
            where = {"chat": group, "thread": topics[name]}
            told = await place.ask(place.ada, f"/topic {robot}", f"about {robot}", **where)
            assert told["thread"] == topics[name]
            told = await place.ask(place.bo, "hop", "done ", **where)
            assert told["thread"] == topics[name]
        assert (place.acted("ant"), place.acted("bee")) == (1, 1)


async def test_the_menu_follows_languages_chats_and_roles(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        await place.start()
        found: dict[tuple[str, str], set[str]] = {}

        async def menus(count: int) -> bool:
            found.clear()
            for key, commands in (await place.control.call("commands")).items():
                scope, language = json.loads(key)
                chat = dict(scope).get("chat_id", dict(scope)["type"])
                found[str(chat), language] = {one["command"] for one in commands}
            return len(found) == count

        assert await place.until(lambda: menus(6))
        kinds = {chat for chat, _ in found}
        assert kinds == {"all_private_chats", "all_group_chats", str(place.ada)}
        assert {language for _, language in found} == {"", "de"}
        assert "einladen" in found[str(place.ada), "de"]
        assert {"buchen", "stopp", "undo"} <= found["all_private_chats", "de"]
        assert "einladen" not in found["all_private_chats", "de"]
        assert "topic" in found["all_group_chats", ""]
        await place.ask(place.ada, "/grant Bo admin for 1h", "Bo")
        assert await place.until(lambda: menus(8)), found
        assert "invite" in found[str(place.bo), ""]
        called = [c for c in await place.control.calls() if c["method"] == "setMyCommands"]
        assert len(called) == 8
