"""A phone as a second step, set up and proven in a chat."""

from __future__ import annotations

from base64 import b32decode

from rosic.authoriser import keys_messages, two_factor
from rosic.authoriser.invite_codes import qr_png
from rosic.core.message import Chat, ChatKind
from rosic.features.access import access_messages
from rosic.gateway.commands import ONLY_IN_PRIVATE
from rosic.stores.memory import MemoryStore
from tests.features.access.access_handlers import ADA, BO, CY, BrokenStore, Hall, a_hall

LOCKED = "Your access is locked. Ask an admin."


def secret_in(said: str) -> bytes:
    key = said.partition("Or type this key there: ")[2].splitlines()[0].replace(" ", "")
    return b32decode(key + "=" * (-len(key) % 8))


def code_now(hall: Hall, secret: bytes) -> str:
    return two_factor.hotp(secret, two_factor.step_at(hall.time.wall_ns()))


async def set_up(hall: Hall, account: str = CY) -> bytes:
    secret = secret_in(await hall.say(account, "/authenticator"))
    said = await hall.say(account, f"/code {code_now(hall, secret)}")
    assert said == "Your phone is set up. I ask for a code before dangerous things."
    return secret


def fresh(hall: Hall, chat: str = CY, kind: ChatKind = ChatKind.PRIVATE) -> bool:
    return hall.two_factor.fresh("p-3", Chat(hall.chat.platform, chat, kind))


async def test_a_phone_is_set_up_by_a_link_and_its_first_code() -> None:
    async with a_hall() as hall:
        said = await hall.say(CY, "/authenticator")
        lines = said.splitlines()
        assert lines[0] == "On the phone with your authenticator app, tap this link:"
        assert lines[1].startswith("otpauth://totp/")
        assert lines[2].startswith("Or type this key there: ")
        assert lines[3].startswith("Then send me the six digits that it shows, so: /code 123456.")
        assert "█" not in said
        picture = hall.last(CY).attachment
        assert picture is not None
        assert (picture.media_type, picture.content) == ("image/png", qr_png(lines[1]))
        assert lines[4] == access_messages.SCAN
        assert not hall.two_factor.is_set_up("p-3")
        code = code_now(hall, secret_in(said))
        assert await hall.say(CY, f"/code {code[:3]} {code[3:]}") == keys_messages.PHONE_READY
        assert hall.two_factor.is_set_up("p-3")
        assert fresh(hall)
        assert access_messages.PHONE_PROVEN in await hall.say(CY, "/me")
        await hall.clock.advance(3_601.0)
        assert access_messages.PHONE_SET_UP in await hall.say(CY, "/me")


async def test_a_code_is_good_once_and_proves_one_chat() -> None:
    async with a_hall() as hall:
        secret = await set_up(hall)
        code = code_now(hall, secret)
        assert await hall.say(CY, f"/code {code}") == (
            "This code was used before. Wait for the next one. Nothing was done."
        )
        await hall.clock.advance(3_601.0)
        assert not fresh(hall)
        code = code_now(hall, secret)
        assert await hall.in_group(CY, f"/code {code}") == (
            "Thank you. I ask again after an hour without use."
        )
        assert fresh(hall, "g", ChatKind.GROUP)
        assert not fresh(hall)


async def test_what_is_said_to_a_code_that_is_none() -> None:
    async with a_hall() as hall:
        assert await hall.say(CY, "/code 123456") == keys_messages.NOT_SET_UP
        await set_up(hall)
        for line in ("/code", "/code 12345", "/code abcdef"):
            assert await hall.say(CY, line) == (
                "A code is six digits, as your authenticator app shows them."
            )
        for _ in range(5):
            assert await hall.say(CY, "/code 000000") == "This code is not right. Nothing was done."
        assert await hall.say(CY, "/code 000000") == (
            "Too many wrong codes. Try again in 15 minutes. Nothing was done."
        )


async def test_setting_up_is_private_and_needs_the_old_phone() -> None:
    async with a_hall() as hall:
        assert await hall.in_group(CY, "/authenticator") == keys_messages.PRIVATE_ONLY
        assert hall.counters["totp-in-group"] == 1
        old = await set_up(hall)
        await hall.clock.advance(3_601.0)
        assert await hall.say(CY, "/authenticator") == keys_messages.PROVE_FIRST
        await hall.say(CY, f"/code {code_now(hall, old)}")
        await hall.clock.advance(31.0)
        new = secret_in(await hall.say(CY, "/authenticator"))
        # Meanwhile the old phone still proves in a group.
        assert await hall.in_group(CY, f"/code {code_now(hall, old)}") == keys_messages.CODE_TAKEN
        await hall.clock.advance(31.0)
        assert await hall.say(CY, f"/code {code_now(hall, new)}") == keys_messages.PHONE_READY


async def test_a_set_up_that_waited_too_long() -> None:
    async with a_hall() as hall:
        secret = secret_in(await hall.say(CY, "/authenticator"))
        await hall.clock.advance(601.0)
        assert await hall.say(CY, f"/code {code_now(hall, secret)}") == keys_messages.NOT_SET_UP


async def test_a_code_that_cannot_be_written_does_not_count() -> None:
    store = BrokenStore()
    async with a_hall(store) as hall:
        secret = await set_up(hall)
        await hall.clock.advance(3_601.0)
        store.broken = True
        code = code_now(hall, secret)
        assert await hall.say(CY, f"/code {code}") == keys_messages.CODE_NOT_WRITTEN
        assert not fresh(hall)
        store.broken = False
        assert await hall.say(CY, f"/code {code}") == keys_messages.USED_CODE


async def test_a_used_code_stays_used_over_a_restart() -> None:
    store = MemoryStore()
    async with a_hall(store) as hall:
        secret = await set_up(hall)
        clock = hall.clock
    async with Hall(store, clock=clock, seed=1).open() as again:
        code = code_now(again, secret)
        assert await again.say(CY, f"/code {code}") == keys_messages.USED_CODE
        assert not fresh(again)


async def test_the_terminal_draws_the_picture() -> None:
    async with a_hall(platform="terminal", assurance="local") as hall:
        assert "█" in await hall.say(CY, "/authenticator")


async def test_an_admin_forgets_a_lost_phone_but_not_their_own() -> None:
    async with a_hall() as hall:
        await set_up(hall)
        assert await hall.say(CY, "/authenticator reset Ada") == (
            "Looking after people is for admins. Ada or Bo can. Nothing was done."
        )
        assert await hall.in_group(ADA, "/authenticator reset Cy Young") == ONLY_IN_PRIVATE
        assert await hall.say(ADA, "/authenticator reset") == access_messages.HOW_TO_RESET
        assert await hall.say(ADA, "/authenticator reset Cy Young") == (
            "The phone of Cy Young is forgotten. They can set up another with /authenticator."
        )
        assert hall.last(CY).text == (
            "Ada reset your authenticator. /authenticator sets up another phone."
        )
        assert not hall.two_factor.is_set_up("p-3")
        assert not fresh(hall)
        assert await hall.say(ADA, "/authenticator reset Cy Young") == (
            "No phone is set up for this person. Nothing was done."
        )
        assert await hall.say(BO, "/authenticator reset Bo") == keys_messages.OWN_RESET


async def test_somebody_locked_proves_nothing() -> None:
    async with a_hall() as hall:
        secret = await set_up(hall)
        await hall.say(ADA, "/lock Cy Young")
        await hall.clock.advance(31.0)
        assert await hall.say(CY, f"/code {code_now(hall, secret)}") == LOCKED
        assert await hall.say(CY, "/authenticator") == LOCKED
