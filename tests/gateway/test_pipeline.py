"""Algorithm 1 from message to outcome: who, may they, what, where, and what really happened."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.message import Chat, ChatKind, MessageValidity
from rosic.core.order import OrderEnding, Outcome
from rosic.core.rate_limit import RateLimit
from rosic.core.records import Concluded
from rosic.errors import StillMoves
from rosic.gateway.unfollowed_messages import NOT_FOLLOWED
from tests.gateway.place import ADA, BO, STRANGER, VI, Place, SlowStore, line_by_line

if TYPE_CHECKING:
    from rosic.contracts.robot import Tell
    from rosic.core.order import Order

MINUTE_NS = 60_000_000_000


async def test_a_message_moves_a_robot_and_its_author_reads_what_it_did() -> None:
    async with Place().open() as place:
        told = await place.say("omni move 50 cm left")
        assert place.acted() == 1
        assert told.splitlines()[0] == "omni: move, 0.50 m left"
        message, shown = place.last()
        assert shown.text == (
            "omni: move, 0.50 m left\nsent 12:00:00 · received by the robot 12:00:00\ndone 12:00:00"
        )
        assert [button.label for row in shown.buttons for button in row] == [
            "Again",
            "Back",
            "Menu",
        ]
        assert len({told.message for told in place.chat.told}) == 1, message


async def test_an_ending_is_not_told_before_it_is_on_disk() -> None:
    store = SlowStore(Concluded)
    async with Place(store).open() as place:
        told = await place.say("omni move 1 m")
        await place.clock.advance(2.0)
        assert place.acted() == 1
        assert not any("done" in one.outbound.text for one in place.chat.told), told
        refused = await place.say("omni move 1 m", account=BO, chat="2")
        assert "taken by Ada" in refused
        store.ready.set()
        await place.quiet()
        assert any("done" in one.outbound.text for one in place.chat.told)


async def test_without_edits_every_step_is_a_line() -> None:
    async with Place(chat=line_by_line).open() as place:
        told = await place.say("omni move 1 m")
        assert told.splitlines() == [
            "omni: move, 1.00 m forward: accepted",
            "omni: sent",
            "omni: received by the robot",
            "omni: done 12:00:00",
        ]


async def test_a_group_moves_together_all_in_one_message() -> None:
    async with Place().open() as place:
        await place.say("swarm move 1 m")
        assert (place.acted("cf1"), place.acted("cf2")) == (1, 1)
        _, shown = place.last()
        assert shown.text.count("done") == 2


async def test_a_group_of_which_one_cannot_moves_nobody() -> None:
    async with Place().open() as place:
        await place.say("stop cf2")
        told = await place.say("swarm move 1 m")
        assert "cf2 is stopped" in told
        assert place.acted("cf1") == 0


async def test_a_strangers_message_gets_one_polite_line_and_nothing_else() -> None:
    async with Place().open() as place:
        told = await place.say("omni move 1 m", account=STRANGER, chat="9")
        assert told.startswith("Hello. I work for people I know")
        assert "omni" not in told
        assert place.acted() == 0


async def test_strangers_share_one_bucket() -> None:
    async with Place().open() as place:
        answers = [await place.say("hi", account=f"s{n}", chat=f"s{n}") for n in range(20)]
        assert sum(map(bool, answers)) == 5


async def test_a_stranger_in_a_group_is_not_answered() -> None:
    async with Place().open() as place:
        assert await place.say("omni move 1 m", account=STRANGER, kind=ChatKind.GROUP) == ""


async def test_people_may_talk_to_each_other_in_a_group() -> None:
    async with Place().open() as place:
        assert await place.say("nice weather today", kind=ChatKind.GROUP) == ""
        assert await place.say("nice weather today")


async def test_a_viewer_reads_and_does_not_move() -> None:
    async with Place().open() as place:
        assert "omni" in await place.say("status", account=VI, chat="3")
        told = await place.say("omni move 1 m", account=VI, chat="3")
        assert (
            told == 'Move needs the right "operator" on omni. Ada can give it. It counts at once.'
        )
        assert place.acted() == 0


async def test_out_of_bounds_offers_the_bound_and_does_nothing() -> None:
    async with Place().open() as place:
        told = await place.say("omni move 40 m")
        assert told == "omni: one move may be at most 5 m. Nothing was done."
        button, under = place.button("omni move 5 m")
        await place.tap(button, under)
        assert place.acted() == 1


async def test_a_typo_offers_what_may_have_been_meant() -> None:
    async with Place().open() as place:
        assert "Did you mean move?" in await place.say("omni mvoe 2 m")
        place.button("omni move 2 m")


async def test_the_chosen_robot_is_meant_when_none_is_named() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.say("move 1 m")
        assert place.acted() == 1
        await place.say("move 1 m", chat="another chat")
        assert place.acted() == 1, "a choice is for one chat"


async def test_the_same_message_twice_moves_once_and_is_answered_once() -> None:
    async with Place().open() as place:
        inbound = place.chat.say("omni move 1 m")
        await place.quiet()
        count = len(place.chat.told)
        place.chat.deliver(inbound)
        await place.quiet()
        assert place.acted() == 1
        assert len(place.chat.told) == count


async def test_a_refused_message_that_comes_again_stays_refused() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = 60.0
        await place.say("omni move 1 m")
        refused = place.chat.say("omni wave")
        await place.quiet()
        await place.say("stop omni")
        await place.say("resume omni")
        place.robot("omni").work_s = 0.0
        place.chat.deliver(refused)
        await place.quiet()
        assert place.acted() == 1


ANSWERED = {MessageValidity.FRESH, MessageValidity.UNVERIFIED}


@pytest.mark.parametrize("standing", [s for s in MessageValidity if s not in ANSWERED])
async def test_what_is_not_fresh_changes_nothing(standing: MessageValidity) -> None:
    async with Place().open() as place:
        said = NOT_FOLLOWED if standing is MessageValidity.EDITED else ""
        assert await place.say("omni move 1 m", standing=standing) == said
        assert await place.say("use omni", standing=standing) == said
        assert place.acted() == 0


async def test_a_changed_message_is_answered_once_and_a_tap_sends_it() -> None:
    async with Place().open() as place:
        changed = MessageValidity.EDITED
        assert await place.say("omni move 1 m", standing=changed, message="m7") == NOT_FOLLOWED
        again = await place.say("omni move 2 m", standing=changed, message="m7")
        assert again == "", "once for each message"
        await place.tap(*place.button("omni move 1 m"))
        assert place.acted() == 1
        assert await place.say("thank you all", standing=changed) == "", "no command"
        assert await place.say("omni move 1 m", standing=changed, account=STRANGER) == ""
        for text, told in (("move 1 m", ""), ("omni move 1 m", NOT_FOLLOWED)):
            said = await place.say(text, chat="-5", kind=ChatKind.GROUP, standing=changed)
            assert said == told, "people talk to each other there"


@pytest.mark.parametrize("standing", list(MessageValidity))
async def test_but_a_stop_is_obeyed(standing: MessageValidity) -> None:
    async with Place().open() as place:
        await place.say("status")
        nobody = standing in {MessageValidity.CHANNEL, MessageValidity.ANONYMOUS}
        await place.say("stop", standing=standing, account=STRANGER if nobody else ADA)
        assert place.robot("omni").gate.latched


async def test_a_strangers_stop_changes_nothing() -> None:
    async with Place().open() as place:
        told = (
            "I do not know you, so I stopped nothing. Use the stop button of the robot itself, or "
            "ask the admin here."
        )
        assert await place.say("stop", account=STRANGER, chat="9") == told
        assert await place.say("stop", account=STRANGER, chat="9") == ""
        assert not place.robot("omni").gate.latched


async def test_motion_older_than_its_lifetime_expires() -> None:
    async with Place().open() as place:
        old = place.clock.wall_ns() - 4 * MINUTE_NS
        told = await place.say("omni move 1 m", sent_ns=old)
        assert told == "Your command is 4 minutes old: it reached me late. Nothing was done."
        assert place.acted() == 0
        button, under = place.button("omni move 1 m")
        await place.tap(button, under)
        assert place.acted() == 1


async def test_a_send_time_in_the_future_lengthens_nothing() -> None:
    async with Place().open() as place:
        inbound = place.chat._inbound(ADA, place.chat.say("status").chat, "m", None)
        late = replace(inbound, text="omni move 1 m", sent_ns=inbound.received_ns + MINUTE_NS)
        await place.clock.advance(6.0)
        place.chat.deliver(late)
        await place.quiet()
        assert place.acted() == 0


async def test_what_is_old_for_another_reason_does_not_blame_the_network() -> None:
    async with Place().open() as place:
        inbound = place.chat._inbound(ADA, place.chat.say("status").chat, "m", None)
        await place.clock.advance(6.0)
        place.chat.deliver(replace(inbound, text="omni move 1 m"))
        await place.quiet()
        told = place.last()[1].text
        assert told == (
            "Your command is 6 seconds old: it waited here behind others. Nothing was done."
        )
        place.chat.gap()
        old = place.clock.wall_ns() - 4 * MINUTE_NS
        await place.say("omni move 1 m", sent_ns=old)
        await place.clock.advance(1.0)  # answers to a backlog wait until no more of it comes
        await place.quiet()
        assert place.last()[1].text == (
            "Your command is 4 minutes old: you sent it while I could not listen. Nothing was done."
        )
        assert place.acted() == 0


async def test_the_network_is_blamed_where_it_was_the_network() -> None:
    async with Place().open() as place:
        for minutes, told in (
            (4, "Your command is 4 minutes old (the network was away). Nothing was done."),
            (0, "You sent this while the network was away. Nothing was done."),
        ):
            place.chat.gap()
            sent_ns = place.clock.wall_ns() - minutes * MINUTE_NS - 1_000_000_000
            inbound = place.chat._inbound(ADA, Chat("memory", ADA), f"m{minutes}", sent_ns)
            away = replace(inbound, text="omni move 1 m", network_away=True)
            place.chat.deliver(away)
            await place.quiet()
            await place.clock.advance(1.0)
            await place.quiet()
            assert place.last()[1].text == told
        assert place.acted() == 0


async def test_what_was_sent_while_nobody_listened_moves_nothing() -> None:
    async with Place().open() as place:
        sent = place.clock.wall_ns() - 1_000_000_000
        place.chat.gap()
        await place.say("omni move 1 m", sent_ns=sent)
        await place.clock.advance(1.0)  # more of it might come
        told = place.chat.told[-1].outbound.text
        assert told.startswith("You sent this while I could not listen. Nothing was done.")
        assert place.acted() == 0
        await place.say("stop omni", sent_ns=sent)
        assert place.robot("omni").gate.latched


async def test_a_robot_has_one_holder_until_it_has_been_idle() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m")
        told = await place.say("omni move 1 m", account=BO, chat="2")
        assert told == "omni is taken by Ada. You can have it in 30 s."
        await place.clock.advance(31.0)
        await place.say("omni move 1 m", account=BO, chat="2")
        assert place.acted() == 2
        assert place.robot("omni").gate.fence == 2


async def test_an_out_of_bounds_request_takes_no_robot() -> None:
    async with Place().open() as place:
        await place.say("omni move 40 m", account=BO, chat="2")
        await place.say("omni move 1 m")
        assert place.acted() == 1


async def test_looking_needs_no_robot_for_oneself() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m")
        await place.say("omni look", account=BO, chat="2")
        assert place.acted() == 2


async def test_a_busy_robot_refuses_and_says_what_it_does() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = 60.0
        await place.say("omni move 1 m")
        told = await place.say("omni wave")
        assert "omni is busy: move, as you asked. This was not done." in told
        assert place.acted() == 1


async def test_lines_of_one_message_wait_for_each_other() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m\nomni wave\nkuka1 wave")
        assert (place.acted("omni"), place.acted("kuka1")) == (2, 1)


async def test_too_many_requests_say_when() -> None:
    async with Place(limit=RateLimit(burst=2.0, per_s=0.1)).open() as place:
        for _ in range(2):
            await place.say("omni wave")
        told = await place.say("omni wave")
        assert told == "That is more than one person may ask. Again in 10 s."
        assert await place.say("status") == "", "it was said; a flood gets no flood of answers"
        assert place.acted() == 2
        await place.clock.advance(10.0)
        await place.say("omni wave")
        assert place.acted() == 3


async def test_a_right_that_ends_while_an_order_waits_ends_the_order() -> None:
    async with Place().open() as place:
        place.robot("kuka1").work_s = 60.0
        await place.say("kuka1 move 1 m", account=BO, chat="2")
        await place.say("kuka1 wave", account=BO, chat="2")
        assert "Bo has no access any more" in await place.revoke("Bo")
        await place.quiet()
        assert place.acted("kuka1") == 1
        assert place.robot("kuka1").gate.latched, "what somebody without rights moved is at rest"
        told = await place.say("status", account=BO, chat="2")
        assert told == "Your access here has ended. The admin of this place can renew it."


async def test_a_right_that_ends_while_an_order_waits_is_asked_again() -> None:
    async with Place().open() as place:
        robot = place.robot("kuka1")
        robot.work_s = 3.0
        await place.say("kuka1 move 1 m", account=BO, chat="2")
        await place.say("kuka1 wave", account=BO, chat="2")
        gateway = place.gateway
        gateway.authority.revoked(gateway.rooms.authoriser.directory.named("Bo")[0].id)
        assert robot._end is not None
        robot._end.set_result(None)
        await place.quiet()
        assert place.acted("kuka1") == 1
        assert "I know no robot called kuka1." in place.last()[1].text


async def test_an_order_waiting_over_a_change_of_policy_is_admitted_once_more() -> None:
    async with Place().open() as place:
        place.robot("kuka1").work_s = 2.0
        await place.say("kuka1 move 1 m", account=BO, chat="2")
        await place.say("kuka1 wave", account=BO, chat="2")
        await place.revoke("Vi")
        robot = place.robot("kuka1")
        assert robot._end is not None
        robot._end.set_result(None)
        await place.quiet()
        assert place.acted("kuka1") == 2


class FailingWatcher:
    """Fails whatever it hears, and counts it."""

    def __init__(self) -> None:
        self.heard: list[str] = []

    def began(self, order: Order) -> None:
        """Fail when an order begins."""
        self.heard.append(f"began {order.robot}")
        raise LookupError(order.robot)

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Fail when one has ended."""
        self.heard.append(f"ended {order.robot}: {outcome.ending.value}")
        raise LookupError(order.robot)


