"""Groups, channels, privacy mode and members."""

from __future__ import annotations

from typing import Any

import pytest
from telegram.constants import ReactionEmoji

from rosic.testing.telegram import ControlError, FakeTelegram, Settings
from rosic.testing.telegram.methods.chats import REACTIONS
from tests.testing.telegram.asking import Api


@pytest.fixture
def lab(server: FakeTelegram, ada: int) -> int:
    """A supergroup with Ada as its owner and the bot as a member; nothing waits in the queue."""
    chat = server.create_chat("supergroup", "Lab", members=[ada])
    server.world.queue.clear()
    return chat


async def heard(api: Api, kind: str = "message") -> list[Any]:
    updates = await api.ok("getUpdates")
    await api.ok("getUpdates", offset=-1)
    api.server.world.queue.clear()
    return [update[kind] for update in updates if kind in update]


async def test_privacy_mode_lets_through_what_is_meant_for_the_bot(
    server: FakeTelegram, api: Api, ada: int, lab: int
) -> None:
    sent = await api.ok("sendMessage", chat_id=lab, text="hello")
    for text in ("stop", "/stop", "/stop@rosic_test_bot", "/stop@other_bot", "@rosic_test_bot go"):
        server.say(lab, ada, text)
    server.say(lab, ada, "a reply", reply_to=sent["message_id"])
    server.say(lab, ada, "written through it", via_bot=True)
    assert [message["text"] for message in await heard(api)] == [
        "/stop",
        "/stop@rosic_test_bot",
        "@rosic_test_bot go",
        "a reply",
        "written through it",
    ]
    assert not (await api.ok("getMe"))["can_read_all_group_messages"]


async def test_a_bare_command_goes_to_the_bot_that_wrote_last(
    server: FakeTelegram, api: Api, ada: int, lab: int
) -> None:
    other = server.create_user("Other", username="other_bot", is_bot=True)
    server.set_member(lab, other, "member")
    server.say(lab, other, "beep")
    server.world.queue.clear()
    server.say(lab, ada, "/stop")
    assert await heard(api) == []
    await api.ok("sendMessage", chat_id=lab, text="hello")
    server.say(lab, ada, "/stop")
    assert len(await heard(api)) == 1


async def test_an_administrator_bot_and_one_without_privacy_hear_everything(
    server: FakeTelegram, api: Api, ada: int, lab: int
) -> None:
    server.set_member(lab, server.world.bot.id, "administrator")
    server.say(lab, ada, "stop")
    assert [message["text"] for message in await heard(api)] == ["stop"]
    async with FakeTelegram(settings=Settings(privacy=False)) as open_server:
        bob = open_server.create_user("Bob")
        group = open_server.create_chat("group", "Lab", members=[bob])
        open_server.world.queue.clear()
        open_server.say(group, bob, "stop")
        async with Api(open_server) as open_api:
            assert len(await heard(open_api)) == 1
            assert (await open_api.ok("getMe"))["can_read_all_group_messages"]


async def test_bots_do_not_hear_bots(server: FakeTelegram, api: Api, lab: int) -> None:
    other = server.create_user("Other", username="other_bot", is_bot=True)
    server.set_member(lab, other, "member")
    server.world.queue.clear()
    server.say(lab, other, "/stop@rosic_test_bot")
    assert await heard(api) == []


async def test_who_is_not_there_cannot_speak(server: FakeTelegram, lab: int) -> None:
    with pytest.raises(ControlError, match="not in chat"):
        server.say(lab, server.create_user("Eve"), "stop")


