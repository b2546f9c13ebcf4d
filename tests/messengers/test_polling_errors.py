"""How long the loop that receives waits when Telegram does not answer, and whom it tells."""

from __future__ import annotations

import errno
from types import SimpleNamespace

import pytest
from telegram.error import Conflict, Forbidden, InvalidToken, NetworkError

from rosic.core.time_units import SECOND_NS
from rosic.errors import MessengerFault
from rosic.messengers.telegram.bot_client import CALL_S, polled_within_s
from rosic.messengers.telegram.errors import FloodControl
from rosic.messengers.telegram.polling import AWAKE_S
from rosic.messengers.telegram.polling_gap import CALM_NS
from rosic.testing.clock import ManualClock
from tests.messengers.inbox import POLL_S, HarnessInbox, Held, text


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
    inbox = HarnessInbox([], InvalidToken("no"))
    async with inbox.listening() as task:
        fault = task.exception()
        assert type(fault) is MessengerFault
        assert "no longer accepts the token of the messenger lab" in str(fault)


async def test_any_other_refusal_is_waited_out() -> None:
    inbox = HarnessInbox([], Forbidden("odd"), [text(1, "hello")])
    async with inbox.listening(1.0):
        assert inbox.texts == ["hello"]
