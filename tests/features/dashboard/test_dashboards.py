"""The live card: follows robots at a bearable pace, says how old it is, shows what may be seen."""

from __future__ import annotations

import time
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import msgspec
import pytest

from rosic.core.message import SendPriority
from rosic.features.dashboard import DashboardFeature
from rosic.features.dashboard.dashboard import GROUP as IN_GROUPS
from rosic.features.dashboard.dashboard import PRIVATE
from rosic.features.dashboard.dashboards import LOOK_S
from rosic.stores.memory import MemoryStore
from tests.gateway.place import ADA, BO, line_by_line
from tests.gateway.shown_cards import GROUP, Shown, SlowMessenger, showing

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.features.dashboard.dashboard import RefreshPace

DAY_LONG_S = 600


async def test_a_card_shows_every_robot_that_its_owner_may_see_and_the_ones_named() -> None:
    async with showing() as shown:
        text = await shown.begins()
        for robot in ("omni", "kuka1", "cf1", "cf2"):
            assert f"{robot}: free · link good\n  now: at rest" in text
        assert shown.card().buttons[0][0].command == "stop"
        text = await shown.begins("/card omni, and kuka1")
        assert text.startswith("omni: free")
        assert "kuka1" in text
        assert "cf1" not in text
        assert shown.card().buttons[0][0].command == "stop omni kuka1"
        text = await shown.begins("/card swarm.")
        assert text.count("free") == 2
        assert "There is no robot and no group called omin here." in await shown.place.say(
            "/card omin"
        )


async def test_it_follows_an_order_from_sent_to_done() -> None:
    async with showing() as shown:
        await shown.begins("/card omni")
        shown.place.robot("omni").work_s = 1_000.0
        await shown.pass_s(5)
        await shown.place.say("omni move 1 m")
        await shown.pass_s(1)
        what = "move, 1.00 m forward"
        assert shown.text().startswith("omni: Ada · link good\n  sent 5: " + what)
        assert f"  received 5: {what}\n  now: doing move" in shown.text()
        shown.finish("omni")
        await shown.pass_s(4)
        assert "  now: done 6" in shown.text()
        await shown.pass_s(40)
        assert shown.text().startswith("omni: free"), "the lease has ended by itself"


async def test_a_card_that_begins_in_the_midst_of_an_order_shows_it() -> None:
    async with showing() as shown:
        shown.place.robot("omni").work_s = 1_000.0
        await shown.place.say("omni move 1 m", account=BO, chat=BO)
        assert "  sent 0: move, 1.00 m forward" in await shown.begins("/card omni")
        shown.finish("omni")


async def test_who_stopped_it_is_on_it_and_that_it_may_go_on() -> None:
    async with showing() as shown:
        await shown.begins("/card omni")
        await shown.pass_s(3)
        await shown.place.say("stop", account=BO, chat=BO)
        await shown.pass_s(1)
        assert shown.text().startswith("omni: stopped by Bo 3 · free")
        await shown.place.say("resume omni")
        await shown.pass_s(4)
        assert shown.text().startswith("omni: free")


async def test_a_robot_that_is_away_is_said_to_be() -> None:
    async with showing() as shown:
        await shown.begins("/card omni")
        shown.place.robot("omni").online = False
        await shown.pass_s(4)
        assert "not there" in shown.text()


async def test_time_that_was_booked_is_shown_with_its_end() -> None:
    async with showing() as shown:
        await shown.begins("/card omni")
        await shown.place.say("book omni now 30 min", account=BO, chat=BO)
        await shown.pass_s(4)
        assert shown.text().startswith("omni: Bo until 22:4")
        await shown.begins("/card kuka1")
        await shown.place.say("book kuka1 tomorrow 14:00 1h")
        await shown.pass_s(4)
        assert shown.text().startswith("kuka1: free until tomorrow 14:00")


async def restless(shown: Shown, seconds: int, chat: str) -> list[tuple[float, str]]:
    """Let something change every second; return when the card was edited, and to what."""
    seen: list[tuple[float, str]] = []
    for second in range(seconds):
        shown.place.robot("omni").online = second % 2 == 0
        before = len(shown.edits(chat))
        await shown.pass_s(1)
        seen += [(shown.now_s(), t.outbound.text) for t in shown.edits(chat)[before:]]
    return seen