async def test_senders_that_are_no_person(
    server: FakeTelegram, api: Api, ada: int, lab: int
) -> None:
    server.set_member(lab, server.world.bot.id, "administrator")
    channel = server.create_chat("channel", "News", members=[ada], bot="administrator")
    server.link(channel, lab)
    server.world.queue.clear()
    server.say(lab, ada, "as the group", sender_chat=lab)
    server.say(lab, ada, "as a channel", sender_chat=channel)
    server.say(channel, None, "a post")
    updates = await api.ok("getUpdates")
    anonymous, as_channel, post, forwarded = (list(update.values())[-1] for update in updates)
    assert (anonymous["from"]["id"], anonymous["sender_chat"]["id"]) == (1087968824, lab)
    assert (as_channel["from"]["id"], as_channel["sender_chat"]["id"]) == (136817688, channel)
    assert "channel_post" in updates[2]
    assert "from" not in post
    assert (forwarded["from"]["id"], forwarded["chat"]["id"]) == (777000, lab)
    assert forwarded["is_automatic_forward"]
    assert forwarded["forward_origin"]["type"] == "channel"


async def test_forwards_and_edits_of_people(server: FakeTelegram, api: Api, ada: int) -> None:
    bob = server.create_user("Bob")
    server.say(ada, ada, "one", forward_origin=bob)
    server.say(ada, ada, "two", forward_origin="somebody")
    number = server.say(ada, ada, "three", date=int(server.world.clock.now_s()) - 100)
    server.advance(3)
    server.say(ada, ada, "three and more", edit_of=number)
    one, two, three, edit = await api.ok("getUpdates")
    assert one["message"]["forward_origin"]["sender_user"]["id"] == bob
    assert two["message"]["forward_origin"]["sender_user_name"] == "somebody"
    edited = edit["edited_message"]
    assert (edited["message_id"], edited["text"]) == (number, "three and more")
    assert edited["date"] == three["message"]["date"]
    assert edited["edit_date"] == edited["date"] + 103


async def test_a_group_becomes_a_supergroup(server: FakeTelegram, api: Api, ada: int) -> None:
    group = server.create_chat("group", "Lab", members=[ada])
    server.world.queue.clear()
    new = server.migrate(group)
    to, come = await heard(api)
    assert (to["chat"]["id"], to["migrate_to_chat_id"]) == (group, new)
    assert (come["chat"]["id"], come["migrate_from_chat_id"]) == (new, group)
    answer = await api.raw("sendMessage", chat_id=group, text="x")
    assert answer["description"] == "Bad Request: group chat was upgraded to a supergroup chat"
    assert answer["parameters"] == {"migrate_to_chat_id": new}
    await api.ok("sendMessage", chat_id=new, text="x")


async def test_members_come_and_go(server: FakeTelegram, api: Api, ada: int, lab: int) -> None:
    bot = server.world.bot.id
    server.set_member(lab, bot, "administrator", by=ada)
    (change,) = await heard(api, "my_chat_member")
    assert change["old_chat_member"]["status"] == "member"
    assert change["new_chat_member"]["status"] == "administrator"
    bob = server.create_user("Bob")
    server.set_member(lab, bob, "member")
    (joined,) = await heard(api)
    assert joined["new_chat_members"][0]["id"] == bob
    await api.ok("getUpdates", allowed_updates=["chat_member"])
    server.set_member(lab, bob, "left")
    assert (await heard(api, "chat_member"))[0]["new_chat_member"]["status"] == "left"
    server.set_member(lab, bot, "kicked", by=ada)
    assert await api.refusal("sendMessage", chat_id=lab, text="x") == (
        "403 Forbidden: bot was kicked from the supergroup chat"
    )


async def test_blocking_is_told(server: FakeTelegram, api: Api, ada: int) -> None:
    server.block(ada)
    (change,) = await heard(api, "my_chat_member")
    assert change["new_chat_member"]["status"] == "kicked"


async def test_a_restricted_bot_is_mute(server: FakeTelegram, api: Api, lab: int) -> None:
    server.set_member(lab, server.world.bot.id, "restricted")
    assert await api.refusal("sendMessage", chat_id=lab, text="x") == (
        "400 Bad Request: not enough rights to send text messages to the chat"
    )


