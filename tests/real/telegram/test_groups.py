"""Groups over the wire: topics, coming and going, two bots in one group, menus."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.core.message import Chat, ChatEventKind, ChatKind, Menu, MenuScope
from rosic.errors import ChatGone, ChatNotBegun
from rosic.testing.telegram import FakeTelegram, Settings
from tests.real.telegram.gateway import Gateway, to

if TYPE_CHECKING:
    from rosic.core.message import Outbound

OTHER = "other_gateway_bot"


def _group(server: FakeTelegram, ada: int, **more: object) -> int:
    return server.create_chat("supergroup", "Lab", members=[ada], **more)  # type: ignore[arg-type]


def _in_topic(chat: int, topic: int, text: str) -> Outbound:
    return to(chat, text).__class__(
        chat=Chat("telegram", str(chat), ChatKind.GROUP, str(topic)), text=text
    )


async def test_an_answer_lands_in_the_topic_of_the_question(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    lab = _group(server, ada, topics=["Omni", "Kuka"])
    omni = server.topics(lab)["Omni"]
    async with gateway.listening():
        server.say(lab, ada, "status", thread=omni)
        server.say(lab, ada, "status")
        heard = await gateway.hear(2)
        assert [one.chat.topic for one in heard] == [str(omni), ""]
        sent = await gateway.messenger.send(to(lab, "here").__class__(chat=heard[0].chat, text="x"))
        assert server.message(lab, int(sent))["thread"] == omni


@pytest.mark.parametrize("ours", [True, False], ids=["ours", "another's"])
async def test_in_a_topic_that_a_bot_created_people_are_heard_as_anywhere(
    server: FakeTelegram, gateway: Gateway, ada: int, ours: bool
) -> None:
    other = server.create_user("Keeper", username="keeper_bot", is_bot=True)
    by = server.world.bot.id if ours else other
    lab = _group(server, ada, bot="administrator")
    omni = server.create_topic(lab, "Omni", by)
    async with gateway.listening():
        server.say(lab, ada, "omni move 1 m", thread=omni)
        sent = await gateway.messenger.send(_in_topic(lab, omni, "omni: done"))
        server.say(lab, ada, "again", thread=omni, reply_to=int(sent))
        first, second = await gateway.hear(2)
    assert (first.text, first.answers, first.addressed) == ("omni move 1 m", "", False)
    assert (second.text, second.answers, second.addressed) == ("again", sent, True)


async def test_a_topic_that_is_gone_is_answered_in_the_group(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    lab = _group(server, ada, topics=["Omni"])
    sent = await gateway.messenger.send(_in_topic(lab, 4711, "done"))
    assert server.message(lab, int(sent))["thread"] is None


async def test_coming_going_and_members(server: FakeTelegram, gateway: Gateway, ada: int) -> None:
    bo = server.create_user("Bo")
    bot = server.world.bot.id
    async with gateway.listening():
        lab = _group(server, ada)
        await gateway.until(lambda: len(gateway.passings) == 2)
        server.set_member(lab, bot, "administrator")
        server.set_member(lab, bo, "member")
        server.set_member(lab, bo, "left")
        server.set_member(lab, bot, "kicked")
        server.say(ada, ada, "status")
        await gateway.hear(1)
    whats = [one.what for one in gateway.passings]
    # Heard everything before, so that being an admin changes nothing; leaving is told twice.
    left = [ChatEventKind.LEFT] * 2
    assert whats == [ChatEventKind.HEARING, ChatEventKind.ADDED, *left, ChatEventKind.REMOVED]
    assert gateway.passings[1].title == "Lab"
    assert str(gateway.passings[2].who) == f"telegram:{bo}"


async def test_in_privacy_mode_an_admin_hears_more() -> None:
    async with FakeTelegram(limits=None, settings=Settings(conflict_pause_s=0.0)) as server:
        ada, gateway = server.create_user("Ada"), Gateway(server)
        async with gateway.listening():
            lab = _group(server, ada)
            for status in ("administrator", "restricted", "left"):
                server.set_member(lab, server.world.bot.id, status, by=ada)
            await gateway.until(lambda: len(gateway.passings) == 5)
        assert [one.what for one in gateway.passings] == [
            ChatEventKind.DEAF,
            ChatEventKind.ADDED,
            ChatEventKind.HEARING,
            ChatEventKind.DEAF,
            ChatEventKind.REMOVED,
        ]
        assert [one.deaf for one in gateway.passings[1:]] == [True, False, True, True]


async def test_where_we_were_put_out_nothing_is_tried_until_we_are_let_in(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    lab = _group(server, ada)
    bot = server.world.bot.id
    server.set_member(lab, bot, "kicked")
    for _ in range(5):
        with pytest.raises(ChatGone):
            await gateway.messenger.send(to(lab, "done"))
    assert len(gateway.calls("sendMessage")) == 1
    async with gateway.listening():
        server.set_member(lab, bot, "member")
        await gateway.until(lambda: len(gateway.passings) == 4)
        await gateway.messenger.send(to(lab, "done"))
        server.block(ada)
        await gateway.until(lambda: gateway.passings[-1].what is ChatEventKind.REMOVED)
        with pytest.raises(ChatGone):
            await gateway.messenger.send(to(ada, "done"))
        server.block(ada, blocked=False)
        server.say(ada, ada, "status")
        await gateway.hear(1)
        await gateway.messenger.send(to(ada, "done"))
    assert len(gateway.calls("sendMessage")) == 3


@pytest.mark.parametrize("seen", [False, True], ids=["unknown", "seen in a group"])
async def test_whoever_has_not_written_yet_is_told_once_they_have(
    server: FakeTelegram, gateway: Gateway, ada: int, seen: bool
) -> None:
    bo = server.create_user("Bo", started=False)
    if seen:
        _group(server, ada, bot="administrator")
    for _ in range(2):
        with pytest.raises(ChatNotBegun):
            await gateway.messenger.send(to(bo if seen else 1001, "done"))
    assert len(gateway.calls("sendMessage")) == 1
    async with gateway.listening():
        if seen:
            server.say(bo, bo, "/start")
            await gateway.hear(1)
            await gateway.messenger.send(to(bo, "done"))


# ---- several bots in one group ----


class Bridge:
    """One group with two bots: two servers, each of which plays the other's bot as a member."""

    def __init__(self, *servers: FakeTelegram) -> None:
        self.servers = servers
        first, second = (one.create_user("Ada", username="ada") for one in servers)
        assert first == second
        self.ada = first
        self.labs = [_group(one, self.ada) for one in servers]
        self.bots = [
            one.create_user("Gateway", username=other.world.bot.username, is_bot=True)
            for one, other in zip(servers, reversed(servers), strict=True)
        ]
        for one, lab, bot in zip(servers, self.labs, self.bots, strict=True):
            one.set_member(lab, bot, "member")

    def say(self, text: str, *, reply_to: list[int] | None = None) -> None:
        """A person writes; both bots are told if Telegram tells them."""
        for number, (one, lab) in enumerate(zip(self.servers, self.labs, strict=True)):
            if reply_to is None:
                one.say(lab, self.ada, text)
            else:
                one.say(lab, self.ada, text, reply_to=reply_to[number])

    async def second_says(self, gateway: Gateway, text: str) -> list[int]:
        """The second bot writes; the first server shows it as another bot's message."""
        sent = await gateway.messenger.send(to(self.labs[1], text))
        shown = self.servers[0].say(self.labs[0], self.bots[0], text)
        return [shown, int(sent)]


