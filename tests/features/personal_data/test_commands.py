from __future__ import annotations

import asyncio
import re

import pytest

from rosic.config.plugins import catalogue
from rosic.core.i18n import in_language
from rosic.core.message import ChatKind
from rosic.features.personal_data.messages import HOW_TO_SET
from tests.features.personal_data.data_gateway import a_ward
from tests.gateway.place import ADA, BO, VI, Place

GROUP = ChatKind.GROUP
CODE = re.compile(r"\b[0-9A-Z]{4}-[0-9A-Z]{4}\b")


# ---- settings ----


async def test_settings_are_shown_set_and_kept_over_a_restart() -> None:
    async with a_ward() as ward:
        assert await ward.said("settings", account=BO) == (
            "Your settings:\n  Language: English\n  Units: metric\n"
            "  Robot, when none is named: none\n  Highest speed: whatever each robot allows\n"
            f"  Time zone: UTC\n{HOW_TO_SET}"
        )
        assert await ward.said("language", "deutsch", account=BO) == "Saved."
        assert await ward.said("settings", "units imperial", account=BO) == "Saved."
        assert await ward.said("settings", "robot omni", account=BO) == "Saved."
        assert await ward.said("settings", "time zone europe/vienna", account=BO) == "Saved."
        reply = await ward.ask("settings", account=BO)
        assert reply.text == (
            "Your settings:\n  Language: Deutsch\n  Units: imperial\n"
            "  Robot, when none is named: omni\n  Highest speed: whatever each robot allows\n"
            f"  Time zone: Europe/Vienna\n{HOW_TO_SET}"
        )
        assert [button.command for row in reply.buttons for button in row] == [
            "/settings units metric",
            "/language en",
        ]
        assert ward.book.of(ward.id_of(VI)).robot == ""


async def test_what_is_no_setting_is_said_so() -> None:
    async with a_ward() as ward:
        assert (await ward.said("settings", "colour blue")).startswith(
            'There is no setting "colour". Write what and how, for example: /settings speed'
        )
        assert (await ward.said("settings", "zone Atlantis")).startswith("I know no time zone")
        assert await ward.said("settings", kind=GROUP) == (
            "Ask me that in a private chat with me, please."
        )
        for line in (("language",), ("settings", "language")):
            reply = await ward.ask(*line)
            assert reply.text == "Language: English. I speak English and Deutsch."
            assert in_language(reply.text, catalogue("de")).startswith("Sprache: Deutsch.")
            labels = [(b.label, b.command) for row in reply.buttons for b in row]
            assert labels == [("English", "/language en"), ("Deutsch", "/language de")]
        said = await ward.said("settings", "speed 1 m/s")
        assert said.startswith('No robot here is given a speed in "m/s".')


async def test_the_usual_robot_is_meant_when_none_is_chosen() -> None:
    async with a_ward() as ward:
        await ward.say("wave", account=BO, chat=BO)
        assert ward.acted() == 0
        await ward.said("settings", "robot omni", account=BO)
        await ward.say("wave", account=BO, chat=BO)
        assert ward.acted() == 1


# ---- shared data ----


async def test_data_is_kept_with_a_robot_by_whoever_has_it() -> None:
    async with a_ward() as ward:
        assert await ward.said("data", "omni", account=BO) == "omni keeps nothing yet."
        assert (await ward.said("data", "omni offset = 0.3", account=BO)).startswith(
            "Only whoever has omni now can keep data with it."
        )
        await ward.say("omni wave", account=BO, chat=BO)
        assert await ward.said("data", "omni offset = 0.3", account=BO) == "Data stored."
        await ward.clock.advance(61)
        assert await ward.said("data", "omni", account=VI) == (
            "omni keeps:\n  offset: 0.3 (Bo, 1 min ago)"
        )
        assert await ward.said("data", "omni x", account=VI) == 'omni keeps nothing called "x".'
        assert await ward.said("data", "omni offset =", account=ADA) == (
            "Only whoever has omni now can keep data with it. Nothing was kept."
        )


async def test_one_s_own_data_is_one_s_own() -> None:
    async with a_ward() as ward:
        assert await ward.said("data", "home = bay 4", account=BO) == "Data stored."
        assert await ward.said("data", account=BO) == (
            "Your container keeps:\n  home: bay 4 (Bo, 0 s ago)"
        )
        assert "bay 4" not in await ward.said("data", account=ADA)
        assert (await ward.said("data", ward.id_of(BO), account=ADA)).startswith("Write /data and")
        assert "private chat" in await ward.said("data", account=BO, kind=GROUP)
        assert await ward.said("data", "home =", account=BO) == "Data removed."
        assert await ward.said("data", account=BO) == "Your container keeps nothing yet."


# ---- archives ----