async def test_where_the_bot_is_not(server: FakeTelegram, api: Api, ada: int) -> None:
    group = server.create_chat("group", "Lab", members=[ada], bot=None)
    assert await api.refusal("sendMessage", chat_id=group, text="x") == (
        "403 Forbidden: bot is not a member of the group chat"
    )
    channel = server.create_chat("channel", "News", members=[ada])
    assert await api.refusal("sendMessage", chat_id=channel, text="x") == (
        "400 Bad Request: need administrator rights in the channel chat"
    )


async def test_looking_at_a_chat(server: FakeTelegram, api: Api, ada: int, lab: int) -> None:
    other = server.create_user("Other", is_bot=True)
    server.set_member(lab, other, "administrator")
    assert (await api.ok("getChat", chat_id=lab))["title"] == "Lab"
    owner = await api.ok("getChatMember", chat_id=lab, user_id=ada)
    assert owner["status"] == "creator"
    administrators = await api.ok("getChatAdministrators", chat_id=lab)
    assert [one["user"]["id"] for one in administrators] == [ada]
    assert await api.ok("getChatMemberCount", chat_id=lab) == 3
    assert await api.refusal("getChatMember", chat_id=lab, user_id=5) == (
        "400 Bad Request: invalid user_id specified"
    )
    assert await api.refusal("getChatAdministrators", chat_id=ada) == (
        "400 Bad Request: there are no administrators in the private chat"
    )


