"""What the loop that receives asks of Telegram, and in which order it hands over what came."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import TYPE_CHECKING

import msgspec
import pytest
from telegram.error import InvalidToken, NetworkError

from rosic.core.message import Button, Chat, Outbound, Passage, Passing
from rosic.core.time_units import SECOND_NS
from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.telegram.batch import ANSWER_BYTES, BATCH
from rosic.messengers.telegram.chats import Chats
from rosic.messengers.telegram.errors import ErrorKind, TelegramError, TooFast
from rosic.messengers.telegram.polling import PEEK_S, Poller
from rosic.messengers.telegram.polling_gap import GRACE_NS
from rosic.testing.clock import settle
from rosic.testing.messenger_stage import settled
from tests.messengers.ear import ADA, EVE, LAB, POLL_S, Asked, Ear, member, person, raw, tap, text

if TYPE_CHECKING:
    from rosic.core.identity import Address

# ---- who we are ----


@pytest.mark.parametrize("all_heard", [True, False])
async def test_it_finds_out_who_it_is_and_what_it_hears_in_groups(
    caplog: pytest.LogCaptureFixture, *, all_heard: bool
) -> None:
    me = SimpleNamespace(username="lab_bot", can_read_all_group_messages=all_heard)
    ear = Ear(who=[me])
    assert ear.listener.reading.own_name == ""
    assert ear.listener.catching_up
    async with ear.listening():
        assert ear.listener.reading.own_name == "lab_bot"
        assert bool([each for each in caplog.messages if "/setprivacy" in each]) is not all_heard
        assert [(each.what, each.chat.id) for each in ear.passed] == [
            (Passage.HEARING if all_heard else Passage.DEAF, "")
        ]
        assert ear.listener.catching_up


async def test_what_a_group_lets_it_hear_hangs_on_what_it_hears_everywhere() -> None:
    """Put into a group, it says that it is deaf there only where it is."""
    for all_heard in (True, False):
        me = SimpleNamespace(username="lab_bot", can_read_all_group_messages=all_heard)
        ear = Ear([member(1, "left", "member")], who=[me])
        async with ear.listening():
            assert ear.passed[-1].what is Passage.ADDED
            assert ear.passed[-1].deaf is not all_heard


async def test_a_token_that_is_not_accepted_is_the_operators_business() -> None:
    ear = Ear(who=[InvalidToken("no")])
    async with ear.listening() as task:
        assert isinstance(task.exception(), ConfigurationError)
        assert "does not accept the token of the messenger lab" in str(task.exception())
    ear = Ear(who=[InvalidToken("no"), NetworkError("away")])
    with pytest.raises(ConfigurationError):
        await ear.listener.ask_account()
    with pytest.raises(TelegramError) as caught:
        await ear.listener.ask_account()
    assert caught.value.kind is not ErrorKind.UNUSABLE


async def test_it_asks_who_it_is_until_telegram_says_so() -> None:
    nameless = SimpleNamespace(username=None, can_read_all_group_messages=None)
    ear = Ear(who=[NetworkError("away"), TooFast(7.0), nameless])
    async with ear.listening(0.5):
        await ear.clock.advance(6.9)
        assert ear.bot.asked == []
        await ear.clock.advance(0.1)
        assert ear.asked_at_s == [7.5]
        assert ear.listener.reading.own_name == ""


# ---- what is asked for ----


async def test_the_first_empty_answer_ends_the_backlog() -> None:
    ear = Ear([text(7, "old")], [], [text(8, "new")])
    async with ear.listening():
        first, second, third, *_ = ear.bot.asked
        assert (first.offset, first.timeout_s, first.limit) == (None, 0, BATCH)
        assert (second.offset, second.timeout_s) == (8, 0)
        assert (third.offset, third.timeout_s) == (None, POLL_S), "it listens: it may wait now"
        assert ear.bot.asked[3].offset == 9
        old, new = ear.heard
        assert old.listening_since_ns == old.received_ns + 1
        assert new.listening_since_ns == new.received_ns - GRACE_NS
        assert not ear.listener.catching_up


async def test_whoever_listens_again_begins_with_a_backlog() -> None:
    ear = Ear([])
    async with ear.listening():
        assert not ear.listener.catching_up
    again = asyncio.ensure_future(ear.listener.run(ear.receive))
    ear.bot._who.append(SimpleNamespace(username="lab_bot", can_read_all_group_messages=True))
    await settle()
    assert ear.listener.catching_up
    again.cancel()


async def test_a_full_answer_that_was_seen_before_hides_what_is_behind_it() -> None:
    """As it comes once more while nothing of it can be confirmed."""
    settled = [False, False]

    async def settle_later(_within_s: float) -> bool:
        return settled.pop() if settled else True

    full = [text(number, "status") for number in range(BATCH)]
    ear = Ear(full, full, full)
    ear.listener.settle = settle_later
    async with ear.listening():
        assert ear.listener.counts["received"] == BATCH, "nothing is handed over twice"
        assert ear.listener.catching_up


async def test_after_a_long_answer_fewer_are_asked_for_and_then_more_again() -> None:
    long = text(1, "x" * ANSWER_BYTES)
    ear = Ear([long], [text(2, "short")], [text(3, "short")])
    async with ear.listening():
        assert [asked.limit for asked in ear.bot.asked] == [BATCH, BATCH // 2, BATCH, BATCH]


async def test_an_answer_is_full_by_what_was_asked_for() -> None:
    """Half a hundred are a full answer when half a hundred were asked for."""
    half = [text(number, "status") for number in range(2, 2 + BATCH // 2)]
    ear = Ear([text(1, "x" * ANSWER_BYTES)], half, half)
    async with ear.listening():
        assert ear.bot.asked[1].limit == BATCH // 2
        assert ear.listener.catching_up


async def test_what_is_not_settled_is_not_confirmed_and_asked_for_again_at_once() -> None:
    settled, asked_within_s = [False, False, True], []

    async def settle_first(within_s: float) -> bool:
        asked_within_s.append(within_s)
        return settled.pop(0) if settled else True

    ear = Ear([], [text(1, "one")], [text(1, "one")], [text(1, "one"), text(2, "stop")], [])
    ear.listener.settle = settle_first
    async with ear.listening():
        assert [(a.offset, a.timeout_s) for a in ear.bot.asked] == [
            (None, 0),
            (None, POLL_S),
            (None, 0),
            (None, 0),
            (3, POLL_S),
            (None, POLL_S),
        ]
        assert ear.texts == ["one", "stop"]
        assert asked_within_s[:3] == [PEEK_S] * 3


async def test_nothing_is_received_until_somebody_says_what_may_be_confirmed() -> None:
    ear = Ear([text(1, "omni move 1 m")], [])
    ear.listener.settle = None
    async with ear.listening() as listening:
        with pytest.raises(MessengerFault, match="lab was not told what is on disk, so it rec"):
            listening.result()
    assert ear.bot.asked == []
    assert ear.heard == []


async def test_while_something_is_received_it_looks_for_stops_behind_it() -> None:
    ear = Ear([], [text(1, "slow")], [text(1, "slow"), text(2, "stop")], [])
    ear.held_up["slow"] = asyncio.Event()
    async with ear.listening():
        assert [(a.at_s, a.timeout_s) for a in ear.bot.asked] == [(0.0, 0), (0.0, POLL_S)]
        await ear.clock.advance(PEEK_S)
        assert ear.bot.asked[2] == Asked(PEEK_S, None, 0, BATCH)
        assert ear.texts == ["slow", "stop"]
        ear.held_up["slow"].set()
        await ear.clock.advance(PEEK_S)
        assert ear.listener.counts["received"] == 2


async def test_updates_without_a_number_are_not_asked_for_in_a_circle() -> None:
    odd = msgspec.Raw(b'{"message": {}}')
    ear = Ear([odd], [odd], [odd, text(1, "one")], [])
    async with ear.listening(5.0):
        assert ear.asked_at_s == [0.0, 0.5, 1.0, 1.0, 1.0]
        assert ear.texts == ["one"]


# ---- in which order ----


async def test_a_stop_goes_first_then_those_who_are_known_and_strangers_last() -> None:
    ear = Ear(
        [
            text(1, "hello", EVE),
            text(2, "stop", EVE),
            text(3, "status", chat=LAB),
            text(4, "battery", chat=LAB),
            text(5, "stop", chat=LAB),
            text(6, "where"),
        ]
    )
    ear.listener.reading.known = lambda address: address.account == str(ADA)
    async with ear.listening():
        assert ear.texts[0] == "stop"
        assert ear.heard[0].sender.account == str(ADA)
        of_eve = [each.text for each in ear.heard if each.sender.account == str(EVE)]
        assert of_eve == ["hello", "stop"], "whom nobody knows stops nothing"
        assert [said for said in ear.texts if said in {"status", "battery"}] == [
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

    ear = Ear()
    ear.chats = Watched()
    ear.bot.answers = [[text(1, "x", EVE), text(2, "y", EVE), text(3, "stop"), text(4, "z", EVE)]]
    listener = Poller("lab", ear.line, ear.chats, ear.clock, POLL_S, ear.alarms.append)
    listener.reading.known, listener.settle, ear.listener = known, settled, listener
    async with ear.listening():
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

    ear = Ear([text(number, "x" * 4_096) for number in range(BATCH)])
    other = asyncio.ensure_future(others())
    listening = asyncio.ensure_future(ear.listener.run(receive))
    await heard.wait()
    listening.cancel()
    other.cancel()
    assert until_heard > 2 * BATCH


async def test_a_tap_on_stop_overtakes_what_waits_and_any_other_tap_does_not() -> None:
    stop, other = Button("Stop", "stop", nonce="n1"), Button("Menu", "menu", nonce="n2")
    ear = Ear([], [text(1, "slow")], [tap(2, "n2"), tap(3, "n1")])
    ear.chats.offered(Outbound(chat=Chat("telegram", str(ADA)), text="?", buttons=((stop, other),)))
    ear.held_up["slow"] = asyncio.Event()
    async with ear.listening(PEEK_S):
        assert [each.nonce for each in ear.heard] == [None, "n1"]


# ---- what is passed over ----


async def test_what_is_malformed_is_counted_once_and_hides_nothing() -> None:
    """Also when it is given out again because nothing could be confirmed yet."""
    settled = [False]

    async def settle_later(_within_s: float) -> bool:
        return settled.pop() if settled else True

    batch = [raw(1, message={"message_id": "x"}), text(2, "one"), text(3, "two", EVE)]
    ear = Ear(batch, batch, [])
    ear.listener.settle = settle_later
    async with ear.listening(PEEK_S):
        assert sorted(ear.texts) == ["one", "two"]
        assert ear.listener.counts == {"malformed": 1, "passed-over": 1, "received": 2}
        assert [asked.offset for asked in ear.bot.asked] == [None, None, 4, None]


async def test_what_is_for_nobody_is_confirmed() -> None:
    ear = Ear([raw(1), raw(2, poll={})], [])
    async with ear.listening():
        assert ear.heard == []
        assert ear.bot.asked[1].offset == 3


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
    ear = Ear([member(1, "member", "left")], [member(2, "left", "member")], [moved, reaction])
    gone: list[bool] = []

    def passed(what: Passing) -> None:
        ear.passed.append(what)
        gone.append(ear.chats.gone(str(LAB)))

    ear.listener.reading.passed = passed
    async with ear.listening():
        assert [each.what for each in ear.passed] == [
            Passage.HEARING,
            Passage.REMOVED,
            Passage.ADDED,
            Passage.MOVED,
        ]
        assert gone == [False, True, False, False]
        assert (ear.passed[-1].chat.id, ear.passed[-1].new_id) == (str(LAB), "-1009")
        assert ear.chats.where(str(LAB)) == "-1009"
        assert [each.emoji for each in ear.reacted] == [("👍",)]


async def test_whoever_speaks_in_a_chat_has_let_us_in_again() -> None:
    ear = Ear([member(1, "member", "left")], [text(2, "status", chat=LAB)])
    async with ear.listening():
        assert not ear.chats.gone(str(LAB))


async def test_whatever_goes_wrong_with_what_is_passed_on_nobody_is_kept_waiting() -> None:
    def breaks(_what: object) -> None:
        raise RuntimeError("somebody's mistake")

    ear = Ear([member(1, "left", "member"), text(2, "stop")], [])
    ear.listener.reading.passed = breaks
    async with ear.listening():
        assert ear.texts == ["stop"]
        assert not ear.listener.catching_up


@pytest.mark.parametrize(("ahead_s", "counted"), [(2, 0), (3, 1)])
async def test_a_message_from_the_future_says_that_the_clock_is_behind(
    ahead_s: int, counted: int
) -> None:
    ear = Ear()
    date = ear.clock.wall_ns() // SECOND_NS + ahead_s
    ear.bot.answers = [[text(1, "hello", date=date), tap(2, "n")]]
    async with ear.listening():
        assert len(ear.heard) == 2
        assert ear.listener.counts["clock-behind"] == counted


async def test_the_clock_is_complained_of_once_in_a_hundred_times(
    caplog: pytest.LogCaptureFixture,
) -> None:
    ear = Ear()
    date = ear.clock.wall_ns() // SECOND_NS + 60
    ear.bot.answers = [
        [text(number, "hello", date=date) for number in range(100)],
        [text(100, "hello", date=date)],
    ]
    async with ear.listening():
        assert ear.listener.counts["clock-behind"] == 101
        complaints = [each for each in caplog.messages if "behind Telegram's" in each]
        assert len(complaints) == 2
        assert "at least 60 s behind" in complaints[0]


async def test_messages_from_before_the_accounts_time_go_without_its_number() -> None:
    ear = Ear()
    now_s = ear.clock.wall_ns() // SECOND_NS
    ear.bot.answers = [[text(1, "then", date=now_s - 1), text(2, "now", date=now_s)]]
    ear.listener.account_since_ns = now_s * SECOND_NS
    async with ear.listening():
        assert {each.text: each.account for each in ear.heard} == {"then": "", "now": "42"}


@pytest.mark.parametrize("several", [True, False])
async def test_what_several_bots_hear_in_a_small_group_is_known_to_each_by_the_same(
    *, several: bool
) -> None:
    """There each bot counts messages by itself; a bot that is alone shares nothing."""
    known = []
    for number in (7, 900):
        ear = Ear()
        date = ear.clock.wall_ns() // SECOND_NS
        small = {"id": -5, "type": "group", "title": "Lab"}
        ear.bot.answers = [
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
        if several:
            ear.listener.reading.one_of_several = True
        async with ear.listening():
            known += [each.shared for each in ear.heard]
    assert len(known) == 2
    assert known[0] == known[1]
    assert bool(known[0]) is several