async def test_an_admin_decides_everybody_may_ask_and_the_chat_is_told() -> None:
    async with a_ward() as ward:
        only = "Only an admin decides whether messages are kept, and takes them out."
        assert await ward.said("archive", "on", account=BO, kind=GROUP) == only
        assert await ward.said("archive", account=BO, kind=GROUP) == (
            "The messages of this chat are not kept."
        )
        assert await ward.said("archive", "on 30 days", kind=GROUP) == (
            "From now on the messages of this chat are kept for 30 days: Ada decided so. Everybody "
            "here may ask with /archive. They are sealed; what I write is kept, too."
        )
        ward.chat.say("omni wave", account=BO, chat="g", kind=GROUP)
        await ward.quiet()
        said = await ward.said("archive", account=BO, kind=GROUP)
        assert said.startswith("The messages of this chat are kept since 22:13, for 30 days: Ada")
        assert "Kept now: 2 entries, " in said
        for word in ("off", "erase", "export"):
            assert await ward.said("archive", word, account=BO, kind=GROUP) == only
        text = await ward.file("archive", "export", kind=GROUP)
        assert text.splitlines()[0] == "Sender ID: 2, Sender Username: Bo, Message: omni wave"
        assert text.splitlines()[1].startswith("Sender ID: rosic, Sender Username: ROSIC")
        assert '"text":"omni wave"' in await ward.file("archive", "export jsonl", kind=GROUP)
        assert '"text":"omni wave"' in await ward.file("archive", "exportieren jsonl", kind=GROUP)
        book = (await ward.ask("archive", "export xlsx", kind=GROUP)).attachment
        assert book is not None
        assert (book.name, book.content[:2]) == ("messages.xlsx", b"PK")
        ward.chat.file_bytes = 0
        later = await ward.said("archive", "export xlsx", kind=GROUP)
        assert later.startswith("A spreadsheet cannot be sent in a message. The operator can make")
        assert re.search(r": rosic container export chat-[0-9a-f]{32} --as xlsx$", later)
        assert await ward.said("archive", "off", kind=GROUP) == (
            "From now on the messages of this chat are not kept: Ada decided so. "
            "Those kept before go after 30 days; /archive erase erases them at once."
        )
        assert "2 entries of before are left" in await ward.said("archive", kind=GROUP)


async def test_an_archive_is_erased_after_one_question() -> None:
    async with a_ward() as ward:
        await ward.said("archive", "on 1 day")
        ward.chat.say("a thing", account=ADA, chat=ADA)
        await ward.quiet()
        reply = await ward.ask("archive", "erase")
        assert reply.text == "Shall every message of this chat that is kept be erased?"
        assert [b.label for row in reply.buttons for b in row] == ["Erase them", "Leave it"]
        assert "a thing" in await ward.file("archive", "export")
        assert (await ward.sure("archive", "erase")).startswith("Every message of this")
        assert await ward.said("archive", "export") == "No message of this chat is kept."
        assert await ward.said("archive", "erase") == (
            "The messages of this chat are not being kept."
        )


@pytest.mark.parametrize(
    "rest",
    ["on soon", "on 3 weeks", "on ² days", "off now", "burn", "export pdf", "export text now"],
)
async def test_what_no_archive_can_do(rest: str) -> None:
    async with a_ward() as ward:
        assert (await ward.said("archive", rest)).startswith("Write /archive on, ")
        assert await ward.said("archive", "on 0 days") == (
            "Messages can be kept from 1 to 3650 days. Nothing has changed."
        )


async def test_a_long_archive_shows_its_newest_lines_and_who_has_the_rest() -> None:
    async with a_ward() as ward:
        await ward.said("archive", "on")
        ward.chat.file_bytes = 0
        for n in range(60):
            ward.chat.say(f"{n} " + "x" * 200, account=ADA, chat=ADA)
            await ward.quiet()
        text = await ward.said("archive", "export")
        assert len(text) < 3_900
        assert text.startswith("I cannot send files here, so this is what fits into a message:\n")
        assert "lines are too much for a message. The operator can give you all: rosic" in text
        assert "59 xxx" in text


async def test_secrets_that_pass_are_not_kept() -> None:
    async with a_ward() as ward:
        await ward.said("archive", "on")
        for secret in (
            "/code 123456",
            "/code@lab_bot 123456",
            "/code\t123456",
            "hello\n/code 123456",
            "/authenticator 123456",
            "/authenticator",
        ):
            ward.chat.say(secret, account=ADA, chat=ADA)
        await ward.quiet()
        assert any("otpauth://" in told.outbound.text for told in ward.chat.told)
        text = await ward.file("archive", "export")
        assert "123456" not in text
        assert "otpauth" not in text
        for kept in (
            "/code (not kept)",
            "/code@lab_bot (not kept)",
            "hello",
            "/authenticator (not",
        ):
            assert kept in text


async def test_no_code_of_an_invitation_is_kept() -> None:
    async with Place().open() as place:
        await place.say("/archive on", chat=ADA)
        await place.say("/invite viewer for 2h", chat=ADA)
        found = None
        for _ in range(30_000):  # a thread draws the picture of its link
            found = CODE.search("\n".join(told.outbound.text for told in place.chat.told))
            if found is not None:
                break
            await asyncio.sleep(0.001)
        assert found is not None
        await place.say(f"wave-left {found[0]} to-right", chat=ADA)
        bare, spaced = found[0].replace("-", ""), found[0].replace("-", " \u2011 ")
        await place.say(f"It is\njoin{bare}, or _{spaced}_ now", chat=ADA)
        await place.say("/archive export", chat=ADA)
        file = None
        for _ in range(30_000):  # a thread makes the file
            file = place.chat.told[-1].outbound.attachment
            if file is not None:
                break
            await asyncio.sleep(0.001)
        assert file is not None
        content = file.content.decode()
        assert found[0] not in content
        assert bare not in content
        assert found[0][:4] not in content
        assert "Code (not kept), good once" in content
        assert "wave-left (not kept) to-right" in content
        assert "join(not kept), or _(not kept)_ now" in content