async def test_public_names_reach_groups_and_channels(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    lab = server.create_chat("supergroup", "Lab", members=[ada], username="rosic_lab")
    assert (await api.ok("getChat", chat_id="@Rosic_Lab"))["id"] == lab
    assert await api.refusal("getChat", chat_id="@ada") == "400 Bad Request: chat not found"


async def test_leaving(api: Api, ada: int, lab: int) -> None:
    assert await api.ok("leaveChat", chat_id=lab)
    assert (await api.refusal("getChat", chat_id=lab)).startswith("403")
    assert (await api.refusal("leaveChat", chat_id=ada)).startswith("400")


async def test_pinning(server: FakeTelegram, api: Api, ada: int, lab: int) -> None:
    sent = await api.ok("sendMessage", chat_id=ada, text="x")
    which = {"chat_id": ada, "message_id": sent["message_id"]}
    await api.ok("pinChatMessage", **which)
    (note,) = await heard(api)
    assert note["pinned_message"]["message_id"] == sent["message_id"]
    assert server.message(ada, sent["message_id"])["pinned"]
    assert (await api.ok("getChat", chat_id=ada))["pinned_message"]["text"] == "x"
    await api.ok("unpinChatMessage", chat_id=ada)
    assert await api.refusal("unpinChatMessage", **which) == (
        "400 Bad Request: message to unpin not found"
    )
    own = await api.ok("sendMessage", chat_id=lab, text="x")
    assert await api.refusal("pinChatMessage", chat_id=lab, message_id=own["message_id"]) == (
        "400 Bad Request: not enough rights to manage pinned messages in the chat"
    )
    bot = server.world.bot.id
    server.set_member(lab, bot, "administrator", without=["can_pin_messages"])
    assert not (await api.ok("getChatMember", chat_id=lab, user_id=bot))["can_pin_messages"]
    for method in ("pinChatMessage", "unpinChatMessage"):
        assert await api.refusal(method, chat_id=lab, message_id=own["message_id"]) == (
            "400 Bad Request: not enough rights to manage pinned messages in the chat"
        )
    server.set_member(lab, bot, "administrator", without=["can_invite_users"])
    await api.ok("pinChatMessage", chat_id=lab, message_id=own["message_id"])
    assert await api.refusal("pinChatMessage", chat_id=ada, message_id=99) == (
        "400 Bad Request: message to pin not found"
    )
    await api.ok("pinChatMessage", **which)
    await api.ok("unpinAllChatMessages", chat_id=ada)
    assert not server.message(ada, sent["message_id"])["pinned"]


async def test_reactions(server: FakeTelegram, api: Api, ada: int) -> None:
    number = server.say(ada, ada, "go")
    thumb = [{"type": "emoji", "emoji": "👍"}]
    await api.ok("setMessageReaction", chat_id=ada, message_id=number, reaction=thumb)
    bot = str(server.world.bot.id)
    assert server.message(ada, number)["reactions"] == {bot: ["👍"]}
    wrong = [{"type": "emoji", "emoji": "🤖"}]
    assert await api.refusal(
        "setMessageReaction", chat_id=ada, message_id=number, reaction=wrong
    ) == ("400 Bad Request: REACTION_INVALID")
    assert await api.refusal(
        "setMessageReaction", chat_id=ada, message_id=number, reaction=thumb * 2
    ) == ("400 Bad Request: REACTIONS_TOO_MANY")
    server.react(ada, ada, number, "🔥")
    assert await heard(api, "message_reaction") == [], "wanted by nobody"
    await api.ok("getUpdates", allowed_updates=["message_reaction"])
    server.react(ada, ada, number, "👎")
    (change,) = await heard(api, "message_reaction")
    assert change["new_reaction"] == [{"type": "emoji", "emoji": "👎"}]


async def test_who_hears_of_reactions(server: FakeTelegram, api: Api, ada: int) -> None:
    bot, wanted = server.world.bot.id, ["message_reaction", "message_reaction_count"]
    await api.ok("getUpdates", allowed_updates=wanted)
    lab = server.create_chat("supergroup", "Lab", members=[ada])
    number = server.say(lab, ada, "x")
    server.react(lab, ada, number, "👍")
    assert await heard(api, "message_reaction") == [], "a member hears nothing"
    server.set_member(lab, bot, "administrator")
    server.react(lab, ada, number, "👍")
    assert await heard(api, "message_reaction") == [], "nothing has changed"
    server.react(lab, ada, number)
    (change,) = await heard(api, "message_reaction")
    assert (change["old_reaction"][0]["emoji"], change["new_reaction"]) == ("👍", [])
    server.world.queue.clear()
    server.react(lab, ada, number, "🔥", anonymous=True)
    (change,) = await heard(api, "message_reaction")
    assert "user" not in change
    assert change["actor_chat"]["id"] == lab
    other = server.create_user("Other", is_bot=True)
    server.world.queue.clear()
    server.set_member(lab, other, "member")
    server.react(lab, other, number, "👍")
    assert await heard(api, "message_reaction") == [], "no bot hears of another bot's"
    news = server.create_chat("channel", "News", members=[ada], bot="administrator")
    server.react(news, ada, server.say(news, None, "x"), "👍")
    (change,) = await heard(api, "message_reaction_count")
    assert change["reactions"] == [{"type": {"type": "emoji", "emoji": "👍"}, "total_count": 1}]
    stranger = server.create_user("Cy")
    for user, emoji in ((stranger, ["👍"]), (ada, ["🤖"]), (ada, ["👍", "👎", "🔥", "🎉"])):
        with pytest.raises(ControlError):
            server.react(lab, user, number, *emoji)


def test_the_reactions_are_those_that_another_library_lists() -> None:
    assert {emoji.value.replace("\ufe0f", "") for emoji in ReactionEmoji} == REACTIONS


async def test_chat_actions(api: Api, ada: int) -> None:
    assert await api.ok("sendChatAction", chat_id=ada, action="typing")
    assert await api.refusal("sendChatAction", chat_id=ada, action="typign") == (
        "400 Bad Request: wrong parameter action in request"
    )


async def test_forum_topics(server: FakeTelegram, api: Api, ada: int) -> None:
    lab = server.create_chat("supergroup", "Lab", members=[ada], topics=["omni", "kuka1"])
    thread = server.topics(lab)["omni"]
    sent = await api.ok("sendMessage", chat_id=lab, text="x", message_thread_id=thread)
    assert (sent["message_thread_id"], sent["is_topic_message"]) == (thread, True)
    server.world.queue.clear()
    server.say(lab, ada, "/stop", thread=thread)
    assert (await heard(api))[0]["message_thread_id"] == thread
