"""What people do in Telegram, as it is handed over."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.message import Button, ChatEventKind, ChatKind, Inbound, MessageValidity
from rosic.errors import MessageGone
from tests.pace import patience
from tests.real.telegram.gateway import Gateway, is_backlog, to

if TYPE_CHECKING:
    from rosic.testing.telegram import FakeTelegram

MOVE = Button("Move", "omni move 1 m", "n-move")
STOP = Button("STOP", "stop", "n-7")
STOP_OMNI = Button("STOP omni", "", "stop omni")


async def test_messages_in_every_standing(server: FakeTelegram, gateway: Gateway, ada: int) -> None:
    lab = server.create_chat("supergroup", "Lab", members=[ada])
    news = server.create_chat("channel", "News", members=[ada], bot="administrator")
    async with gateway.listening():
        message = server.say(lab, ada, "omni move 1 m")
        server.edit(lab, message, "omni move 2 m")
        server.say(lab, ada, "omni move 3 m", forward_origin=ada)
        server.say(lab, ada, "omni move 4 m", via_bot=True)
        server.say(lab, ada, "omni move 5 m", sender_chat=lab)
        server.say(news, None, "omni move 6 m")
        heard = await gateway.hear(6)
    heard = sorted(heard, key=lambda inbound: inbound.chat.kind is ChatKind.CHANNEL)  # side by side
    assert [inbound.standing for inbound in heard] == [
        MessageValidity.FRESH,
        MessageValidity.EDITED,
        MessageValidity.FORWARDED,
        MessageValidity.VIA_BOT,
        MessageValidity.ANONYMOUS,
        MessageValidity.CHANNEL,
    ]
    assert heard[0].message == heard[1].message
    assert [inbound.chat.kind for inbound in heard] == [ChatKind.GROUP] * 5 + [ChatKind.CHANNEL]
    assert heard[0].sender.account == str(ada)
    assert heard[4].sender.account != str(ada)
    assert gateway.messenger.counts["received"] == 6


async def test_posts_of_the_linked_channel_are_nobodys(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    lab = server.create_chat("supergroup", "Lab", members=[ada])
    news = server.create_chat("channel", "News", members=[ada], bot=None)
    server.link(news, lab)
    async with gateway.listening():
        server.say(news, None, "stop")
        heard = await gateway.hear(1)
    assert (heard[0].standing, heard[0].sender.account) == (MessageValidity.CHANNEL, "777000")


async def test_a_caption_counts(server: FakeTelegram, gateway: Gateway, ada: int) -> None:
    async with gateway.listening():
        server.send_file(ada, ada, "a.txt", b"x")
        server.say(ada, ada, "status")
        await gateway.hear(2)
    assert gateway.texts == ["", "status"], "a file is told of, and says nothing by itself"
    assert gateway.messenger.counts["passed-over"] == 0


async def test_only_what_is_read_is_asked_for(gateway: Gateway) -> None:
    async with gateway.listening():
        pass
    read = ["message", "edited_message", "channel_post", "edited_channel_post", "callback_query"]
    read += ["my_chat_member", "chat_member", "message_reaction"]
    assert gateway.given("getUpdates", "allowed_updates") == [read] * len(
        gateway.calls("getUpdates")
    )
    assert gateway.calls("deleteWebhook") == []


async def test_a_tap(server: FakeTelegram, gateway: Gateway, ada: int) -> None:
    async with gateway.listening():
        sent = await gateway.messenger.send(to(ada, "omni", buttons=((MOVE, STOP),)))
        press = server.tap(ada, ada, int(sent), "Move")
        (inbound,) = await gateway.hear(1)
        assert (inbound.nonce, inbound.text, inbound.under) == ("n-move", "", sent)
        assert (inbound.message, inbound.sender.account) == (press, str(ada))
        await gateway.messenger.answer_tap(inbound, "Moving.")
        await gateway.messenger.answer_tap(inbound, "x" * 500)
    first, second = server.press(press)["answers"]
    assert first["text"] == "Moving."
    assert len(second["text"]) == 200


async def test_a_stop_in_a_batch_comes_first_typed_or_tapped(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    async with gateway.listening():
        sent = await gateway.messenger.send(to(ada, "omni", buttons=((MOVE, STOP, STOP_OMNI),)))
    server.backlog(ada, ada, "omni move {n} cm", 50)
    server.tap(ada, ada, int(sent), "Move")
    server.tap(ada, ada, int(sent), "STOP")
    server.tap(ada, ada, int(sent), "STOP omni")
    server.say(ada, ada, "Stopp omni!")
    async with gateway.running():
        heard = await gateway.hear(54)
    assert [inbound.nonce or inbound.text for inbound in heard[:4]] == [
        "n-7",
        "stop omni",
        "Stopp omni!",
        "omni move 1 cm",
    ]
    assert gateway.texts[3:53] == [f"omni move {n} cm" for n in range(1, 51)]


async def test_duplicates_jumps_and_reversed_answers(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    async with gateway.listening():
        server.reorder()
        server.backlog(ada, ada, "first {n}", 2)
        server.duplicate()
        server.say(ada, ada, "first 3")
        server.duplicate(new_id=True)
        server.say(ada, ada, "first 4")
        heard = await gateway.hear(5)
        assert gateway.texts == ["first 1", "first 2", "first 3", "first 4", "first 4"]
        assert heard[3].message == heard[4].message
        await gateway.until(lambda: server.pending() == 0)
        for number, start in enumerate((500, 900_000_000, 7)):
            server.jump(start)
            server.say(ada, ada, f"jump {number}")
            await gateway.hear(6 + number)
            await gateway.until(lambda: server.pending() == 0)
    assert gateway.texts[5:] == ["jump 0", "jump 1", "jump 2"]


async def test_malformed_updates_are_counted_and_passed_over(
    server: FakeTelegram, gateway: Gateway, ada: int, caplog: pytest.LogCaptureFixture
) -> None:
    async with gateway.listening():
        server.put_update("message", {"message_id": "seven", "text": "private words"})
        server.put_update("callback_query", {})
        server.put_update("message", {})
        server.say(ada, ada, "status")
        await gateway.hear(1)
        await gateway.until(lambda: server.pending() == 0)
    assert gateway.texts == ["status"]
    assert gateway.messenger.counts["malformed"] == 3
    assert "private words" not in caplog.text


async def test_a_group_that_moves_is_answered_where_it_is_now(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    group = server.create_chat("group", "Lab", members=[ada])
    async with gateway.listening():
        new = server.migrate(group)
        server.say(new, ada, "hello")
        await gateway.hear(1)
        await gateway.messenger.send(to(group, "omni: done"))
    assert [one["text"] for one in server.messages(new, by_bot=True)] == ["omni: done"]
    assert len(gateway.calls("sendMessage")) == 1


async def test_a_group_that_moved_unseen_is_found_by_sending(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    group = server.create_chat("group", "Lab", members=[ada])
    new = server.migrate(group)
    await gateway.messenger.send(to(group, "omni: done"))
    await gateway.messenger.send(to(group, "omni: done again"))
    assert len(server.messages(new, by_bot=True)) == 2
    assert [call["code"] for call in gateway.calls("sendMessage")] == [400, 200, 200]


@pytest.mark.parametrize("seen", [True, False], ids=["seen", "unseen"])
async def test_what_stayed_behind_when_a_group_moved_changes_nothing_where_it_is_now(
    server: FakeTelegram, gateway: Gateway, ada: int, seen: bool
) -> None:
    group = server.create_chat("group", "Lab", members=[ada])
    await gateway.messenger.send(to(group, "hello"))
    behind = await gateway.messenger.send(to(group, "omni: 20 %"))
    new = server.migrate(group)
    async with gateway.listening():
        if seen:
            server.say(new, ada, "hello")
            await gateway.hear(1)
        while int(await gateway.messenger.send(to(new, "done"))) < int(behind):
            pass
        edited = to(group, "omni: 40 %")
        for change in (
            gateway.messenger.edit(behind, edited),
            gateway.messenger.pin(edited.chat, behind, pinned=True),
            gateway.messenger.retract(edited.chat, behind),
        ):
            with pytest.raises(MessageGone):
                await change
        later = await gateway.messenger.send(replace(edited, reply_to=behind))
        await gateway.messenger.edit(later, to(group, "omni: done"))
    moves = [
        (one.chat.id, one.new_id) for one in gateway.passings if one.what is ChatEventKind.MOVED
    ]
    assert moves == [(str(group), str(new))], "told once, whichever way it was found"
    texts = [one["text"] for one in server.messages(new, by_bot=True)]
    assert set(texts[:-1]) == {"done"}
    assert texts[-1] == "omni: done"
    last = server.messages(new, by_bot=True)[-1]
    assert last["reply_to"] is None
    assert not any(one["pinned"] or one["deleted"] for one in server.messages(new, by_bot=True))


async def test_a_slow_chat_holds_up_no_other(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    bob = server.create_user("Bob")
    gate = asyncio.Event()

    async def receive(inbound: Inbound) -> None:
        gateway.heard.append(inbound)
        if inbound.sender.account == str(ada):
            await gate.wait()

    gateway.receive = receive  # type: ignore[method-assign]
    async with gateway.listening():
        server.backlog(ada, ada, "slow {n}", 2)
        server.backlog(bob, bob, "quick {n}", 3)
        await gateway.hear(4)
        assert sorted(gateway.texts) == ["quick 1", "quick 2", "quick 3", "slow 1"]
        await gateway.until(lambda: server.pending() == 5)
        gate.set()
        await gateway.hear(5)
        await gateway.until(lambda: server.pending() == 0)


async def test_a_thousand_messages_of_backlog_are_drained_quickly_and_in_order(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    server.backlog(ada, ada, "omni move {n} cm", 1_000, age_s=600)
    began_s = time.monotonic()
    async with gateway.listening():
        server.say(ada, ada, "status")
        await gateway.hear(1_001)
    assert (
        time.monotonic() - began_s < 6 * patience()
    )  # 100,000 in 60 s would take 0.6 s; the machine is shared
    assert gateway.texts[:1000] == [f"omni move {n} cm" for n in range(1, 1001)]
    assert all(is_backlog(inbound) for inbound in gateway.heard[:1000])
    assert not is_backlog(gateway.heard[1000])