@pytest.mark.parametrize(("how", "pace"), [({}, PRIVATE), (GROUP, IN_GROUPS)])
async def test_however_much_changes_there_are_few_edits(
    how: dict[str, Any], pace: RefreshPace
) -> None:
    async with showing() as shown:
        chat = str(how.get("chat", ADA))
        await shown.begins("/card omni", **how)
        edits = await restless(shown, 120, chat)
        between_s = pace.between_s
        assert len(edits) <= 120 / between_s + 1
        assert len(edits) >= 120 / (between_s + LOOK_S) - 1, "it is kept up to date all the same"
        times = [at for at, _ in edits]
        assert all(b - a >= between_s for a, b in pairwise(times))
        assert {t.outbound.weight for t in shown.edits(chat)} == {SendPriority.IDLE}


async def test_what_is_shown_is_never_older_than_it_says() -> None:
    """Every second: the stamp was true, a change is there in time, and the promise is kept."""
    async with showing() as shown:
        await shown.begins("/card omni")
        online, changed_s = True, 0
        for second in range(DAY_LONG_S):
            if second % 97 in {0, 1, 5}:
                online, changed_s = not online, shown.now_s()
                shown.place.robot("omni").online = online
            await shown.pass_s(1)
            stamp_s, next_s = shown.stamp()
            assert stamp_s <= shown.now_s() <= next_s
            if stamp_s > changed_s:
                assert ("link good" in shown.text()) == online
            assert stamp_s >= changed_s or shown.now_s() - changed_s <= PRIVATE.between_s + LOOK_S
        assert len(shown.edits()) <= DAY_LONG_S / PRIVATE.refresh_s + 3 * (DAY_LONG_S / 97 + 1)


async def test_when_nothing_changes_only_its_age_is_kept_true() -> None:
    async with showing() as shown:
        await shown.begins()
        await shown.pass_s(DAY_LONG_S)
        assert DAY_LONG_S / 60 <= len(shown.edits()) <= DAY_LONG_S / PRIVATE.refresh_s


async def test_edits_that_arrive_late_are_said_to() -> None:
    async with showing(chat=SlowMessenger) as shown:
        await shown.begins("/card omni")
        chat = shown.place.chat
        assert isinstance(chat, SlowMessenger)
        chat.slow_s = 8.0
        shown.place.robot("omni").online = False
        await shown.pass_s(14)
        shown.place.robot("omni").online = True
        await shown.pass_s(14)
        assert "\nchanges reach this chat 8 s late" in shown.text()
        stamp_s, next_s = shown.stamp()
        assert next_s - stamp_s == PRIVATE.promise_s + 8


async def test_after_an_outage_it_goes_on_with_what_is_so_then() -> None:
    async with showing() as shown:
        await shown.begins("/card omni")
        shown.place.chat.down = True
        shown.place.robot("omni").online = False
        await shown.pass_s(100)
        assert shown.stamp()[1] < shown.now_s(), "who reads it sees that it is dead"
        shown.place.chat.down = False
        await shown.pass_s(110)
        assert "not there" in shown.text()
        assert len(shown.cards()) == 1


# ---- as long as it lasts ----


@pytest.mark.parametrize("pinned", [False, True])
async def test_it_goes_on_in_the_same_message_after_a_restart(pinned: bool) -> None:
    store = MemoryStore()
    async with showing(store) as shown:
        await shown.begins("/card omni", account=BO)
        if pinned:
            await shown.place.say("/card pin", account=BO, chat=BO)
        [message] = shown.cards(BO)
        chat, clock = shown.place.chat, shown.place.clock
        [fact] = await store.facts("card", "", 10)
        assert BO not in msgspec.msgpack.decode(fact.body), "where it is, is sealed"
        assert fact.letter is not None
    await clock.advance(500.0)
    async with showing(store, chat=lambda _clock: chat, clock=clock) as shown:
        shown.place.robot("omni").online = False
        await shown.pass_s(4)
        assert shown.cards(BO) == [message]
        assert "not there" in shown.text(BO)
        assert "kuka1" not in shown.text(BO)
        assert shown.stamp(BO)[0] >= 500
        assert chat.pinned.get(BO, []) == [message] * pinned


