"""What the loop that receives asks of Telegram, and in which order it hands over what came."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import TYPE_CHECKING

import msgspec
import pytest
from telegram.error import InvalidToken, NetworkError

from rosic.core.message import Button, Chat, ChatEvent, ChatEventKind, Outbound
from rosic.core.time_units import SECOND_NS
from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.telegram import update_window
from rosic.messengers.telegram.chats import Chats
from rosic.messengers.telegram.errors import ErrorKind, FloodControl, TelegramError
from rosic.messengers.telegram.messenger import TelegramMessenger
from rosic.messengers.telegram.polling import FULL_S, PEEK_S, Poller
from rosic.messengers.telegram.polling_gap import GRACE_NS
from rosic.messengers.telegram.reading import ANSWER_BYTES, BATCH
from rosic.messengers.telegram.settings import API_BASE, read_settings
from rosic.messengers.telegram.update_window import OVERDUE_AT_MOST
from rosic.testing.clock import settle
from tests.messengers.inbox import (
    ADA,
    EVE,
    LAB,
    POLL_S,
    Asked,
    HarnessInbox,
    member,
    person,
    raw,
    tap,
    text,
)

if TYPE_CHECKING:
    from rosic.core.identity import Address

# ---- who we are ----


@pytest.mark.parametrize("all_heard", [True, False])
async def test_it_finds_out_who_it_is_and_what_it_hears_in_groups(
    caplog: pytest.LogCaptureFixture, *, all_heard: bool
) -> None:
    me = SimpleNamespace(username="lab_bot", can_read_all_group_messages=all_heard)
    inbox = HarnessInbox(who=[me])
    assert inbox.listener.reading.own_name == ""
    assert inbox.listener.catching_up
    async with inbox.listening():
        assert inbox.listener.reading.own_name == "lab_bot"
        assert bool([each for each in caplog.messages if "/setprivacy" in each]) is not all_heard
        assert [(each.what, each.chat.id) for each in inbox.passed] == [
            (ChatEventKind.HEARING if all_heard else ChatEventKind.DEAF, "")
        ]
        assert inbox.listener.catching_up


async def test_what_a_group_lets_it_hear_hangs_on_what_it_hears_everywhere() -> None:
    """Put into a group, it says that it is deaf there only where it is."""
    for all_heard in (True, False):
        me = SimpleNamespace(username="lab_bot", can_read_all_group_messages=all_heard)
        inbox = HarnessInbox([member(1, "left", "member")], who=[me])
        async with inbox.listening():
            assert inbox.passed[-1].what is ChatEventKind.ADDED
            assert inbox.passed[-1].deaf is not all_heard


async def test_a_token_that_is_not_accepted_is_the_operators_business() -> None:
    inbox = HarnessInbox(who=[InvalidToken("no")] * 3)
    async with inbox.listening(6.9) as task:
        assert not task.done()
        await inbox.clock.advance(0.1)
        assert isinstance(task.exception(), ConfigurationError)
        assert len(inbox.alarms) == 1, "whoever is reached otherwise is told"
        assert "does not accept the token of the messenger lab" in str(task.exception())
    inbox = HarnessInbox(who=[InvalidToken("no"), NetworkError("away")])
    with pytest.raises(ConfigurationError):
        await inbox.listener.ask_account()
    with pytest.raises(TelegramError) as caught:
        await inbox.listener.ask_account()
    assert caught.value.kind is not ErrorKind.UNUSABLE


@pytest.mark.parametrize(
    ("api_base", "hint"),
    [(API_BASE, "BotFather shows it again"), ("http://127.0.0.1:1/bot", "another server")],
)
async def test_whoever_gave_a_token_hears_where_the_right_one_is(api_base: str, hint: str) -> None:
    inbox = HarnessInbox(who=[InvalidToken("no")], api_base=api_base)
    with pytest.raises(ConfigurationError) as caught:
        await inbox.listener.ask_account()
    assert hint in caught.value.hint


async def test_it_asks_who_it_is_until_telegram_says_so() -> None:
    nameless = SimpleNamespace(username=None, can_read_all_group_messages=None)
    inbox = HarnessInbox(who=[NetworkError("away"), FloodControl(7.0), nameless])
    async with inbox.listening(0.5):
        await inbox.clock.advance(6.9)
        assert inbox.bot.asked == []
        await inbox.clock.advance(0.1)
        assert inbox.asked_at_s == [7.5]
        assert inbox.listener.reading.own_name == ""


# ---- what is asked for ----


async def test_the_first_empty_answer_ends_the_backlog() -> None:
    inbox = HarnessInbox([text(7, "old")], [], [text(8, "new")])
    async with inbox.listening():
        first, second, third, *_ = inbox.bot.asked
        assert (first.offset, first.timeout_s, first.limit) == (None, 0, BATCH)
        assert (second.offset, second.timeout_s) == (8, 0)
        assert (third.offset, third.timeout_s) == (None, POLL_S), "it listens: it may wait now"
        assert inbox.bot.asked[3].offset == 9
        old, new = inbox.heard
        assert old.listening_since_ns == old.received_ns + 1
        assert new.listening_since_ns == new.received_ns - GRACE_NS
        assert not inbox.listener.catching_up


async def test_whoever_listens_again_begins_with_a_backlog() -> None:
    inbox = HarnessInbox([])
    async with inbox.listening():
        assert not inbox.listener.catching_up
    again = asyncio.ensure_future(inbox.listener.run(inbox.receive, inbox.hooks))
    inbox.bot._who.append(SimpleNamespace(username="lab_bot", can_read_all_group_messages=True))
    await settle()
    assert inbox.listener.catching_up
    again.cancel()


async def test_a_full_answer_that_was_seen_before_hides_what_is_behind_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As it comes once more while nothing of it can be confirmed: too much is overdue already."""
    monkeypatch.setattr(update_window, "HELD_NS", 3_600 * SECOND_NS)  # nothing is given up yet
    answers = [
        [text(number, "slow") for number in range(first, first + BATCH)]
        for first in range(0, OVERDUE_AT_MOST + 1, BATCH)
    ]
    inbox = HarnessInbox(*answers, answers[-1])
    inbox.held_up["slow"] = asyncio.Event()
    async with inbox.listening(len(answers) * FULL_S + PEEK_S):
        assert [asked.offset for asked in inbox.bot.asked[-2:]] == [None, None]
        assert inbox.listener.catching_up
        inbox.held_up["slow"].set()
        for _ in range(60):
            await settle()
        assert inbox.listener.counts["received"] == OVERDUE_AT_MOST + BATCH, "each once"


