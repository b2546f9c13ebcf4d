"""Reading strangers beside polling: nothing is lost or held up by it, whenever a run is cut off."""

from __future__ import annotations

import asyncio
from collections import Counter
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest
from telegram.error import NetworkError

from rosic.messengers.telegram import incoming
from rosic.messengers.telegram.polling import AT_ONCE_S, FULL_S
from rosic.messengers.telegram.reading import (
    BATCH,
    STEP_BYTES,
    TURNS,
    UNNAMED_SIGNS,
    UNREAD_AT_MOST,
)
from rosic.messengers.telegram.update_window import UpdateWindow
from rosic.testing.clock import settle
from tests.messengers.inbox import (
    ADA,
    EVE,
    LAB,
    POLL_S,
    HarnessInbox,
    ScriptedBot,
    member,
    raw,
    text,
)

if TYPE_CHECKING:
    from rosic.core.message import Inbound
    from rosic.testing.clock import ManualClock

LONG = "x" * STEP_BYTES
SHORT = "hello"
ANONYMOUS: dict[str, Any] = {"sender_chat": {"id": LAB, "type": "supergroup"}}


class KeepingBot(ScriptedBot):
    """Keeps updates until a later one is asked for, as Telegram does; some answers are lost."""

    def __init__(self, clock: ManualClock, updates: list[Any], lost: set[int]) -> None:
        account = SimpleNamespace(username="lab_bot", can_read_all_group_messages=True)
        super().__init__(clock, [], [account] * 2)
        self.kept = dict(enumerate(updates, 1))
        self.forgotten: list[int] = []
        self.filled = False
        self._lost = lost
        self.times: list[int] = []

    def give(self, number: int, update: object) -> None:
        """Have one more."""
        self.kept[number] = update

    async def raw_updates(
        self, offset: int | None, timeout_s: int, _kinds: object, limit: int
    ) -> list[Any]:
        """Forget what is confirmed, and give what is not."""
        for number in [number for number in self.kept if offset is not None and number < offset]:
            del self.kept[number]
            self.forgotten.append(number)
        self.times.append(self._clock.monotonic_ns())
        if len(self.times) in self._lost:
            raise NetworkError("away")
        if not self.kept:
            await self._clock.sleep(timeout_s)
        self.filled = self.filled or len(self.kept) >= limit
        return list(self.kept.values())[:limit]


class KeepingEar(HarnessInbox):
    """Has received a message when that has ended, which takes a turn of the loop."""

    def __init__(self, *updates: Any, lost: set[int] | None = None) -> None:  # noqa: ANN401
        super().__init__()
        self.keeping = KeepingBot(self.clock, list(updates), lost or set())
        self.line.bot = self.keeping
        self.hooks = self.hooks._replace(known=lambda address: address.account == str(ADA))
        self.held_up_for_long = False

    async def receive(self, inbound: Inbound) -> None:
        """Note what has been received, and that Telegram had not been told so before."""
        await asyncio.sleep(0)
        if inbound.text in self.held_up:
            await self.held_up[inbound.text].wait()
        of_known = inbound.sender.account == str(ADA) and not self.held_up_for_long
        if of_known or not self.keeping.filled:
            assert int(inbound.message) not in self.keeping.forgotten
        self.heard.append(inbound)

    def serves_lab_alone(self) -> None:
        """Nobody known here was met anywhere else."""
        self.hooks = self.hooks._replace(serves=lambda chat: chat.id == str(LAB))

    def note_what_is_read(self, read: list[int]) -> None:
        """Note each update that is looked into."""
        news = self.listener.reading.news

        def noted(number: int, update: Any, received: Any, **of: bool) -> Any:  # noqa: ANN401
            read.append(number)
            return news(number, update, received, **of)

        self.listener.reading.news = noted  # type: ignore[method-assign]

    @property
    def numbers(self) -> set[int]:
        """Of what was received."""
        return {int(inbound.message) for inbound in self.heard}