async def test_whose_message_was_deleted_is_over() -> None:
    store = MemoryStore()
    async with showing(store) as shown:
        await shown.begins("/card omni")
        shown.place.chat.delete(shown.cards()[0])
        shown.place.robot("omni").online = False
        await shown.pass_s(100)
        assert len(shown.cards()) == 1
        assert not [fact for fact in await store.facts("card", "", 10) if fact.body]
        assert not len(shown.place.gateway.features.get(DashboardFeature).robots)


async def test_off_ends_it_and_what_follows_it_costs_nothing() -> None:
    async with showing() as shown:
        await shown.begins("/card omni")
        executor = shown.place.gateway.pipeline.executor
        assert executor._newest is not None
        assert "The card has ended." in await shown.place.say("/card off")
        await shown.pass_s(3)
        assert shown.place.chat.shown(shown.cards()[0]).text.startswith("This card has ended.")
        before = len(shown.place.chat.told)
        await shown.pass_s(120)
        assert len(shown.place.chat.told) == before
        assert executor._newest is None
        assert "There is no card in this chat." in await shown.place.say("/card off")


async def test_pinned_if_wished_once_and_no_longer_when_it_is_over() -> None:
    async with showing() as shown:
        pinned = shown.place.chat.pinned
        await shown.begins("/card omni")
        assert not pinned
        await shown.place.say("/card pin")
        assert len(shown.cards()) == 1
        assert pinned[ADA] == shown.cards()
        await shown.begins("/card kuka1")
        await shown.pass_s(2)
        assert pinned[ADA] == shown.cards()[-1:], "what follows a pinned card is pinned, too"
        await shown.place.say("/card unpin")
        assert pinned[ADA] == []
        await shown.begins("/card pin omni")
        assert pinned[ADA] == shown.cards()[-1:]
        await shown.place.say("/card off")
        await shown.pass_s(2)
        assert pinned[ADA] == []


async def test_who_may_not_pin_says_who_can_help_and_asks_once() -> None:
    async with showing() as shown:
        shown.place.chat.may_pin = False
        await shown.place.say("/card pin")
        said = [t.outbound.text for t in shown.place.chat.told]
        assert said.count("I may not pin messages here. An admin of this chat can help.") == 1
        await shown.pass_s(120)
        said = [t.outbound.text for t in shown.place.chat.told]
        assert said.count("I may not pin messages here. An admin of this chat can help.") == 1
        assert shown.place.chat.pinned == {}


async def test_where_messages_cannot_be_changed_it_is_said_once_and_again_by_a_tap() -> None:
    async with showing(chat=line_by_line) as shown:
        told = await shown.place.say("/card the omni")
        first, *_, last = told.split("\n")
        assert first.startswith("omni: free")
        assert last.startswith("as of ")
        await shown.pass_s(20)
        again = shown.place.chat.told[-1]
        [[button]] = again.outbound.buttons
        assert button.label == "Look again"
        told_again = await shown.place.tap(button, again.message)
        assert told_again.startswith("omni: ")
        assert told_again.split("\n")[-1] != last, "it is later now"
        before = len(shown.place.chat.told)
        await shown.pass_s(100)
        assert len(shown.place.chat.told) == before


# ---- what it costs ----


async def test_ten_orders_between_two_looks_cost_one_edit() -> None:
    async with showing() as shown:
        await shown.begins("/card omni")
        await shown.pass_s(5)
        before = len(shown.edits())
        for _ in range(10):
            await shown.place.say("omni wave")
        await shown.pass_s(1)
        assert len(shown.edits()) == before + 1


async def test_looking_at_hundreds_of_cards_takes_milliseconds() -> None:
    async with showing(more=15) as shown:
        live = shown.place.gateway.features.get(DashboardFeature).robots
        for number in range(300):
            who, chat = str(1_000 + number % 15), f"-{number + 10}"
            await shown.place.say("/card", chat=chat, kind=GROUP["kind"], account=who)
        assert len(live) == 300
        best_s = min(_timed(live.look) for _ in range(5))
        assert best_s < 0.02


def _timed(look: Callable[[], object]) -> float:
    begun = time.process_time()
    look()
    return time.process_time() - begun