@pytest.mark.parametrize("privacy", [True, False])
async def test_of_two_bots_in_a_group_the_addressed_one_answers(privacy: bool) -> None:
    settings = [
        Settings(privacy=privacy, conflict_pause_s=0.0, bot_username=name)
        for name in ("rosic_test_bot", OTHER)
    ]
    async with (
        FakeTelegram(limits=None, settings=settings[0]) as one,
        FakeTelegram(limits=None, settings=settings[1]) as two,
    ):
        bridge = Bridge(one, two)
        first, second = Gateway(one), Gateway(two)
        async with first.listening(), second.listening():
            bridge.say(f"/status@{OTHER}")
            bridge.say(f"@{OTHER} omni move 1 m")
            carried = await bridge.second_says(second, "Omni: move 1 m. STOP")
            bridge.say("omni move 2 m", reply_to=carried)
            bridge.say("@rosic_test_bot status", reply_to=carried)
            bridge.say(f"/stop@{OTHER}")
            if not privacy:
                bridge.say("stop", reply_to=carried)
            for one_chat in (one, two):
                one_chat.say(bridge.ada, bridge.ada, "help")
            await first.until(lambda: "help" in first.texts)
            await second.until(lambda: "help" in second.texts)
        heard_first = {"status", "help"} if privacy else {"status", "/stop", "stop", "help"}
        assert set(first.texts) == heard_first
        assert {"/status", "omni move 1 m", "omni move 2 m", "/stop"} <= set(second.texts)
        assert all("Omni:" not in text for text in [*first.texts, *second.texts])
        assert [one.violations, two.violations] == [[], []]


async def test_bots_that_see_each_other_do_not_answer_each_other(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    lab = _group(server, ada)
    other = server.create_user("Other", username=OTHER, is_bot=True)
    async with gateway.listening():
        user = {"id": other, "is_bot": True, "first_name": "Other", "username": OTHER}
        chat = {"id": lab, "type": "supergroup", "title": "Lab"}
        for number, text in enumerate(("omni move 1 m", "@rosic_test_bot omni move 1 m"), 900):
            date = server.world.clock.date()
            message = {"message_id": number, "date": date, "chat": chat, "from": user}
            server.put_update("message", message | {"text": text})
        server.say(ada, ada, "help")
        await gateway.until(lambda: "help" in gateway.texts)
    assert [one.standing.value for one in gateway.heard if one.text != "help"] == ["via-bot"] * 2


# ---- menus ----


async def test_menus_by_language_and_chat_are_set_once(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    menus = [
        Menu(MenuScope.PRIVATE, (("stop", "Stop"),)),
        Menu(MenuScope.PRIVATE, (("stop", "Anhalten"),), "de"),
        Menu(MenuScope.GROUPS, (("stop", "Stop"),)),
        Menu(MenuScope.CHAT, (("invite", "Invite"),), "", str(ada)),
        Menu(MenuScope.CHAT, (("invite", "Invite"),), "", "99"),
    ]
    await gateway.messenger.set_menus(menus)
    await gateway.messenger.set_menus(menus)
    assert len(gateway.calls("setMyCommands")) == 5
    assert [
        key for key in server.world.state.commands if '"all_private_chats"' in key and "de" in key
    ]
    gone = Menu(MenuScope.CHAT, (), "", str(ada))
    await gateway.messenger.set_menus([gone])
    assert len(gateway.calls("deleteMyCommands")) == 1
    assert not [key for key in server.world.state.commands if str(ada) in key]


async def test_a_menu_that_could_not_be_set_is_set_the_next_time(
    server: FakeTelegram, gateway: Gateway
) -> None:
    menu = [Menu(MenuScope.PRIVATE, (("stop", "Stop"),))]
    server.fail("bad_gateway", "setMyCommands", 3)
    await gateway.messenger.set_menus(menu)
    assert server.world.state.commands == {}
    await gateway.messenger.set_menus(menu)
    assert len(server.world.state.commands) == 1