@pytest.mark.parametrize("lost", [set(), {2}, {2, 3, 4}], ids=str)
async def test_nothing_is_lost_whenever_a_run_is_cut_off(lost: set[int]) -> None:
    """At every turn of the loop: what was not received to the end is given out to the next run."""
    updates = [
        text(1, LONG, EVE),
        text(2, LONG, EVE + 1),
        text(3, "hi", EVE),
        text(4, "status"),
        text(5, "hello", chat=LAB, **ANONYMOUS),
        text(6, LONG, EVE + 1),
        text(7, "battery"),
    ]
    turns, was_behind, is_over = 0, False, False
    while not is_over:
        inbox = KeepingEar(*updates, lost=lost)
        run = asyncio.ensure_future(inbox.listener.run(inbox.receive, inbox.hooks))
        for _ in range(turns):
            await asyncio.sleep(0)
        is_over = len(inbox.heard) == len(updates)
        was_behind = was_behind or inbox.listener.reading.behind
        run.cancel()
        await asyncio.wait((run,))
        inbox.keeping.give(8, text(8, "hi", EVE + 1))
        async with inbox.listening(POLL_S):
            assert inbox.numbers == set(range(1, 9)), f"cut off after {turns} turns"
            inbox.keeping.give(9, text(9, "hi", EVE))
            await inbox.clock.advance(2 * POLL_S)
            assert inbox.numbers == set(range(1, 10)), f"cut off after {turns} turns"
            assert not inbox.keeping.kept, "all of it is confirmed"
        turns += 1
    assert was_behind, "it was cut off while strangers were unread, too"


async def test_what_strangers_sent_is_not_confirmed_before_it_is_read() -> None:
    """Though somebody known wrote behind it, and was answered."""
    inbox = KeepingEar(*(text(number, LONG, EVE) for number in range(1, 9)), text(9, "status"))
    async with inbox.listening(POLL_S):
        assert inbox.keeping.forgotten == list(range(1, 10))
        assert inbox.listener.counts == {"received": 9}, "each once"


async def test_those_known_here_wait_for_what_nobody_sent_as_a_stop_may_be_in_it() -> None:
    inbox = KeepingEar(
        text(1, "status"), text(2, "stop", chat=LAB, **ANONYMOUS), text(3, LONG, EVE)
    )
    async with inbox.listening(POLL_S):
        assert inbox.texts == ["stop", "status", LONG]


async def test_what_comes_while_strangers_are_read_is_searched_before_it_is_followed() -> None:
    """However often what is read beside it lets what was found be followed."""
    inbox = KeepingEar(*(text(number, LONG, EVE) for number in range(1, 61)))
    run = asyncio.ensure_future(inbox.listener.run(inbox.receive, inbox.hooks))
    while not inbox.listener.reading.behind:  # noqa: ASYNC110 - nobody is told when they have come
        await asyncio.sleep(0)
    for number, said in enumerate(["status", *[f"{LONG}{n}" for n in range(4)], "stop"], 61):
        inbox.keeping.give(number, text(number, said))
    await inbox.clock.advance(AT_ONCE_S)
    assert len(inbox.keeping.times) == 2, "they are asked for though not everything is read"
    assert inbox.listener.reading.behind
    while len(inbox.heard) < 66:  # noqa: ASYNC110 - nor when all is received
        await asyncio.sleep(0)
    run.cancel()
    of_ada = [each.text for each in inbox.heard if each.sender.account == str(ADA)]
    assert of_ada[:2] == ["stop", "status"]


async def test_what_is_nobodys_message_is_read_with_those_known_here() -> None:
    """That the bot was put into a group, for one; then what somebody without a name wrote."""
    inbox, read = KeepingEar(), []
    news = inbox.listener.reading.news

    def noted(number: int, update: Any, received: Any, **of: bool) -> Any:  # noqa: ANN401
        read.append(number)
        return news(number, update, received, **of)

    inbox.listener.reading.news = noted  # type: ignore[method-assign]
    updates = [
        text(1, "hi", EVE),
        text(2, "hello", chat=LAB, **ANONYMOUS),
        member(3, "left", "member"),
        text(4, "status"),
        raw(5, message={"message_id": "x"}),
    ]
    for number, each in enumerate(updates, 1):
        inbox.keeping.give(number, each)
    async with inbox.listening(POLL_S):
        assert read == [3, 4, 5, 2, 1]


async def test_a_stop_to_another_bot_is_passed_over_where_a_stranger_says_it() -> None:
    said = "@other_bot stop\n/stop@other_bot"
    inbox = KeepingEar(text(1, said, EVE), text(2, said, ADA))
    async with inbox.listening(POLL_S):
        assert inbox.numbers == {2}


@pytest.mark.parametrize("hundreds", [1, 3])
async def test_what_people_sent_hides_no_stop_while_it_is_held_up(hundreds: int) -> None:
    """Each hundred is waited for, but not for long; nothing waits longer while it is."""
    inbox = KeepingEar(*(text(number, "slow") for number in range(1, hundreds * BATCH + 1)))
    inbox.keeping.give(hundreds * BATCH + 1, text(hundreds * BATCH + 1, "stop"))
    inbox.held_up["slow"] = asyncio.Event()
    inbox.held_up_for_long = True
    async with inbox.listening(hundreds * FULL_S - 0.001):
        assert inbox.texts == []
        await inbox.clock.advance(0.001)
        assert inbox.texts == ["stop"]
        assert inbox.listener.counts["confirmed-early"] == hundreds * BATCH
        inbox.held_up["slow"].set()
        for _ in range(60):
            await settle()
        assert inbox.numbers == set(range(1, hundreds * BATCH + 2)), "it is followed all the same"


