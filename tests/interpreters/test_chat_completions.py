"""The adapter over real connections: one answer, or the kind of none, in bounded time."""

from __future__ import annotations

import asyncio
import json
import socket
import time
from typing import TYPE_CHECKING

import pytest
import uvloop

from rosic.contracts.interpreter import ANSWER_BYTES, AnswerKind, InterpreterAnswer
from rosic.interpreters.chat_completions import read_completion
from tests.interpreters.hostile import GOOD, bodies, chunked, dripping, endless, over_the_wire, raw
from tests.interpreters.scripted import (
    MODEL,
    Call,
    ScriptedEndpoint,
    client_of,
    completion,
    http,
    saying,
)
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tests.interpreters.scripted import Script

SHORT_S = 0.2
UNMEASURED = b"HTTP/1.1 200 OK\r\n\r\n"
WHOLE = InterpreterAnswer(AnswerKind.ANSWERED, GOOD)


@pytest.fixture
def endpoint() -> Iterator[ScriptedEndpoint]:
    with ScriptedEndpoint(saying(GOOD)) as running:
        yield running


async def asked(script: Script, timeout_s: float = SHORT_S) -> InterpreterAnswer:
    with ScriptedEndpoint(script) as endpoint:
        return await endpoint.client(timeout_s=timeout_s).ask("rules", "text")


async def test_one_call_is_one_request_as_others_make_it(endpoint: ScriptedEndpoint) -> None:
    assert await endpoint.client(key="sk-1").ask("the rules", "a text: ä") == WHOLE
    (call,) = endpoint.calls
    first, *headers = call.head.split("\r\n")
    assert first == "POST /v1/chat/completions HTTP/1.1"
    named = dict(header.split(": ", 1) for header in headers)
    assert named["Host"] == endpoint.address.removeprefix("http://")
    assert named["Content-Type"] == "application/json"
    assert named["Authorization"] == "Bearer sk-1"
    assert call.body == {
        "model": MODEL,
        "messages": [
            {"role": "system", "content": "the rules"},
            {"role": "user", "content": "a text: ä"},
        ],
        "temperature": 0.0,
        "max_tokens": 200,
        "stream": False,
    }


async def test_without_a_key_none_is_sent(endpoint: ScriptedEndpoint) -> None:
    await endpoint.client().ask("rules", "text")
    assert "authorization" not in endpoint.calls[0].head.casefold()