def no_robot(robot: str) -> None:
    """Know no robot."""
    raise LookupError(robot)


async def test_an_order_goes_on_and_ends_whoever_that_follows_it_fails() -> None:
    first, second = FailingWatcher(), FailingWatcher()
    async with Place().open() as place:
        executor = place.gateway.pipeline.executor
        executor.watching.hear_ends(no_robot, wanted=True)
        executor.watching.watch_orders(first)
        executor.watching.watch_orders(second)
        for number in (1, 2):
            assert "done" in await place.say("omni move 1 m")
            assert place.acted() == number
    assert first.heard == second.heard == ["began omni", "ended omni: done"] * 2


async def test_an_end_is_told_whoever_that_hears_of_a_robot_that_still_moves_fails() -> None:
    heard: list[Order] = []

    def fails(order: Order) -> None:
        heard.append(order)
        raise LookupError(order.robot)

    async def execute(_order: Order, _tell: Tell) -> Outcome:
        return Outcome(OrderEnding.UNKNOWN, "omni still moves.", code=StillMoves.code)

    async with Place().open() as place:
        place.gateway.pipeline.executor.watching.still_moves.connect(fails)
        place.robot("omni").execute = execute  # type: ignore[method-assign, assignment]
        assert "omni still moves." in await place.say("omni move 1 m")
    assert len(heard) == 1
