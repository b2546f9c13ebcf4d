"""What people read in Telegram, and what happens when it cannot be sent."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING

import pytest

from rosic.core.message import Button, Chat, Outbound, SendPriority
from rosic.errors import MessageGone, MessengerFault
from rosic.messengers.telegram.bot_client import BotClient
from rosic.messengers.telegram.errors import ErrorKind, TelegramError
from rosic.messengers.telegram.settings import read_settings
from rosic.testing.telegram import FakeTelegram
from tests.pace import patience
from tests.real.telegram.gateway import Gateway, to

if TYPE_CHECKING:
    from typing import Any

MOVE = Button("Move", "omni move 1 m", "n" * 64)
LONG = "\n".join(f"robot{number}: at rest" for number in range(500))


def shown(server: FakeTelegram, chat: int) -> list[dict[str, Any]]:
    return [one for one in server.messages(chat, by_bot=True) if not one["deleted"]]


async def test_a_message_is_plain_and_answers_what_was_asked(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    asked = server.say(ada, ada, "omni move 1 m")
    sent = await gateway.messenger.send(
        to(ada, "omni_1 <b> http://example.org", reply_to=str(asked), buttons=((MOVE,),))
    )
    (seen,) = shown(server, ada)
    assert (str(seen["message_id"]), seen["text"], seen["reply_to"]) == (
        sent,
        "omni_1 <b> http://example.org",
        asked,
    )
    assert seen["callback_data"] == ["n" * 64]
    (call,) = gateway.calls("sendMessage")
    assert "parse_mode" not in call["parameters"]
    assert gateway.given("sendMessage", "link_preview_options") == [{"is_disabled": True}]


async def test_an_answer_to_what_is_gone_arrives_all_the_same(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    for reply_to in ("99999", "5000000000000000001", "tap-1", ""):
        await gateway.messenger.send(to(ada, "omni: done", reply_to=reply_to))
    assert [one["reply_to"] for one in shown(server, ada)] == [None] * 4


async def test_half_characters_do_not_break_it(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    await gateway.messenger.send(to(ada, "omni \ud83e said \x07 hi"))
    assert "omni \ufffd said" in shown(server, ada)[0]["text"]


async def test_an_edit_in_place_and_the_same_again(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    sent = await gateway.messenger.send(to(ada, "omni: sent", buttons=((MOVE,),)))
    await gateway.messenger.edit(sent, to(ada, "omni: done"))
    await gateway.messenger.edit(sent, to(ada, "omni: done"))
    (seen,) = shown(server, ada)
    assert (seen["text"], seen["buttons"], len(seen["versions"])) == ("omni: done", [], 2)
    assert gateway.calls("editMessageText")[-1]["code"] == 400  # not modified: that is a success


async def test_what_cannot_be_edited_or_sent_says_why(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    asked = server.say(ada, ada, "hello")
    bob = server.create_user("Bob", started=False)
    for call in (
        gateway.messenger.edit("99999", to(ada, "omni: done")),
        gateway.messenger.edit(str(asked), to(ada, "omni: done")),
        gateway.messenger.edit("not a number", to(ada, "omni: done")),
        gateway.messenger.send(to(bob, "hello")),
        gateway.messenger.send(to(404, "hello")),
        gateway.messenger.send(to(ada, "   ")),
        gateway.messenger.send(Outbound(chat=Chat("telegram", "@lab"), text="hello")),
        gateway.messenger.send(to(ada, "x", buttons=((Button("No nonce", "stop"),),))),
        gateway.messenger.send(to(ada, "x", buttons=((Button("Long", "stop", "n" * 65),),))),
    ):
        with pytest.raises(MessengerFault):
            await call
    assert shown(server, ada) == []


async def test_a_message_that_was_deleted_is_gone(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    server.say(ada, ada, "hello")
    sent = await gateway.messenger.send(to(ada, "omni: sent"))
    server.delete(ada, int(sent))
    with pytest.raises(MessageGone):
        await gateway.messenger.edit(sent, to(ada, "omni: done"))


async def test_a_long_text_whose_parts_are_too_old_to_be_taken_away_is_gone(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    server.say(ada, ada, "hello")
    last = await gateway.messenger.send(to(ada, LONG))
    server.advance(49 * 3600)
    with pytest.raises(MessageGone):
        await gateway.messenger.edit(last, to(ada, "nothing"))


async def test_a_long_text_goes_in_parts_and_is_edited_in_parts(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    outbound = to(ada, LONG, buttons=((MOVE,),), reply_to=str(server.say(ada, ada, "status")))
    last = await gateway.messenger.send(outbound)
    parts = shown(server, ada)
    assert "\n".join(one["text"] for one in parts) == LONG
    assert len(parts) == 3
    assert [bool(one["buttons"]) for one in parts] == [False, False, True]
    assert [one["reply_to"] is None for one in parts] == [False, True, True]
    assert last == str(parts[-1]["message_id"])

    gateway.let_pass(60)
    await gateway.messenger.edit(last, to(ada, LONG.replace("at rest", "stopped")))
    assert "\n".join(one["text"] for one in shown(server, ada)) == LONG.replace(
        "at rest", "stopped"
    )
    gateway.let_pass(60)
    await gateway.messenger.edit(last, to(ada, "nothing"))
    assert [(str(one["message_id"]), one["text"]) for one in shown(server, ada)] == [
        (last, "nothing")
    ]
    with pytest.raises(MessengerFault, match="too long"):
        await gateway.messenger.edit(last, to(ada, LONG))


async def test_the_published_limits_are_never_reached() -> None:
    async with FakeTelegram() as strict:
        ada, bob = strict.create_user("Ada"), strict.create_user("Bob")
        gateway = Gateway(strict)
        await asyncio.gather(
            *[
                gateway.messenger.send(to(chat, f"{number}"))
                for number in range(6)
                for chat in (ada, bob)
            ]
        )
        assert {call["code"] for call in gateway.calls("sendMessage")} == {200}
        assert strict.violations == []


@pytest.mark.parametrize("run", ["the first", "after another"])
async def test_forty_answers_at_once_are_refused_not_once(run: str) -> None:
    """Of a server that counts any second, and of a bot that has just been started anew."""
    async with FakeTelegram() as strict:
        people = [strict.create_user(f"P{number}") for number in range(40)]
        runs = [Gateway(strict)] if run == "the first" else [Gateway(strict), Gateway(strict)]
        for gateway in runs:
            gateway.clock.hurry = 1.0
        for gateway in runs:
            some = people if gateway is runs[-1] else people[:20]
            await asyncio.gather(*(gateway.messenger.send(to(one, "omni: done")) for one in some))
            restarted = Gateway(strict)
            restarted.clock.hurry = 1.0
            runs[-1] = runs[-1] if gateway is runs[-1] else restarted
        calls = strict.calls
        assert [call["code"] for call in calls if call["code"] != 200] == []
        assert strict.violations == []


async def test_a_gesture_waits_where_telegram_asked_to_wait(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    asked = server.say(ada, ada, "omni move 1 m")
    server.fail("too_many_requests", "sendMessage", times=1, chat_id=ada, retry_after_s=1)
    sending = asyncio.create_task(gateway.messenger.send(to(ada, "omni: done")))
    await gateway.until(lambda: gateway.messenger._speaker._limiter._held_ns)
    await gateway.messenger.react(to(ada, "").chat, str(asked), "\N{THUMBS UP SIGN}")
    await sending
    refused, *_ = gateway.calls("sendMessage")
    (reacted,) = gateway.calls("setMessageReaction")
    assert reacted["time_s"] - refused["time_s"] >= 1.0


async def test_retry_after_is_obeyed_to_the_end(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    bob = server.create_user("Bob")
    server.fail("too_many_requests", "sendMessage", times=1, chat_id=ada, retry_after_s=1)
    held = asyncio.create_task(gateway.messenger.send(to(ada, "held")))
    await gateway.until(lambda: gateway.calls("sendMessage"))
    await gateway.messenger.send(to(bob, "free"))
    assert not held.done()
    await held
    first, free, last = gateway.calls("sendMessage")
    assert (first["code"], free["code"], last["code"]) == (429, 200, 200)
    assert last["time_s"] - first["time_s"] >= 1.0
    assert [call["parameters"]["text"] for call in (first, free, last)] == ["held", "free", "held"]


async def test_what_certainly_did_not_arrive_is_sent_again() -> None:
    before = FakeTelegram(limits=None)
    await before.start()
    await before.stop()
    gateway = Gateway(before)
    gateway.clock.hurry = 4
    sending = asyncio.create_task(gateway.messenger.send(to(7_000_000_001, "omni: done")))
    await asyncio.sleep(0.1)
    async with FakeTelegram(limits=None, port=before.port) as server:
        ada = server.create_user("Ada")
        assert ada == 7_000_000_001
        await sending
        assert [one["text"] for one in shown(server, ada)] == ["omni: done"]


async def test_nobody_there_ends_in_a_fault_and_says_that_nothing_was_sent() -> None:
    before = FakeTelegram(limits=None)
    await before.start()
    await before.stop()
    gateway = Gateway(before)
    with pytest.raises(MessengerFault, match="Nothing was sent"):
        await gateway.messenger.send(to(1, "omni: done"))


@pytest.mark.parametrize(
    ("fault", "arrives"),
    [("reset", 0), ("drop_answer", 1), ("truncated", 1), ("bad_gateway", 0)],
)
async def test_what_may_have_arrived_is_not_sent_again(
    server: FakeTelegram, gateway: Gateway, ada: int, fault: str, arrives: int
) -> None:
    server.fail(fault, "sendMessage")
    with pytest.raises(MessengerFault, match="may or may not"):
        await gateway.messenger.send(to(ada, "omni: done"))
    assert len(gateway.calls("sendMessage")) == 1
    assert len(shown(server, ada)) == arrives


@pytest.mark.parametrize("fault", ["reset", "drop_answer", "truncated", "bad_gateway"])
async def test_an_edit_is_tried_again_because_twice_is_the_same_as_once(
    server: FakeTelegram, gateway: Gateway, ada: int, fault: str
) -> None:
    sent = await gateway.messenger.send(to(ada, "omni: sent"))
    server.fail(fault, "editMessageText", times=2)
    await gateway.messenger.edit(sent, to(ada, "omni: done"))
    assert [one["text"] for one in shown(server, ada)] == ["omni: done"]


async def test_every_call_is_bounded_in_time(server: FakeTelegram) -> None:
    settings = read_settings("lab", {"token": server.token, "api_base": server.api_base})
    server.fail("hang", "getMe", times=3, seconds=30)
    began_s = time.monotonic()
    with pytest.raises(TelegramError) as raised:
        await BotClient(settings, answer_s=0.2).ask(lambda bot: bot.get_me())
    assert raised.value.kind is ErrorKind.LOST
    with pytest.raises(TelegramError):
        await BotClient(settings).ask(lambda bot: bot.get_me(), within_s=0.2)
    assert time.monotonic() - began_s < 3 * patience()


async def test_an_urgent_message_overtakes_what_waits(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    waiting = [
        asyncio.create_task(gateway.messenger.send(to(ada, f"card {number}")))
        for number in range(20)
    ]
    await gateway.until(lambda: len(shown(server, ada)) >= 3)
    before = len(shown(server, ada))
    await gateway.messenger.send(to(ada, "STOP: omni at rest (0.1 s)", weight=SendPriority.STOP))
    texts = [message["text"] for message in shown(server, ada)]
    # One card may be on its way already; the others wait a second each.
    assert texts.index("STOP: omni at rest (0.1 s)") <= before + 1 < len(waiting)
    for task in waiting:
        task.cancel()
    await asyncio.gather(*waiting, return_exceptions=True)


async def test_a_message_sent_while_not_running_leaves_no_connection(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    await gateway.messenger.send(to(ada, "the last words"))
    line = gateway.messenger._speaker._line
    assert (line._bot, line._requests, line._users) == (None, (), 0)
    assert len(shown(server, ada)) == 1
