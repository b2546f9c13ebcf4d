from __future__ import annotations

import asyncio

import pytest

from rosic.core.message import SendPriority
from rosic.errors import MessengerFault
from rosic.messengers.telegram.rate_limiter import (
    ALL_HOLD_AT_FIRST_S,
    WAITING_AT_MOST,
    WAITING_IN_A_CHAT,
    RateLimiter,
)
from rosic.testing.clock import ManualClock, settle


class Turns:
    """Who got a turn, and when, in seconds from the beginning."""

    def __init__(
        self,
        *,
        spoke_before: bool = False,
        answers_s: float | None = None,
        clock: ManualClock | None = None,
    ) -> None:
        self.answers_s = answers_s
        self.answered: list[float] = []
        self.clock = clock or ManualClock()
        self.limiter = RateLimiter(self.clock, spoke_before=spoke_before)
        self.began_ns = self.clock.monotonic_ns()
        self.given: list[tuple[str, float]] = []
        self.tasks: list[asyncio.Task[None]] = []

    def now_s(self) -> float:
        return round((self.clock.monotonic_ns() - self.began_ns) / 1e9, 2)

    def ask(
        self,
        name: str,
        chat: str = "1",
        weight: SendPriority = SendPriority.OUTCOME,
        *,
        within_s: float = 600.0,
    ) -> asyncio.Task[None]:
        async def turn() -> None:
            await self.limiter.turn(chat, weight, within_s=within_s)
            self.given.append((name, self.now_s()))
            if self.answers_s is not None:
                with self.limiter.under_way(chat):
                    await self.clock.sleep(self.answers_s)
                self.answered.append(self.now_s())

        self.tasks.append(asyncio.create_task(turn()))
        return self.tasks[-1]

    def times(self) -> list[float]:
        return [at_s for _, at_s in self.given]

    def names(self) -> list[str]:
        return [name for name, _ in self.given]


async def test_a_few_at_once_then_one_a_second() -> None:
    turns = Turns()
    for number in range(5):
        turns.ask(f"m{number}")
    await turns.clock.advance(10)

    assert turns.given == [("m0", 0), ("m1", 0), ("m2", 0), ("m3", 1), ("m4", 2)]


async def test_one_chat_does_not_hold_up_another() -> None:
    turns = Turns()
    for number in range(6):
        turns.ask(f"a{number}", "1")
    turns.ask("b", "2")
    await settle()

    assert ("b", 0) in turns.given


async def test_a_group_never_gets_more_than_20_in_any_minute() -> None:
    turns = Turns()
    for number in range(60):
        turns.ask(f"m{number}", "-100")
    await turns.clock.advance(400)

    times = turns.times()
    assert len(times) == 60
    for start_s in times:
        assert sum(start_s <= at_s < start_s + 60 for at_s in times) <= 20


async def test_never_more_than_30_a_second_overall() -> None:
    turns = Turns()
    for number in range(200):
        turns.ask("m", str(number))
    await turns.clock.advance(20)

    times = turns.times()
    assert len(times) == 200
    for start_s in times:
        assert sum(start_s <= at_s < start_s + 1.0 for at_s in times) <= 28
    assert times[-1] < 9


async def test_forty_at_once_are_said_within_two_seconds_and_never_30_in_one() -> None:
    """As Telegram counts: in any second, so that 24 at once leave room for six."""
    turns = Turns()
    for number in range(40):
        turns.ask("m", str(number))
    turns.ask("stop", "41", SendPriority.STOP)
    await turns.clock.advance(20)

    times = turns.times()
    assert len(times) == 41
    assert max(sum(s <= at_s < s + 1.0 for at_s in times) for s in times) <= 28
    assert dict(turns.given)["stop"] == 0
    assert times[-1] < 2.5


@pytest.mark.parametrize("answers_s", [0.01, 0.4, 2.0])
async def test_a_call_counts_from_its_sending_until_a_second_after_its_answer(
    answers_s: float,
) -> None:
    """Nobody knows when in between Telegram counts it: a slow network pushes calls together."""
    turns = Turns(answers_s=answers_s)
    for number in range(100):
        turns.ask("m", str(number))
    await turns.clock.advance(60)

    sent, answered = turns.times(), turns.answered
    assert len(answered) == 100
    for at_s in sent:
        begun = sum(one <= at_s for one in sent)
        over = sum(one < at_s - 1.0 for one in answered)
        assert begun - over <= 28


async def test_urgent_words_keep_to_the_windows_too() -> None:
    turns = Turns()
    for number in range(60):
        turns.ask("m", "-100", SendPriority.STOP)
        turns.ask("n", str(number), SendPriority.STOP)
    await turns.clock.advance(300)

    group = [at_s for name, at_s in turns.given if name == "m"]
    assert len(group) == 60
    assert max(sum(s <= at_s < s + 60 for at_s in group) for s in group) <= 20
    assert max(sum(s <= a < s + 1.0 for a in turns.times()) for s in turns.times()) <= 28


