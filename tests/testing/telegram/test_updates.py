"""getUpdates and webhooks: https://core.telegram.org/bots/api#getting-updates."""

from __future__ import annotations

import asyncio

import pytest

from rosic.testing.telegram import ControlError, FakeTelegram, Settings
from tests.pace import pace
from tests.testing.telegram.asking import Api, Wall

OTHER = (
    "409 Conflict: terminated by other getUpdates request; "
    "make sure that only one bot instance is running"
)


async def test_updates_repeat_until_the_offset_confirms_them(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    for text in ("one", "two", "three"):
        server.say(ada, ada, text)
    first = await api.ok("getUpdates")
    assert first == await api.ok("getUpdates")
    assert await api.texts(first[1]["update_id"]) == ["two", "three"]
    assert await api.texts(first[0]["update_id"]) == ["two", "three"], "confirmed ones came back"
    assert server.pending() == 2


async def test_half_a_pair_of_surrogates_reaches_a_bot_and_blocks_nothing(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    server.say(ada, ada, "\ud800 omni")
    server.say(ada, ada, "stop")
    assert await api.texts() == ["\ud800 omni", "stop"]


async def test_a_negative_offset_counts_from_the_end_and_forgets_the_rest(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    server.backlog(ada, ada, "line {n}", 5)
    assert await api.texts(-2) == ["line 4", "line 5"]
    assert await api.texts() == ["line 4", "line 5"]


async def test_limit(server: FakeTelegram, api: Api, ada: int) -> None:
    server.backlog(ada, ada, "line {n}", 120)
    assert len(await api.texts()) == 100
    assert await api.texts(limit=2) == ["line 1", "line 2"]
    assert len(await api.texts(limit=0)) == 1
    assert len(await api.texts(limit=999)) == 100


async def test_a_long_poll_ends_with_the_first_update(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    poll = asyncio.create_task(api.texts(timeout=30))
    await server.wait(0, kinds=["call"])
    assert not poll.done()
    server.say(ada, ada, "hello")
    assert await asyncio.wait_for(poll, 60 * pace()) == ["hello"]


async def test_a_long_poll_ends_with_nothing_in_time(api: Api) -> None:
    began_s = asyncio.get_running_loop().time()
    assert await api.ok("getUpdates", timeout=1) == []
    assert 0.9 < asyncio.get_running_loop().time() - began_s < 30


async def test_the_poll_that_waited_is_thrown_out_by_the_next(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    first = asyncio.create_task(api.refusal("getUpdates", timeout=30))
    await server.wait(server.seq - 1, kinds=["call"])
    second = asyncio.create_task(api.texts(timeout=30))
    assert await asyncio.wait_for(first, 60 * pace()) == OTHER
    assert not second.done()
    server.say(ada, ada, "for the second")
    assert await asyncio.wait_for(second, 60 * pace()) == ["for the second"]


async def test_a_poll_whose_client_is_gone_is_no_conflict(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    first = asyncio.create_task(api.ok("getUpdates", timeout=30))
    await server.wait(0, kinds=["call"])
    first.cancel()
    await asyncio.gather(first, return_exceptions=True)
    # The server's own client is asked, so that it has certainly seen the connection close.
    await api.ok("getMe")
    second = asyncio.create_task(api.texts(timeout=30))
    await server.wait(server.seq, kinds=["call"])
    server.say(ada, ada, "hello")
    assert await second == ["hello"]
    assert 409 not in [call["code"] for call in server.calls]


async def test_further_conflicts_are_answered_late() -> None:
    settings = Settings(conflict_pause_s=2.0)
    async with FakeTelegram(limits=None, settings=settings) as server, Api(server) as api:
        loop = asyncio.get_running_loop()
        polls = []
        for _ in range(3):
            seen = server.seq
            polls.append(asyncio.create_task(api.raw("getUpdates", timeout=1)))
            await server.wait(seen, kinds=["call"])
        began_s = loop.time()
        assert (await polls[0])["error_code"] == 409
        assert loop.time() - began_s < 1.5
        assert (await polls[1])["error_code"] == 409
        assert loop.time() - began_s > 1.5
        assert (await polls[2])["ok"]


async def test_short_polls_do_not_conflict(server: FakeTelegram, api: Api) -> None:
    waiting = asyncio.create_task(api.ok("getUpdates", timeout=1))
    await server.wait(0, kinds=["call"])
    assert await api.ok("getUpdates") == []
    assert await waiting == []


async def test_a_hasty_poll_is_stretched_when_asked_for(wall: Wall) -> None:
    settings = Settings(idle_poll_s=2.0)
    async with FakeTelegram(settings=settings, wall_s=wall) as server, Api(server) as api:
        loop = asyncio.get_running_loop()
        began_s = loop.time()
        await api.ok("getUpdates")
        assert loop.time() - began_s < 1.5
        await api.ok("getUpdates")
        assert loop.time() - began_s > 1.5


async def test_allowed_updates_stick_and_do_not_reach_back(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    number = server.say(ada, ada, "before")
    updates = await api.ok("getUpdates", allowed_updates=["edited_message"])
    assert [min(update) for update in updates] == ["message"], "made before the call"
    await api.ok("getUpdates", offset=updates[-1]["update_id"] + 1)
    server.say(ada, ada, "unwanted")
    server.edit(ada, number, "wanted")
    (update,) = await api.ok("getUpdates")
    assert update["edited_message"]["text"] == "wanted"
    assert (await api.ok("getWebhookInfo"))["allowed_updates"] == ["edited_message"]
    await api.ok("getUpdates", offset=update["update_id"] + 1, allowed_updates=[])
    server.say(ada, ada, "back to the usual")
    assert await api.texts() == ["back to the usual"]


async def test_an_unknown_update_type_is_reported(server: FakeTelegram, api: Api) -> None:
    await api.ok("getUpdates", allowed_updates=["mesage"])
    assert "mesage" in server.violations[0]["reason"]


async def test_updates_are_kept_for_a_day_from_their_date(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    server.say(ada, ada, "old", age_s=80_000)
    server.say(ada, ada, "new")
    server.say(ada, ada, "never heard of", age_s=86_401)
    assert server.pending() == 2
    server.advance(6_000)
    assert await api.texts() == ["old", "new"]
    server.advance(1_000)
    assert await api.texts() == ["new"]


async def test_a_press_waits_for_150_seconds(server: FakeTelegram, api: Api, ada: int) -> None:
    keyboard = {"inline_keyboard": [[{"text": "Go", "callback_data": "go"}]]}
    sent = await api.ok("sendMessage", chat_id=ada, text="?", reply_markup=keyboard)
    server.tap(ada, ada, sent["message_id"], "Go")
    server.advance(149)
    assert len(await api.ok("getUpdates")) == 1
    server.advance(2)
    assert await api.ok("getUpdates") == []


async def test_a_webhook_excludes_polling(server: FakeTelegram, api: Api, ada: int) -> None:
    waiting = asyncio.create_task(api.refusal("getUpdates", timeout=30))
    await server.wait(0, kinds=["call"])
    answer = await api.raw("setWebhook", url="https://example.org/hook")
    assert answer["description"] == "Webhook was set"
    assert await waiting == "409 Conflict: terminated by setWebhook request"
    assert await api.refusal("getUpdates") == (
        "409 Conflict: can't use getUpdates method while webhook is active; "
        "use deleteWebhook to delete the webhook first"
    )
    server.say(ada, ada, "kept")
    info = await api.ok("getWebhookInfo")
    assert (info["url"], info["pending_update_count"]) == ("https://example.org/hook", 1)
    answer = await api.raw("deleteWebhook")
    assert answer["description"] == "Webhook was deleted"
    assert await api.texts() == ["kept"]
    answer = await api.raw("deleteWebhook", drop_pending_updates=True)
    assert answer["description"] == "Webhook is already deleted"
    assert await api.texts() == []


async def test_a_webhook_needs_https(api: Api) -> None:
    assert await api.refusal("setWebhook", url="http://example.org") == (
        "400 Bad Request: bad webhook: An HTTPS URL must be provided for webhook"
    )


async def test_a_foreign_webhook_throws_the_poller_out(server: FakeTelegram, api: Api) -> None:
    waiting = asyncio.create_task(api.refusal("getUpdates", timeout=30))
    await server.wait(0, kinds=["call"])
    server.foreign_webhook("https://thief.example")
    assert (await waiting).startswith("409")
    assert (await api.ok("getWebhookInfo"))["url"] == "https://thief.example"


# ---- tricks of the queue ----


async def test_a_duplicate_under_the_same_or_a_new_update_id(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    server.duplicate()
    server.say(ada, ada, "same")
    server.duplicate(new_id=True)
    server.say(ada, ada, "new")
    server.say(ada, ada, "alone")
    first, second, third, fourth, _ = await api.ok("getUpdates")
    assert first == second
    assert fourth["update_id"] == third["update_id"] + 1
    assert fourth["message"] == third["message"]


async def test_reorder(server: FakeTelegram, api: Api, ada: int) -> None:
    server.backlog(ada, ada, "line {n}", 3)
    server.reorder()
    assert await api.texts() == ["line 3", "line 2", "line 1"]
    assert await api.texts() == ["line 1", "line 2", "line 3"]


async def test_a_lower_update_id_after_a_quiet_week_reaches_an_old_offset(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    server.say(ada, ada, "last week")
    (update,) = await api.ok("getUpdates")
    with pytest.raises(ControlError):
        server.jump(7)
    assert await api.ok("getUpdates", offset=update["update_id"] + 1) == []
    server.jump(7)
    server.say(ada, ada, "this week")
    assert await api.texts(update["update_id"] + 1) == ["this week"]
    server.jump(9_000_000)
    server.say(ada, ada, "further up")
    assert await api.texts(8) == ["further up"]


async def test_anything_can_be_queued(server: FakeTelegram, api: Api) -> None:
    server.put_update("poll", {"id": "1"})
    assert (await api.ok("getUpdates"))[0]["poll"] == {"id": "1"}