async def test_nothing_of_the_environment_is_used(
    endpoint: ScriptedEndpoint, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("http_proxy", "HTTP_PROXY", "all_proxy", "ALL_PROXY"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    assert await endpoint.client().ask("rules", "text") == WHOLE


@pytest.mark.parametrize(
    "data",
    [
        http(completion(GOOD)),
        b"HTTP/1.0 200 OK\r\n\r\n" + completion(GOOD),
        b"HTTP/1.1 200\r\n\r\n" + completion(GOOD),
        chunked(completion(GOOD)),
        chunked(*(bytes([byte]) for byte in completion(GOOD))),
        chunked(completion("0\r\n\r\n")),
        http(completion(GOOD), more="Content-Encoding: identity\r\nX: y\r\n"),
    ],
)
async def test_a_good_answer_is_read_however_it_is_framed(data: bytes) -> None:
    answer = await asked(raw(data), timeout_s=30)
    assert answer.kind is AnswerKind.ANSWERED
    assert answer.text in {GOOD, "0\r\n\r\n"}


async def test_a_good_answer_is_read_byte_by_byte() -> None:
    for data in (http(completion(GOOD)), chunked(completion(GOOD))):
        assert await asked(dripping(data, 0.0001), timeout_s=30) == WHOLE


async def test_a_connection_that_stays_open_is_not_waited_for() -> None:
    def answer(call: Call) -> None:
        call.send(http(completion(GOOD)))
        call.ended.wait()

    began = time.monotonic()
    assert await asked(answer, timeout_s=30 * pace()) == WHOLE
    assert time.monotonic() - began < 20 * pace()


async def test_nothing_over_the_wire_is_an_answer_that_is_none() -> None:
    with ScriptedEndpoint(saying(GOOD)) as elsewhere, ScriptedEndpoint(saying(GOOD)) as endpoint:
        client = endpoint.client(timeout_s=SHORT_S)
        for hostile in over_the_wire(f"{elsewhere.address}/v1/chat/completions"):
            endpoint.script = hostile.script
            answer = await client.ask("rules", "text")
            assert answer.kind is not AnswerKind.ANSWERED, hostile.kind
            assert answer.text == "", hostile.kind
            if hostile.slow:
                assert answer.kind is AnswerKind.LATE, hostile.kind
        assert elsewhere.calls == []


def test_no_body_but_a_good_one_is_an_answer() -> None:
    values: tuple[object, ...] = (None, 1, [], {}, {"a": 1})
    texts = [b"", *(json.dumps(value).encode() for value in values)]
    assert {read_completion(text).kind for text in texts} == {AnswerKind.UNREADABLE}
    assert read_completion(completion(GOOD)) == WHOLE


async def test_bodies_that_are_not_as_agreed_are_unreadable() -> None:
    with ScriptedEndpoint(saying(GOOD)) as endpoint:
        client = endpoint.client(timeout_s=30 * pace())
        for hostile in bodies():
            endpoint.script = hostile.script
            answer = await client.ask("rules", "text")
            kinds = {AnswerKind.UNREADABLE, AnswerKind.TOO_LARGE}
            if answer.text != "":
                assert answer.kind is AnswerKind.ANSWERED, hostile.kind
            elif answer.kind is AnswerKind.ANSWERED:
                assert hostile.kind == 'a content ""', hostile.kind
            else:
                assert answer.kind in kinds, hostile.kind


@pytest.mark.parametrize(
    ("script", "kind"),
    [
        (raw(http(b"{}", status="302 Found", more="Location: http://a\r\n")), AnswerKind.REFUSED),
        (raw(http(b"{}", status="500 No")), AnswerKind.REFUSED),
        (raw(http(b" " * (ANSWER_BYTES + 1))), AnswerKind.TOO_LARGE),
        (
            raw(b"HTTP/1.1 200 OK\r\n\r\n" + completion(GOOD).ljust(ANSWER_BYTES + 1)),
            AnswerKind.TOO_LARGE,
        ),
        (endless(b" " * 65_536, b"HTTP/1.1 200 OK\r\n\r\n"), AnswerKind.TOO_LARGE),
        (endless(b"A: b\r\n", b"HTTP/1.1 200 OK\r\n"), AnswerKind.TOO_LARGE),
        (raw(b"hello\r\n\r\n"), AnswerKind.UNREADABLE),
        (raw(http(completion(GOOD).replace(b"omni", b"\xff"))), AnswerKind.UNREADABLE),
        (raw(b""), AnswerKind.UNREACHABLE),
        (raw(http(completion(GOOD))[:-1]), AnswerKind.UNREACHABLE),
    ],
)
async def test_what_came_instead_has_a_kind(script: Script, kind: AnswerKind) -> None:
    assert (await asked(script, timeout_s=30 * pace())).kind is kind


async def test_an_answer_as_long_as_may_be_is_read() -> None:
    room = ANSWER_BYTES - len(completion(""))
    answer = await asked(saying("a" * room), timeout_s=30 * pace())
    assert (answer.kind, len(answer.text)) == (AnswerKind.ANSWERED, room)
    longer = await asked(saying("a" * (room + 1)), timeout_s=30 * pace())
    assert longer.kind is AnswerKind.TOO_LARGE


async def test_what_sends_too_much_is_cut_off() -> None:
    with ScriptedEndpoint(endless(b" " * 65_536, b"HTTP/1.1 200 OK\r\n\r\n")) as endpoint:
        answer = await endpoint.client(timeout_s=60 * pace()).ask("rules", "text")
        assert answer.kind is AnswerKind.TOO_LARGE
        await cut_off(endpoint)


async def test_whoever_gives_up_cuts_it_off() -> None:
    with ScriptedEndpoint(dripping(b" " * 10_000_000)) as endpoint:
        asking = asyncio.create_task(endpoint.client(timeout_s=60 * pace()).ask("rules", "text"))
        until = time.monotonic() + 60 * pace()
        while not endpoint.calls:
            assert time.monotonic() < until
            await asyncio.sleep(0.002)
        asking.cancel()
        await asyncio.wait((asking,))
        assert asking.cancelled()
        await cut_off(endpoint)


async def test_what_is_late_is_cut_off() -> None:
    with ScriptedEndpoint(dripping(b" " * 10_000_000)) as endpoint:
        answer = await endpoint.client(timeout_s=SHORT_S).ask("rules", "text")
        assert answer.kind is AnswerKind.LATE
        await cut_off(endpoint)


async def test_where_nobody_listens_there_is_no_answer() -> None:
    with socket.create_server(("127.0.0.1", 0)) as gone:
        port = gone.getsockname()[1]
    for address in (f"http://127.0.0.1:{port}", f"http://localhost:{port}"):
        answer = await client_of(address).ask("rules", "text")
        assert answer == InterpreterAnswer(AnswerKind.UNREACHABLE)


async def test_where_nobody_takes_the_connection_it_is_late() -> None:
    with socket.socket() as full:
        full.bind(("127.0.0.1", 0))
        full.listen(0)
        waiting = [socket.socket() for _ in range(8)]
        for one in waiting:  # so that no other finds room
            one.setblocking(False)
            one.connect_ex(full.getsockname())
        try:
            address = f"http://127.0.0.1:{full.getsockname()[1]}"
            answer = await client_of(address, timeout_s=SHORT_S).ask("rules", "text")
            assert answer.kind is AnswerKind.LATE
        finally:
            for one in waiting:
                one.close()


async def test_a_name_that_nobody_has_is_unreachable() -> None:
    answer = await client_of("http://nobody.invalid", timeout_s=30 * pace()).ask("rules", "text")
    assert answer.kind in {AnswerKind.UNREACHABLE, AnswerKind.LATE}


async def test_a_name_leads_to_whichever_of_its_addresses_listens(
    endpoint: ScriptedEndpoint,
) -> None:
    port = endpoint.address.rpartition(":")[2]
    client = client_of(f"http://localhost:{port}", timeout_s=30 * pace())
    several = await asyncio.gather(*(client.ask("rules", "text") for _ in range(4)))
    assert several == [WHOLE] * 4
    assert await client.ask("rules", "text") == WHOLE


async def test_where_tls_is_wanted_plain_words_are_no_answer() -> None:
    with socket.create_server(("127.0.0.1", 0)) as plain:
        address = f"https://127.0.0.1:{plain.getsockname()[1]}"
        asking = asyncio.create_task(client_of(address, timeout_s=30 * pace()).ask("r", "t"))
        connection, _ = await asyncio.to_thread(plain.accept)
        with connection:
            connection.sendall(http(completion(GOOD)))
            answer = await asking
    assert answer.kind is AnswerKind.UNREACHABLE


async def cut_off(endpoint: ScriptedEndpoint) -> None:
    """Wait until the server has noticed that nobody takes what it sends."""
    until = time.monotonic() + 60 * pace()
    while not endpoint.idle:
        assert time.monotonic() < until, "the connection is still open"
        await asyncio.sleep(0.005)


def test_it_is_the_same_on_the_faster_loop() -> None:
    scripts = (
        saying(GOOD),
        raw(http(b" " * 400_000)),
        endless(b" " * 65_536, UNMEASURED),
        raw(chunked(completion(GOOD))),
        raw(b""),
    )

    async def kinds() -> list[AnswerKind]:
        found = [await asked(script, timeout_s=30 * pace()) for script in scripts]
        return [each.kind for each in (*found, await asked(dripping(b" " * 10_000)))]

    with asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner:
        assert runner.run(kinds()) == [
            AnswerKind.ANSWERED,
            AnswerKind.TOO_LARGE,
            AnswerKind.TOO_LARGE,
            AnswerKind.ANSWERED,
            AnswerKind.UNREACHABLE,
            AnswerKind.LATE,
        ]