async def test_what_people_sent_hides_no_stop_while_it_goes_on_slowly() -> None:
    """However often one of it ends."""
    inbox = KeepingEar(*(text(number, f"slow {number}") for number in range(1, 3 * BATCH + 1)))
    inbox.keeping.give(3 * BATCH + 1, text(3 * BATCH + 1, "stop"))
    inbox.held_up = {f"slow {number}": asyncio.Event() for number in range(1, 3 * BATCH + 1)}
    inbox.held_up_for_long = True
    async with inbox.listening():
        for number in range(1, 4):
            inbox.held_up[f"slow {number}"].set()
            await inbox.clock.advance(FULL_S)
        assert inbox.texts == ["slow 1", "slow 2", "slow 3", "stop"]


async def test_what_people_sent_hides_no_stop_while_nothing_is_on_disk() -> None:
    """What was refused, say: it is received, and to be written."""
    inbox = KeepingEar(*(text(number, "no") for number in range(1, 3 * BATCH + 1)))
    inbox.keeping.give(3 * BATCH + 1, text(3 * BATCH + 1, "stop"))
    asked_within_s: list[float] = []

    async def hangs(within_s: float) -> bool:
        asked_within_s.append(within_s)
        await inbox.clock.sleep(within_s)
        return False

    inbox.hooks = inbox.hooks._replace(settle=hangs)
    async with inbox.listening(3 * FULL_S):
        assert "stop" in inbox.texts
        assert inbox.listener.counts["confirmed-early"] == len(inbox.keeping.forgotten) > 0
        assert 0 < max(asked_within_s[:3]) <= FULL_S


async def test_a_hundred_of_a_stranger_that_are_held_up_hide_no_stop_behind_them() -> None:
    """At once: nothing of theirs is in the way."""
    inbox = KeepingEar(*(text(number, "slow", EVE) for number in range(1, BATCH + 1)))
    inbox.keeping.give(BATCH + 1, text(BATCH + 1, "stop"))
    inbox.held_up["slow"] = asyncio.Event()
    async with inbox.listening():
        assert inbox.texts[0] == "stop"


async def test_what_strangers_sent_hides_nothing_behind_it_however_much_it_is() -> None:
    """Whether it is of one kind or mixed: they are read when nothing more is to be fetched."""
    for kinds in ((0,), (1,), (1, *[0] * 99)):
        inbox = KeepingEar(*mix(20 * BATCH, kinds))
        read: list[int] = []
        inbox.keeping.give(20 * BATCH + 1, text(20 * BATCH + 1, "stop"))
        inbox.serves_lab_alone()
        inbox.note_what_is_read(read)
        async with inbox.listening():
            assert read[0] == 20 * BATCH + 1, "before any of theirs"
            assert len(inbox.keeping.times) < 25
            assert inbox.texts[0] == "stop"
            assert not inbox.keeping.kept
            assert inbox.listener.counts["unread"] == 20 * BATCH - UNREAD_AT_MOST
            assert set(read[1:]) == set(range(1, UNREAD_AT_MOST + 1)) or 1 in kinds


async def test_of_too_much_strangers_messages_are_read_rather_than_posts() -> None:
    inbox = KeepingEar(*mix(UNREAD_AT_MOST, (0,)), *mix(2 * BATCH, (1,), UNREAD_AT_MOST))
    inbox.serves_lab_alone()
    async with inbox.listening():
        of_strangers = {number for number in inbox.numbers if number > UNREAD_AT_MOST}
        assert len(of_strangers) == 2 * BATCH
        assert len(inbox.heard) == UNREAD_AT_MOST


async def test_of_too_much_a_stop_is_read_also_where_nobody_was_met() -> None:
    number = UNREAD_AT_MOST + 3 * BATCH
    inbox = KeepingEar(
        *mix(1, (0,), said="stop"),
        *mix(number, (0,), 1),
        *mix(1, (0,), number + 1, said="stop"),
    )
    inbox.serves_lab_alone()
    async with inbox.listening():
        assert inbox.texts[:2] == ["stop", "stop"], "and before whatever else they sent"
        assert inbox.listener.counts["unread"] >= 3 * BATCH


