"""429 and the published limits: https://core.telegram.org/bots/faq#my-bot-is-hitting-limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.testing.telegram import FakeTelegram, Limits

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from tests.testing.telegram.asking import Api, Wall


@pytest.fixture
async def server(wall: Wall) -> AsyncIterator[FakeTelegram]:
    async with FakeTelegram(wall_s=wall) as running:
        yield running


async def send(api: Api, chat: int, times: int) -> list[int]:
    """Send and return the status of each."""
    answers = [await api.raw("sendMessage", chat_id=chat, text="x") for _ in range(times)]
    return [answer.get("error_code", 200) for answer in answers]


async def test_a_short_burst_then_one_a_second(server: FakeTelegram, api: Api, ada: int) -> None:
    assert await send(api, ada, 7) == [200] * 5 + [429] * 2
    assert len(server.messages(ada)) == 5
    server.advance(1)
    assert await send(api, ada, 2) == [200, 429]
    server.advance(10)
    assert await send(api, ada, 6) == [200] * 5 + [429]


async def test_the_answer_says_how_long_to_wait(api: Api, ada: int) -> None:
    await send(api, ada, 5)
    async with api.session.post(
        api.url("sendMessage"), json={"chat_id": ada, "text": "x"}
    ) as response:
        assert response.status == 429
        assert response.headers["Retry-After"] == "1"
        assert await response.json() == {
            "ok": False,
            "error_code": 429,
            "description": "Too Many Requests: retry after 1",
            "parameters": {"retry_after": 1},
        }


async def test_edits_count_like_messages(server: FakeTelegram, api: Api, ada: int) -> None:
    sent = await api.ok("sendMessage", chat_id=ada, text="0")
    which = {"chat_id": ada, "message_id": sent["message_id"]}
    for number in range(1, 5):
        await api.ok("editMessageText", **which, text=str(number))
    assert (await api.refusal("editMessageText", **which, text="5")).startswith("429")
    assert server.message(ada, sent["message_id"])["text"] == "4"


async def test_twenty_a_minute_in_a_group(server: FakeTelegram, api: Api, ada: int) -> None:
    lab = server.create_chat("group", "Lab", members=[ada])
    for _ in range(20):
        assert await send(api, lab, 1) == [200]
        server.advance(1)
    answer = await api.raw("sendMessage", chat_id=lab, text="x")
    assert answer["parameters"]["retry_after"] == 40
    server.advance(40)
    assert await send(api, lab, 1) == [200]


async def test_thirty_a_second_overall(server: FakeTelegram, api: Api) -> None:
    people = [server.create_user(f"Person {n}") for n in range(31)]
    codes = [(await send(api, person, 1))[0] for person in people]
    assert codes == [200] * 30 + [429]
    server.advance(1)
    assert await send(api, people[-1], 1) == [200]


async def test_impatience_is_written_down(server: FakeTelegram, api: Api, ada: int) -> None:
    await send(api, ada, 6)
    assert server.violations == []
    server.advance(0.5)
    assert await send(api, ada, 1) == [429]
    assert "before retry_after was over" in server.violations[0]["reason"]
    server.advance(1)
    assert await send(api, ada, 1) == [200]
    assert len(server.violations) == 1


async def test_other_calls_do_not_count(api: Api, ada: int) -> None:
    for _ in range(40):
        await api.ok("sendChatAction", chat_id=ada, action="typing")
        await api.ok("getMe")


async def test_other_limits_and_none(server: FakeTelegram, api: Api, ada: int) -> None:
    server.set_limits(Limits(chat_burst=1, min_retry_after_s=7))
    await send(api, ada, 1)
    answer = await api.raw("sendMessage", chat_id=ada, text="x")
    assert answer["parameters"]["retry_after"] == 7
    server.set_limits(None)
    assert await send(api, ada, 40) == [200] * 40