async def test_after_a_restart_nothing_is_counted_on_that_an_earlier_run_may_have_used() -> None:
    turns = Turns(spoke_before=True)
    for number in range(5):
        turns.ask(f"m{number}")
    await turns.clock.advance(20)
    assert turns.times() == [1.05, 1.05, 2, 3, 4]


async def test_what_takes_no_turn_waits_where_telegram_asked_to_wait() -> None:
    turns = Turns()
    turns.limiter.hold("1", 7.0)
    waits = asyncio.create_task(turns.limiter.obey("1"))
    await turns.limiter.obey("2")
    await turns.clock.advance(7.0)
    assert not waits.done()
    await turns.clock.advance(0.2)
    assert waits.done()


async def test_stops_first_then_messages_then_edits() -> None:
    turns = Turns()
    for number in range(3):
        turns.ask(f"used-up-{number}")
    turns.ask("edit", weight=SendPriority.FEEDBACK)
    turns.ask("message")
    await settle()
    turns.ask("stop", weight=SendPriority.STOP)
    await turns.clock.advance(60)

    assert turns.names()[3:] == ["stop", "message", "edit"]
    assert dict(turns.given)["stop"] == 0


async def test_what_is_idle_waits_until_nothing_is_owed_and_spends_like_the_others() -> None:
    turns = Turns()
    turns.ask("idle", weight=SendPriority.IDLE)
    turns.ask("card", weight=SendPriority.IDLE)
    turns.ask("edit", weight=SendPriority.FEEDBACK)
    turns.ask("message")
    await turns.clock.advance(2)
    turns.ask("later")
    await turns.clock.advance(60)

    assert turns.names() == ["idle", "edit", "message", "later", "card"]
    assert dict(turns.given)["card"] == 4


async def test_retry_after_holds_the_chat_even_for_a_stop() -> None:
    turns = Turns()
    turns.limiter.hold("1", 7.0)
    turns.ask("held", weight=SendPriority.STOP)
    turns.ask("other", "2")
    await turns.clock.advance(20)

    assert turns.given == [("other", 0), ("held", 7.1)]


async def test_a_second_chat_that_is_held_holds_everything() -> None:
    turns = Turns()
    turns.limiter.hold("1", 7.0)
    turns.limiter.hold("2", 5.0)
    turns.ask("third", "3")
    await turns.clock.advance(20)

    assert turns.given == [("third", 5.1)]


HOURS_S = 4 * 3_600.0


async def test_hours_asked_for_in_one_chat_mute_no_other() -> None:
    """It was to be all chats for hours if another was told to wait for seconds just before."""
    turns = Turns()
    turns.limiter.hold("2", 5.0)
    turns.limiter.hold("1", HOURS_S)
    turns.ask("third", "3")
    turns.ask("long", "1", within_s=2 * HOURS_S)
    await turns.clock.advance(20)
    assert turns.given == [("third", 5.1)]
    turns.limiter.hold("2", 5.0)
    turns.ask("fourth", "4")
    await turns.clock.advance(20)
    assert turns.given[1:] == [("fourth", 25.1)]
    await turns.clock.advance(HOURS_S)
    assert turns.given[2:] == [("long", HOURS_S + 0.1)]


async def test_hours_asked_for_in_two_chats_are_tried_elsewhere_and_in_more_are_obeyed() -> None:
    turns = Turns()
    for chat in ("1", "2"):
        turns.limiter.hold(chat, HOURS_S)
    turns.ask("third", "3")
    await turns.clock.advance(60)
    assert turns.given == [("third", ALL_HOLD_AT_FIRST_S + 0.1)]
    for number in range(3, 13):  # whoever is tried is told the same: it is for all of us
        turns.limiter.hold(str(number), HOURS_S)
    turns.ask("more", "20", within_s=2 * HOURS_S)
    await turns.clock.advance(HOURS_S - 1.0)
    assert turns.names() == ["third"]
    await turns.clock.advance(120)
    assert turns.names() == ["third", "more"]


async def test_the_same_chat_held_twice_holds_only_itself() -> None:
    turns = Turns()
    turns.limiter.hold("1", 7.0)
    turns.limiter.hold("1", 5.0)
    turns.ask("other", "3")
    await settle()

    assert turns.given == [("other", 0)]


async def test_who_waits_too_long_is_told() -> None:
    turns = Turns()
    turns.limiter.hold("1", 100.0)
    task = turns.ask("late", within_s=10.0)
    await turns.clock.advance(11)

    assert task.done()
    with pytest.raises(MessengerFault, match="no room"):
        await task