async def test_what_is_long_and_names_nobody_is_read_last_wherever_it_is() -> None:
    inbox = KeepingEar(
        text(1, LONG, chat=LAB, **ANONYMOUS),
        text(2, "hello", EVE),
        text(3, "stop", chat=LAB, **ANONYMOUS),
        text(4, "status"),
    )
    inbox.serves_lab_alone()
    read: list[int] = []
    inbox.note_what_is_read(read)
    async with inbox.listening():
        assert read == [4, 3, 2, 1]


async def test_what_nobody_sent_where_somebody_was_met_is_read_though_more_keeps_coming() -> None:
    """What strangers send is not, and holds up nobody's order; a stop without a name counts."""
    inbox = KeepingEar(text(1, "status"), *mix(BATCH - 2, (0, 1), 1))
    inbox.keeping.give(BATCH, text(BATCH, "stop", chat=LAB, **ANONYMOUS))
    inbox.serves_lab_alone()
    read: list[int] = []
    inbox.note_what_is_read(read)
    async with inbox.listening():
        assert read[:2] == [1, BATCH]
        assert inbox.texts[:2] == ["stop", "status"]


async def test_an_order_does_not_wait_for_what_nobody_sent_after_it() -> None:
    """Somebody may go on sending in a chat that this bot serves, and every bit of it is read."""
    inbox, posted = KeepingEar(), "x" * UNNAMED_SIGNS
    reading, received = inbox.listener.reading, incoming.ReceivedAt(0, 0)
    reading.begin(inbox.hooks, own_name="lab_bot", hears_groups=True)
    async with asyncio.TaskGroup() as group:
        window = UpdateWindow(group, inbox.receive, inbox.clock, Counter(), reading.go_on)
        first = [*mix(5, (0,), said=posted), text(6, "status")]
        await reading.take_in(group, window, first, received)
        await reading.take_in(group, window, mix(60, (0,), 6, said=posted), received)
        while "status" not in inbox.texts:  # noqa: ASYNC110 - nobody is told
            await asyncio.sleep(0)
        assert reading.behind
        assert len(inbox.heard) <= 6


async def test_while_much_waits_nothing_more_of_strangers_is_read() -> None:
    """What cannot be followed does not pile up behind it."""
    inbox = KeepingEar(*mix(5 * BATCH, (1,)))
    inbox.held_up[SHORT] = asyncio.Event()
    async with inbox.listening(POLL_S):
        assert inbox.listener.reading.behind
        assert not inbox.keeping.kept
        read: list[int] = []
        inbox.note_what_is_read(read)
        inbox.keeping.give(501, text(501, "stop"))
        await inbox.clock.advance(POLL_S)
        assert read == [501]
        inbox.held_up[SHORT].set()
        while inbox.listener.reading.behind:  # noqa: ASYNC110 - nobody is told when all is read
            await asyncio.sleep(0)
        await inbox.clock.advance(POLL_S)
        assert inbox.numbers == set(range(1, 502))


def mix(number: int, kinds: tuple[int, ...], after: int = 0, *, said: str = SHORT) -> list[Any]:
    """Return what strangers send: posts in channels of theirs (0) and messages (1), in turns."""
    made = []
    for at in range(number):
        mine = after + at + 1
        if kinds[at % len(kinds)]:
            made.append(text(mine, said, 10 * ADA + mine))
        else:
            place = {"id": -2000 - mine, "type": "channel"}
            post = {"message_id": mine, "date": 1, "chat": place, "text": said}
            made.append(raw(mine, channel_post=post))
    return made


async def test_fewer_that_are_held_up_are_not_confirmed_before_they_are_received() -> None:
    inbox = KeepingEar(*(text(number, "slow") for number in range(1, BATCH)))
    inbox.held_up["slow"] = asyncio.Event()
    async with inbox.listening(10.0):
        assert inbox.keeping.forgotten == []


async def test_long_messages_of_strangers_let_others_have_the_loop_between_them() -> None:
    inbox = KeepingEar(*(text(number, LONG, EVE + number) for number in range(1, 11)))
    assert await turns_until_heard(inbox, 10) > 10 * TURNS


async def test_many_short_messages_of_strangers_are_read_in_few_turns() -> None:
    """Others are let have the loop after what is a step's work, not after each message."""
    inbox = KeepingEar(*(text(number, "hi", EVE + number) for number in range(1, BATCH)))
    assert await turns_until_heard(inbox, BATCH - 1) < BATCH


async def turns_until_heard(inbox: HarnessInbox, number: int) -> int:
    run, turns = asyncio.ensure_future(inbox.listener.run(inbox.receive, inbox.hooks)), 0
    while len(inbox.heard) < number:
        await asyncio.sleep(0)
        turns += 1
    run.cancel()
    return turns
