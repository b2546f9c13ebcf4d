"""How long the loop that receives waits when Telegram does not answer, and whom it tells."""

from __future__ import annotations

import asyncio
import errno
import json
from types import SimpleNamespace

import pytest
from telegram.error import Conflict, Forbidden, InvalidToken, NetworkError

from rosic.core.secret import Secret
from rosic.core.time_units import SECOND_NS
from rosic.errors import MessengerFault
from rosic.messengers.telegram.bot_client import (
    CALL_S,
    BotClient,
    _retry_after_s,
    polled_within_s,
)
from rosic.messengers.telegram.errors import DEFAULT_WAIT_S, ErrorKind, FloodControl, TelegramError
from rosic.messengers.telegram.polling import AWAKE_S
from rosic.messengers.telegram.polling_gap import CALM_NS
from rosic.messengers.telegram.settings import TelegramSettings
from rosic.testing.clock import ManualClock
from tests.messengers.inbox import POLL_S, HarnessInbox, Held, text

ME = SimpleNamespace(username="lab_bot", can_read_all_group_messages=True)


async def test_it_waits_longer_and_longer_until_telegram_answers_and_then_anew(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level("INFO")
    away = NetworkError("away")
    inbox = HarnessInbox(*[away] * 5, [], [], away, [])
    async with inbox.listening(30.0):
        assert inbox.asked_at_s == [0.0, 0.5, 1.5, 3.5, 7.5, *[11.5] * 3, 12.0, 12.0]
    said = [each for each in caplog.messages if "away" in each or "answers again" in each]
    assert ["again" in each for each in said] == [False, True, False, True], "each once"


async def test_it_waits_as_long_as_telegram_says_but_not_for_ever() -> None:
    inbox = HarnessInbox(FloodControl(7.0), FloodControl(3600.0), [])
    async with inbox.listening(100.0):
        assert inbox.asked_at_s == [0.0, 7.0, 67.0, 67.0]


async def test_a_gap_while_telegram_was_away_is_a_backlog() -> None:
    away = NetworkError("away")
    inbox = HarnessInbox([], *[away] * 4, [text(1, "old")], [], [])
    async with inbox.listening(30.0):
        assert inbox.heard[0].listening_since_ns == inbox.heard[0].received_ns + 1
        assert not inbox.listener.catching_up


async def test_what_was_sent_while_the_network_was_away_says_so_until_all_of_it_has_come() -> None:
    away = NetworkError("away")
    away.__cause__ = OSError(errno.ENETUNREACH, "Network is unreachable")
    sent_s = ManualClock().wall_ns() // SECOND_NS + 5
    while_away = Held(away, polled_within_s(POLL_S) + AWAKE_S / 2)
    inbox = HarnessInbox(
        [], while_away, [text(1, "old", date=sent_s)], [], [text(2, "late", date=sent_s)]
    )
    async with inbox.listening(60.0):
        found = [(inbound.text, inbound.network_away) for inbound in inbox.heard]
        assert found == [("old", True), ("late", False)]


async def test_what_was_sent_before_it_knew_who_it_is_was_sent_while_the_network_was_away() -> None:
    away = NetworkError("away")
    away.__cause__ = OSError(errno.ENETUNREACH, "Network is unreachable")
    account = SimpleNamespace(username="lab_bot", can_read_all_group_messages=True)
    while_away = Held(away, CALL_S + AWAKE_S / 2)
    sent_s = ManualClock().wall_ns() // SECOND_NS + 5
    inbox = HarnessInbox([text(1, "old", date=sent_s)], who=[while_away, account])
    async with inbox.listening(60.0):
        assert [inbound.network_away for inbound in inbox.heard] == [True]


@pytest.mark.parametrize("reason", ["terminated by other getUpdates request", "Webhook is active"])
async def test_somebody_else_who_receives_is_said_once_and_motion_waits_until_it_is_calm(
    reason: str,
) -> None:
    inbox = HarnessInbox([], Conflict(reason), Conflict(reason), [text(1, "move")], [])
    async with inbox.listening():
        assert inbox.listener.catching_up
        await inbox.clock.advance(4.0)
        assert inbox.asked_at_s[:4] == [0.0, 0.0, 2.0, 4.0]
        assert inbox.heard[0].listening_since_ns == inbox.heard[0].received_ns + 1
        assert inbox.listener.catching_up, "empty, but somebody may have taken it"
        assert [asked.timeout_s for asked in inbox.bot.asked] == [0] + [POLL_S] * 5
        (alarm,) = inbox.alarms
        assert ("webhook is set" in str(alarm)) is reason.startswith("Webhook")
        assert ("Another program receives" in str(alarm)) is not reason.startswith("Webhook")
        assert "the bot of lab" in str(alarm)
    inbox = HarnessInbox([], Conflict(reason), NetworkError("a moment"), [], Conflict(reason))
    async with inbox.listening(CALM_NS / SECOND_NS):
        assert len(inbox.alarms) == 1, "it was not calm in between"


async def test_somebody_else_is_noticed_from_the_first_request_on() -> None:
    inbox = HarnessInbox(Conflict("a"), Conflict("a"), [])
    async with inbox.listening(10.0):
        assert len(inbox.alarms) == 1


async def test_it_is_said_again_when_it_happens_again(caplog: pytest.LogCaptureFixture) -> None:
    inbox = HarnessInbox([], Conflict("a"), *[NetworkError("wait")] * 6, [], Conflict("b"))
    async with inbox.listening(60.0):
        assert [asked.timeout_s for asked in inbox.bot.asked][-3:] == [0, POLL_S, POLL_S]
        again, over, once_more = inbox.alarms  # what the admins hear: of each, and that one ended
        assert str(again) == str(once_more) != str(over)
        assert "Nobody else receives the messages of the bot of lab any more." in str(over)
        assert [each for each in caplog.messages if "Another program" in each]


async def test_a_token_that_is_no_longer_accepted_ends_it() -> None:
    inbox = HarnessInbox([], InvalidToken("no"), who=[ME, InvalidToken("no"), InvalidToken("no")])
    async with inbox.listening(6.9) as task:
        assert not task.done()
        assert inbox.alarms == []
        await inbox.clock.advance(0.1)
        fault = task.exception()
        assert type(fault) is MessengerFault
        assert "no longer accepts the token of the messenger lab" in str(fault)
        assert list(map(str, inbox.alarms)) == [str(fault)]


@pytest.mark.parametrize("then", [ME, NetworkError("away")])
async def test_one_denial_is_not_believed(then: object, caplog: pytest.LogCaptureFixture) -> None:
    inbox = HarnessInbox([], InvalidToken("no"), [text(1, "hello")], who=[ME, then])
    async with inbox.listening(3.0):
        assert inbox.texts == ["hello"]
        assert inbox.alarms == []
        assert "no longer accepts the token of the messenger lab." in caplog.text
    inbox = HarnessInbox([text(1, "hello")], who=[InvalidToken("no"), ME])
    async with inbox.listening(3.0):
        assert inbox.texts == ["hello"]


async def test_who_cannot_be_asked_again_is_waited_for_like_any_other() -> None:
    inbox = HarnessInbox([], InvalidToken("no"), [text(1, "hello")], who=[ME, NetworkError("away")])
    async with inbox.listening(2.4):
        assert inbox.texts == [], "asked again after 2 s, in vain, and then waited for"
        await inbox.clock.advance(0.2)
        assert inbox.texts == ["hello"]


async def _answers(status: str, body: bytes, kind: str) -> ErrorKind:
    """Return what a call is that a server answers so."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        head = f"HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {len(body)}\r\n"
        writer.write(f"{head}Connection: close\r\n\r\n".encode() + body)
        await writer.drain()
        writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    line = BotClient(
        TelegramSettings(token=Secret("42:token"), api_base=f"http://127.0.0.1:{port}/bot")
    )
    async with server:
        with pytest.raises(TelegramError) as caught:
            await line.updates(None, 0, (), 1)
        with pytest.raises(TelegramError) as again:
            await line.ask(lambda bot: bot.get_me())
    assert again.value.kind is caught.value.kind
    return caught.value.kind


@pytest.mark.parametrize("status", ["404 Not Found", "401 Unauthorized"])
async def test_only_the_bot_api_itself_denies_a_token(status: str) -> None:
    """A proxy, or a server that is just starting again, answers with a page of its own."""
    said = json.dumps({"ok": False, "error_code": int(status[:3]), "description": status}).encode()
    other = json.dumps({"error": status}).encode()

    assert await _answers(status, said, "application/json") is ErrorKind.UNUSABLE
    assert await _answers(status, other, "application/json") is ErrorKind.LOST
    assert await _answers(status, b"<html>nginx</html>", "text/html") is ErrorKind.LOST


async def test_a_wait_that_is_no_number_is_the_usual_one() -> None:
    line = b'{"ok":false,"error_code":429,"parameters":{"retry_after":NaN}}'
    assert await _answers("429 Too Many Requests", line, "application/json") is ErrorKind.TOO_FAST
    assert _retry_after_s(line) == DEFAULT_WAIT_S
    assert _retry_after_s(line.replace(b"NaN", b"1e999")) == DEFAULT_WAIT_S


async def test_any_other_refusal_is_waited_out() -> None:
    inbox = HarnessInbox([], Forbidden("odd"), [text(1, "hello")])
    async with inbox.listening(1.0):
        assert inbox.texts == ["hello"]