async def test_who_is_cancelled_takes_no_turn_and_nothing_is_left_running() -> None:
    turns = Turns()
    turns.limiter.hold("1", 3.0)
    task = turns.ask("gone")
    stays = turns.ask("stays")
    await settle()
    task.cancel()
    await turns.clock.advance(5)

    assert turns.names() == ["stays"]
    assert stays.done()
    assert asyncio.all_tasks() == {asyncio.current_task()}


async def test_the_queue_is_bounded_and_edits_are_refused_first() -> None:
    turns = Turns()
    turns.limiter.hold("1", 100.0)
    for number in range(WAITING_AT_MOST):
        turns.limiter.hold(str(number), 100.0)
        turns.ask("edit", str(number), weight=SendPriority.FEEDBACK)
    await settle()

    with pytest.raises(MessengerFault, match="Too much"):
        await turns.limiter.turn("new", SendPriority.FEEDBACK, within_s=600)
    turns.ask("outcome", "new", weight=SendPriority.OUTCOME)
    await settle()
    assert not any(task.done() for task in turns.tasks)
    for task in turns.tasks:
        task.cancel()
    await asyncio.gather(*turns.tasks, return_exceptions=True)


async def test_one_chat_that_is_told_too_much_keeps_no_other_out() -> None:
    turns = Turns()
    for _ in range(WAITING_IN_A_CHAT + 3):
        turns.ask("much", "1")
    await settle()
    with pytest.raises(MessengerFault, match="Too much"):
        await turns.limiter.turn("1", SendPriority.OUTCOME, within_s=600)
    stop = turns.ask("stop", "1", SendPriority.STOP)
    other = turns.ask("other", "2")
    await settle()
    assert stop.done()
    assert other.done()
    for task in turns.tasks:
        task.cancel()
    await asyncio.gather(*turns.tasks, return_exceptions=True)


async def test_where_all_chats_together_wait_the_one_that_had_least_is_next() -> None:
    turns = Turns()
    for _ in range(60):
        for chat in range(40):
            if chat:
                turns.ask(str(chat), str(chat))
    await turns.clock.advance(3.0)
    before = len(turns.names())
    turns.ask("late", "0")
    await turns.clock.advance(1.2)

    assert turns.names()[before] == "late"
    had = [turns.names().count(str(chat)) for chat in range(1, 40)]
    assert max(had) - min(had) <= 3
    for task in turns.tasks:
        task.cancel()
    await asyncio.gather(*turns.tasks, return_exceptions=True)


async def test_what_weighs_more_goes_first_over_all_chats() -> None:
    turns = Turns()
    turns.limiter._all_held_ns = turns.clock.monotonic_ns() + 5_000_000_000
    for weight in reversed(SendPriority):
        for number in range(8):
            turns.ask(weight.name, f"{weight}.{number}", weight)
    await turns.clock.advance(30.0)

    assert turns.names() == [weight.name for weight in SendPriority for _ in range(8)]


class Disk(dict[str, bytes]):
    """What is kept over a restart."""

    def keep(self, name: str, body: bytes) -> None:
        if body:
            self[name] = body
        else:
            self.pop(name, None)


async def test_a_groups_minute_outlives_a_restart() -> None:
    disk, clock = Disk(), ManualClock()
    said_s: list[float] = []
    for run in range(6):
        turns = Turns(spoke_before=run > 0, answers_s=0.2, clock=clock)
        turns.limiter.keep_pace(dict(disk), disk.keep)
        for number in range(30):
            turns.ask(f"m{number}", "-100", (SendPriority.OUTCOME, SendPriority.STOP)[number % 2])
        await turns.clock.advance(17)
        said_s += [run * 17 + at_s for at_s in turns.answered]
        for task in turns.tasks:
            task.cancel()
        await settle()
    assert len(said_s) > 20
    for at_s in said_s:
        within = [other for other in said_s if at_s <= other < at_s + 60]
        assert len(within) <= 20, f"{len(within)} in the minute from {at_s} s"
    assert "-100" not in repr(disk)


async def test_a_group_that_was_quiet_for_a_minute_is_not_remembered() -> None:
    disk, clock = Disk(), ManualClock()
    turns = Turns(answers_s=0.0, clock=clock)
    turns.limiter.keep_pace({}, disk.keep)
    turns.ask("m", "-100")
    turns.ask("m", "1")
    await clock.advance(1)
    assert len(disk) == 1, "of a chat of two nothing has to be known"
    await clock.advance(61)
    Turns(clock=clock).limiter.keep_pace(dict(disk), disk.keep)
    assert not disk


async def test_what_cannot_be_read_of_an_earlier_run_is_passed_over() -> None:
    disk = Disk(x=b"?", y=b"\xc0")
    Turns().limiter.keep_pace(dict(disk), disk.keep)
    assert not disk