async def test_after_a_long_answer_fewer_are_asked_for_and_then_more_again() -> None:
    long = text(1, "x" * ANSWER_BYTES)
    inbox = HarnessInbox([long], [text(2, "short")], [text(3, "short")])
    async with inbox.listening():
        assert [asked.limit for asked in inbox.bot.asked] == [BATCH, BATCH // 2, BATCH, BATCH]


async def test_an_answer_is_full_by_what_was_asked_for() -> None:
    """Half a hundred are a full answer when half a hundred were asked for."""
    half = [text(number, "status") for number in range(2, 2 + BATCH // 2)]
    inbox = HarnessInbox([text(1, "x" * ANSWER_BYTES)], half, half)
    async with inbox.listening():
        assert inbox.bot.asked[1].limit == BATCH // 2
        assert inbox.listener.catching_up


async def test_what_is_not_settled_is_not_confirmed_and_asked_for_again_at_once() -> None:
    settled, asked_within_s = [False, False, True], []

    async def settle_first(within_s: float) -> bool:
        asked_within_s.append(within_s)
        return settled.pop(0) if settled else True

    inbox = HarnessInbox(
        [], [text(1, "one")], [text(1, "one")], [text(1, "one"), text(2, "stop")], []
    )
    inbox.hooks = inbox.hooks._replace(settle=settle_first)
    async with inbox.listening():
        assert [(a.offset, a.timeout_s) for a in inbox.bot.asked] == [
            (None, 0),
            (None, POLL_S),
            (None, 0),
            (None, 0),
            (3, POLL_S),
            (None, POLL_S),
        ]
        assert inbox.texts == ["one", "stop"]
        assert asked_within_s[:3] == [PEEK_S] * 3


async def test_nothing_is_received_until_somebody_says_what_may_be_confirmed() -> None:
    inbox = HarnessInbox([text(1, "omni move 1 m")], [])
    settings = read_settings("lab", {"token": "42:token"})
    messenger = TelegramMessenger("lab", settings, inbox.clock, line=inbox.line)
    with pytest.raises(MessengerFault, match="lab was not told what is on disk, so it rec"):
        await messenger.run(inbox.receive)
    assert inbox.bot.asked == []
    assert inbox.heard == []


async def test_that_a_group_moved_is_told_before_anything_is_received_too() -> None:
    """Speaking to it finds that out, and whoever watches may fail at it."""
    inbox = HarnessInbox()
    settings = read_settings("lab", {"token": "42:token"})
    messenger = TelegramMessenger("lab", settings, inbox.clock, line=inbox.line)
    messenger.watch_chats(inbox.passed.append)
    messenger._speaker._chats.moved("-5", "-1005")
    assert [(each.what, each.chat.id, each.new_id) for each in inbox.passed] == [
        (ChatEventKind.MOVED, "-5", "-1005")
    ]

    def breaks(_what: object) -> None:
        raise RuntimeError("somebody's mistake")

    messenger.watch_chats(breaks)
    messenger._speaker._chats.moved("-6", "-1006")
    assert messenger._speaker._chats.where("-6") == "-1006"


async def test_while_something_is_received_it_looks_for_stops_behind_it() -> None:
    inbox = HarnessInbox([], [text(1, "slow")], [text(1, "slow"), text(2, "stop")], [])
    inbox.held_up["slow"] = asyncio.Event()
    async with inbox.listening():
        assert [(a.at_s, a.timeout_s) for a in inbox.bot.asked] == [(0.0, 0), (0.0, POLL_S)]
        await inbox.clock.advance(PEEK_S)
        assert inbox.bot.asked[2] == Asked(PEEK_S, None, 0, BATCH)
        assert inbox.texts == ["slow", "stop"]
        inbox.held_up["slow"].set()
        await inbox.clock.advance(PEEK_S)
        assert inbox.listener.counts["received"] == 2


async def test_updates_without_a_number_are_not_asked_for_in_a_circle() -> None:
    odd = msgspec.Raw(b'{"message": {}}')
    inbox = HarnessInbox([odd], [odd], [odd, text(1, "one")], [])
    async with inbox.listening(5.0):
        assert inbox.asked_at_s == [0.0, 0.5, 1.0, 1.0, 1.0]
        assert inbox.texts == ["one"]


# ---- in which order ----


async def test_a_stop_goes_first_then_those_who_are_known_and_strangers_last() -> None:
    inbox = HarnessInbox(
        [
            text(1, "hello", EVE),
            text(2, "stop", EVE),
            text(3, "status", chat=LAB),
            text(4, "battery", chat=LAB),
            text(5, "stop", chat=LAB),
            text(6, "where"),
        ]
    )
    inbox.hooks = inbox.hooks._replace(known=lambda address: address.account == str(ADA))
    async with inbox.listening():
        assert inbox.texts[0] == "stop"
        assert inbox.heard[0].sender.account == str(ADA)
        of_eve = [each.text for each in inbox.heard if each.sender.account == str(EVE)]
        assert of_eve == ["hello", "stop"], "whom nobody knows stops nothing"
        assert [said for said in inbox.texts if said in {"status", "battery"}] == [
            "status",
            "battery",
        ]


async def test_everybody_is_read_before_strangers_are() -> None:
    """What reading a stranger's message costs is paid after a stop has been found."""
    asked: list[str] = []

    def known(address: Address) -> bool:
        asked.append(address.account)
        return address.account == str(ADA)

    offered: list[str] = []

    class Watched(Chats):
        def back(self, chat: str) -> None:
            offered.append(chat)
            super().back(chat)

    inbox = HarnessInbox()
    inbox.chats = Watched(inbox.moved)
    inbox.bot.answers = [[text(1, "x", EVE), text(2, "y", EVE), text(3, "stop"), text(4, "z", EVE)]]
    inbox.listener = Poller(
        "lab", inbox.line, inbox.chats, inbox.clock, POLL_S, inbox.alarms.append
    )
    inbox.hooks = inbox.hooks._replace(known=known)
    async with inbox.listening():
        assert offered == [str(who) for who in (ADA, EVE, EVE, EVE)]
        assert asked == [str(who) for who in (EVE, EVE, ADA, EVE)]


async def test_a_hundred_long_messages_are_many_steps_of_the_loop() -> None:
    """Whatever else is to be done is done between them: first they are read, then looked at."""
    steps, until_heard = 0, 0
    heard = asyncio.Event()

    async def others() -> None:
        nonlocal steps
        while True:
            await asyncio.sleep(0)
            steps += 1

    async def receive(_inbound: object) -> None:
        nonlocal until_heard
        until_heard = until_heard or steps
        heard.set()

    inbox = HarnessInbox([text(number, "x" * 4_096) for number in range(BATCH)])
    other = asyncio.ensure_future(others())
    listening = asyncio.ensure_future(inbox.listener.run(receive, inbox.hooks))
    await heard.wait()
    listening.cancel()
    other.cancel()
    assert until_heard > 2 * BATCH


async def test_a_tap_on_stop_overtakes_what_waits_and_any_other_tap_does_not() -> None:
    stop, other = Button("Stop", "stop", nonce="n1"), Button("Menu", "menu", nonce="n2")
    inbox = HarnessInbox([], [text(1, "slow")], [tap(2, "n2"), tap(3, "n1")])
    inbox.chats.offered(
        Outbound(chat=Chat("telegram", str(ADA)), text="?", buttons=((stop, other),))
    )
    inbox.held_up["slow"] = asyncio.Event()
    async with inbox.listening(PEEK_S):
        assert [each.nonce for each in inbox.heard] == [None, "n1"]


# ---- what is passed over ----


async def test_what_is_malformed_is_counted_once_and_hides_nothing() -> None:
    """Also when it is given out again because nothing could be confirmed yet."""
    settled = [False]

    async def settle_later(_within_s: float) -> bool:
        return settled.pop() if settled else True

    batch = [raw(1, message={"message_id": "x"}), text(2, "one"), text(3, "two", EVE)]
    inbox = HarnessInbox(batch, batch, [])
    inbox.hooks = inbox.hooks._replace(settle=settle_later)
    async with inbox.listening(PEEK_S):
        assert sorted(inbox.texts) == ["one", "two"]
        assert inbox.listener.counts == {"malformed": 1, "passed-over": 1, "received": 2}
        assert [asked.offset for asked in inbox.bot.asked] == [None, None, 4, None]


async def test_what_is_for_nobody_is_confirmed() -> None:
    inbox = HarnessInbox([raw(1), raw(2, poll={})], [])
    async with inbox.listening():
        assert inbox.heard == []
        assert inbox.bot.asked[1].offset == 3


async def test_what_happens_to_chats_is_passed_on_and_followed() -> None:
    moved = text(4, "", chat=LAB, migrate_to_chat_id=-1009)
    reaction = raw(
        5,
        message_reaction={
            "chat": {"id": LAB, "type": "supergroup"},
            "message_id": 9,
            "user": person(ADA),
            "old_reaction": [],
            "new_reaction": [{"type": "emoji", "emoji": "👍"}],
        },
    )
    inbox = HarnessInbox(
        [member(1, "member", "left")], [member(2, "left", "member")], [moved, reaction]
    )
    gone: list[bool] = []

    def passed(what: ChatEvent) -> None:
        inbox.passed.append(what)
        gone.append(inbox.chats.gone(str(LAB)))

    inbox.hooks = inbox.hooks._replace(passed=passed)
    async with inbox.listening():
        assert [each.what for each in inbox.passed] == [
            ChatEventKind.HEARING,
            ChatEventKind.REMOVED,
            ChatEventKind.ADDED,
            ChatEventKind.MOVED,
        ]
        assert gone == [False, True, False, False]
        assert (inbox.passed[-1].chat.id, inbox.passed[-1].new_id) == (str(LAB), "-1009")
        assert inbox.chats.where(str(LAB)) == "-1009"
        assert [each.emoji for each in inbox.reacted] == [("👍",)]


async def test_whoever_speaks_in_a_chat_has_let_us_in_again() -> None:
    inbox = HarnessInbox([member(1, "member", "left")], [text(2, "status", chat=LAB)])
    async with inbox.listening():
        assert not inbox.chats.gone(str(LAB))


async def test_whatever_goes_wrong_with_what_is_passed_on_nobody_is_kept_waiting() -> None:
    def breaks(_what: object) -> None:
        raise RuntimeError("somebody's mistake")

    inbox = HarnessInbox([member(1, "left", "member"), text(2, "stop")], [])
    inbox.hooks = inbox.hooks._replace(passed=breaks)
    async with inbox.listening():
        assert inbox.texts == ["stop"]
        assert not inbox.listener.catching_up


@pytest.mark.parametrize(("ahead_s", "counted"), [(2, 0), (3, 1)])
async def test_a_message_from_the_future_says_that_the_clock_is_behind(
    ahead_s: int, counted: int
) -> None:
    inbox = HarnessInbox()
    date = inbox.clock.wall_ns() // SECOND_NS + ahead_s
    inbox.bot.answers = [[text(1, "hello", date=date), tap(2, "n")]]
    async with inbox.listening():
        assert len(inbox.heard) == 2
        assert inbox.listener.counts["clock-behind"] == counted


async def test_the_clock_is_complained_of_once_in_a_hundred_times(
    caplog: pytest.LogCaptureFixture,
) -> None:
    inbox = HarnessInbox()
    date = inbox.clock.wall_ns() // SECOND_NS + 60
    inbox.bot.answers = [
        [text(number, "hello", date=date) for number in range(100)],
        [text(100, "hello", date=date)],
    ]
    async with inbox.listening():
        assert inbox.listener.counts["clock-behind"] == 101
        complaints = [each for each in caplog.messages if "behind Telegram's" in each]
        assert len(complaints) == 2
        assert "at least 60 s behind" in complaints[0]


async def test_messages_from_before_the_accounts_time_go_without_its_number() -> None:
    inbox = HarnessInbox()
    now_s = inbox.clock.wall_ns() // SECOND_NS
    inbox.bot.answers = [[text(1, "then", date=now_s - 1), text(2, "now", date=now_s)]]
    inbox.hooks = inbox.hooks._replace(account_since_ns=now_s * SECOND_NS)
    async with inbox.listening():
        assert {each.text: each.account for each in inbox.heard} == {"then": "", "now": "42"}


@pytest.mark.parametrize("several", [True, False])
async def test_what_several_bots_hear_in_a_small_group_is_known_to_each_by_the_same(
    *, several: bool
) -> None:
    """There each bot counts messages by itself; a bot that is alone shares nothing."""
    known = []
    for number in (7, 900):
        inbox = HarnessInbox()
        date = inbox.clock.wall_ns() // SECOND_NS
        small = {"id": -5, "type": "group", "title": "Lab"}
        inbox.bot.answers = [
            [
                raw(
                    number,
                    message={
                        "message_id": number,
                        "date": date,
                        "chat": small,
                        "from": person(ADA),
                        "text": "omni wave",
                    },
                )
            ]
        ]
        inbox.hooks = inbox.hooks._replace(one_of_several=several)
        async with inbox.listening():
            known += [each.shared for each in inbox.heard]
    assert len(known) == 2
    assert known[0] == known[1]
    assert bool(known[0]) is several
