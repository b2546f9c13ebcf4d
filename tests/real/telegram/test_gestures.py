"""Over the wire: reactions of people and of the bot, and messages taken away."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.core.identity import Address
from rosic.core.message import Chat, ChatKind, Reaction
from rosic.errors import MessageGone, MessengerFault
from tests.real.telegram.gateway import to

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.testing.telegram import FakeTelegram
    from tests.real.telegram.gateway import Gateway

TWO_DAYS_S = 48 * 3600


def _listen(gateway: Gateway) -> list[Reaction]:
    found: list[Reaction] = []
    gateway.messenger.watch_reactions(found.append)
    return found


async def test_who_looks_after_a_group_is_told_whoever_stays_anonymous(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    bo = server.create_user("Bo")
    lab = server.create_chat("supergroup", "Lab", members=[ada, bo])
    server.set_member(lab, ada, "administrator")
    found = await gateway.messenger.admins(Chat("telegram", str(lab), ChatKind.GROUP))
    assert Address("telegram", str(ada)) in found
    assert Address("telegram", str(bo)) not in found
    with pytest.raises(MessengerFault):
        await gateway.messenger.admins(Chat("telegram", "-100777", ChatKind.GROUP))


async def test_reactions_are_heard_and_name_who_put_them_there(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    heard = _listen(gateway)
    lab = server.create_chat("supergroup", "Lab", members=[ada], bot="administrator")
    async with gateway.listening():
        number = int(await gateway.messenger.send(to(ada, "alarm")))
        server.react(ada, ada, number, "👍")
        server.react(ada, ada, number, "👍", "🔥")
        server.react(ada, ada, number)
        server.react(lab, ada, server.say(lab, ada, "x"), "👍", anonymous=True)
        server.say(ada, ada, "status")
        await gateway.until(lambda: "status" in gateway.texts)
    private = Chat("telegram", str(ada))
    assert [(one.chat.id, str(one.who), one.emoji) for one in heard] == [
        (private.id, f"telegram:{ada}", ("👍",)),
        (private.id, f"telegram:{ada}", ("🔥",)),
        (str(lab), "None", ("👍",)),
    ]
    assert heard[0].message == str(number)
    assert gateway.texts == ["x", "status"], "a reaction is no message"


async def test_whoever_watches_and_fails_stops_nobody(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    def fails(_reaction: Reaction) -> None:
        raise RuntimeError("a fault")

    gateway.messenger.watch_reactions(fails)
    async with gateway.listening():
        server.react(ada, ada, int(await gateway.messenger.send(to(ada, "alarm"))), "👍")
        server.say(ada, ada, "stop")
        assert (await gateway.hear(1))[0].text == "stop"


async def test_the_bot_reacts_itself(server: FakeTelegram, gateway: Gateway, ada: int) -> None:
    chat = Chat("telegram", str(ada))
    number = server.say(ada, ada, "hello")
    await gateway.messenger.react(chat, str(number), "👌")
    assert list(server.message(ada, number)["reactions"].values()) == [["👌"]]
    for message, emoji in (("4711", "👌"), (str(number), "🤖"), ("nonsense", "👌")):
        with pytest.raises(MessengerFault):
            await gateway.messenger.react(chat, message, emoji)
    assert server.violations == []


async def _retract_old(server: FakeTelegram, gateway: Gateway, ada: int) -> None:
    number = server.say(ada, ada, "a code")
    server.advance(TWO_DAYS_S + 1)
    await gateway.messenger.retract(Chat("telegram", str(ada)), str(number))


async def _retract_of_others(server: FakeTelegram, gateway: Gateway, ada: int) -> None:
    lab = server.create_chat("supergroup", "Lab", members=[ada])
    number = server.say(lab, ada, "a code")
    await gateway.messenger.retract(Chat("telegram", str(lab), ChatKind.GROUP), str(number))


@pytest.mark.parametrize("never", [_retract_old, _retract_of_others])
async def test_what_can_never_be_taken_away_says_so(
    server: FakeTelegram, gateway: Gateway, ada: int, never: Callable[..., object]
) -> None:
    with pytest.raises(MessageGone):
        await never(server, gateway, ada)  # type: ignore[misc]


async def test_messages_of_both_are_taken_away_and_twice_is_once(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    chat = Chat("telegram", str(ada))
    theirs, long = server.say(ada, ada, "a code"), "secret " * 1_000
    ours = await gateway.messenger.send(to(ada, long))
    parts = [m["message_id"] for m in server.messages(ada, by_bot=True)]
    assert len(parts) == 2
    for _ in range(2):
        await gateway.messenger.retract(chat, str(theirs))
        await gateway.messenger.retract(chat, ours)
    assert all(server.message(ada, number)["deleted"] for number in (theirs, *parts))


async def test_what_fails_for_now_can_be_tried_again(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    chat, number = Chat("telegram", str(ada)), server.say(ada, ada, "a code")
    server.fail("bad_gateway", "deleteMessage", times=1)
    with pytest.raises(MessengerFault) as fault:
        await gateway.messenger.retract(chat, str(number))
    assert not isinstance(fault.value, MessageGone)
    await gateway.messenger.retract(chat, str(number))
    assert server.message(ada, number)["deleted"]
