"""Identity, parameters, commands and names."""

from __future__ import annotations

import aiohttp
import pytest

from rosic.testing.telegram import FakeTelegram
from tests.testing.telegram.asking import Api


@pytest.mark.parametrize(
    ("path", "answer"),
    [
        ("/bot1:x/getMe", (401, "Unauthorized")),
        ("/botx/getMe", (404, "Not Found")),
        ("/file/bot1:x/documents/file_1", (401, "Unauthorized")),
    ],
)
async def test_a_wrong_token(
    server: FakeTelegram, api: Api, path: str, answer: tuple[int, str]
) -> None:
    async with api.session.get(server.url + path) as response:
        body = await response.json()
        assert (response.status, body["description"]) == answer
        assert body["error_code"] == response.status


async def test_an_unknown_method_fails_and_is_written_down(server: FakeTelegram, api: Api) -> None:
    assert await api.refusal("sendMesage") == "404 Not Found: method not found"
    assert server.violations[0]["method"] == "sendMesage"


async def test_an_unknown_parameter_is_written_down_and_reported(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    lines: list[str] = []
    server.report = lines.append
    await api.ok("sendMessage", chat_id=ada, text="x", colour="red")
    assert [violation["reason"] for violation in server.violations] == [
        "unknown parameter 'colour'"
    ]
    assert lines == ["violation: sendMessage: unknown parameter 'colour'"]


@pytest.mark.parametrize(
    ("method", "parameters"),
    [
        ("getUpdates", {"offset": "7"}),
        ("getUpdates", {"offset": "x"}),
        ("getUpdates", {"offset": 1.5}),
        ("getUpdates", {"offset": True}),
        ("sendMessage", {"text": 5}),
        ("sendMessage", {"text": "x", "disable_notification": "true"}),
        ("sendMessage", {"text": "x", "disable_notification": 1}),
    ],
)
async def test_a_wrong_type_is_written_down(
    server: FakeTelegram, api: Api, ada: int, method: str, parameters: dict[str, object]
) -> None:
    chat = {"chat_id": ada} if method == "sendMessage" else {}
    await api.ok(method, **chat, **parameters)
    assert len(server.violations) == 1
    assert "should be" in server.violations[0]["reason"]


async def test_every_way_of_sending_parameters(server: FakeTelegram, api: Api, ada: int) -> None:
    markup = '{"inline_keyboard": [[{"text": "Go", "callback_data": "go"}]]}'
    fields = {"chat_id": str(ada), "text": "x", "reply_markup": markup}
    multipart = aiohttp.FormData(fields, default_to_multipart=True)
    for body in (
        {"params": fields},
        {"data": fields},
        {"data": multipart},
        {"json": {"chat_id": ada, "text": "x", "reply_markup": markup}},
    ):
        async with api.session.post(api.url("SENDMESSAGE"), **body) as response:
            assert response.status == 200, await response.text()
    async with api.session.get(api.url("sendMessage"), params=fields) as response:
        assert response.status == 200
    assert [seen["callback_data"] for seen in server.messages(ada)] == [["go"]] * 5
    assert server.violations == []


async def test_forms_say_true_and_numbers_as_text(server: FakeTelegram, api: Api, ada: int) -> None:
    fields = {"chat_id": str(ada), "text": "x", "disable_notification": "true"}
    async with api.session.post(api.url("sendMessage"), data=fields) as response:
        assert response.status == 200
    assert server.messages(ada)[0]["silent"]
    assert server.violations == []


async def test_the_bot_has_the_number_of_its_token() -> None:
    async with FakeTelegram(token="77:x") as server, Api(server) as api:  # noqa: S106 - opens nothing
        assert (await api.ok("getMe"))["id"] == 77


@pytest.mark.parametrize("body", [b"{", b"[]", b"7", b""])
async def test_a_body_that_is_no_json_object(api: Api, body: bytes) -> None:
    headers = {"Content-Type": "application/json"}
    async with api.session.post(api.url("getMe"), data=body, headers=headers) as response:
        assert response.status == (200 if body == b"" else 400)


async def test_the_record_has_every_call_and_no_token(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    await api.ok("sendMessage", chat_id=ada, text="x")
    await api.refusal("sendMessage", chat_id=1, text="x")
    await api.refusal("noSuchMethod")
    calls = [(call["method"], call["code"]) for call in server.calls]
    assert calls == [("sendMessage", 200), ("sendMessage", 400), ("noSuchMethod", 404)]
    assert server.calls[0]["parameters"] == {"chat_id": ada, "text": "x"}
    assert server.token not in str(server.changes())


async def test_logging_out_ends_everything(api: Api) -> None:
    assert await api.ok("logOut")
    assert await api.refusal("getMe") == "400 Logged out"


async def test_close_is_refused_for_ten_minutes(server: FakeTelegram, api: Api) -> None:
    answer = await api.raw("close")
    assert answer["error_code"] == 429
    assert answer["parameters"]["retry_after"] == 601
    server.advance(601)
    assert await api.ok("close")


async def test_commands_by_scope_and_language(api: Api, ada: int) -> None:
    stop = [{"command": "stop", "description": "Stop everything"}]
    halt = [{"command": "stop", "description": "Alles anhalten"}]
    mine = {"type": "chat", "chat_id": ada}
    await api.ok("setMyCommands", commands=stop)
    await api.ok("setMyCommands", commands=halt, scope=mine, language_code="de")
    assert await api.ok("getMyCommands") == stop
    assert await api.ok("getMyCommands", scope=mine) == []
    assert await api.ok("getMyCommands", scope=mine, language_code="de") == halt
    await api.ok("deleteMyCommands")
    assert await api.ok("getMyCommands") == []


@pytest.mark.parametrize(
    ("parameters", "reason"),
    [
        ({"commands": [{"command": "Stop", "description": "x"}]}, "BOT_COMMAND_INVALID"),
        ({"commands": [{"command": "/stop", "description": "x"}]}, "BOT_COMMAND_INVALID"),
        ({"commands": [{"command": "s" * 33, "description": "x"}]}, "BOT_COMMAND_INVALID"),
        (
            {"commands": [{"command": "stop", "description": ""}]},
            "BOT_COMMAND_DESCRIPTION_INVALID",
        ),
        (
            {"commands": [{"command": "stop", "description": "x"}] * 101},
            "BOT_COMMANDS_TOO_MUCH",
        ),
        ({"commands": "stop"}, "can't parse commands JSON object"),
        ({}, "can't parse commands JSON object"),
        (
            {"commands": [], "scope": {"type": "chat"}},
            "can't parse BotCommandScope: unsupported type specified",
        ),
    ],
)
async def test_commands_that_are_none(api: Api, parameters: dict[str, object], reason: str) -> None:
    assert await api.refusal("setMyCommands", **parameters) == f"400 Bad Request: {reason}"


@pytest.mark.parametrize(
    ("name", "field", "most"),
    [
        ("Name", "name", 64),
        ("Description", "description", 512),
        ("ShortDescription", "short_description", 120),
    ],
)
async def test_names_by_language(api: Api, name: str, field: str, most: int) -> None:
    await api.ok(f"setMy{name}", **{field: "plain"})
    await api.ok(f"setMy{name}", **{field: "deutsch", "language_code": "de"})
    assert await api.ok(f"getMy{name}", language_code="de") == {field: "deutsch"}
    assert await api.ok(f"getMy{name}", language_code="fr") == {field: "plain"}
    assert (await api.refusal(f"setMy{name}", **{field: "x" * (most + 1)})).startswith("400")
