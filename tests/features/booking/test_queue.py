"""`/wait`: places, offers, taking turns."""

from __future__ import annotations

from rosic.errors import Expired, NotPermitted, NotUnderstood, RobotTaken
from tests.features.booking.booking_handlers import ANN, BEN, CEM, HOUR, MIN, NOW, VI, FullDisk, Lab

TURN = "KUKA iiwa is free and it is your turn. Tap within 60 s to take it."


async def test_joining_says_the_place_and_the_estimate() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 now 1h")
        assert await lab.say(BEN, "/wait kuka1") == (
            "You are number 1 in the queue for KUKA iiwa: about 11:00. "
            "I tell you when it is your turn."
        )
        assert lab.labels() == ["Leave the queue"]
        assert await lab.say(CEM, "/wait for KUKA iiwa.") == (
            "You are number 2 in the queue for KUKA iiwa: about 11:30. "
            "I tell you when it is your turn."
        )
        assert (await lab.say(BEN, "/wait kuka1")).startswith("You are number 1")
        assert await lab.say(CEM, "/wait") == (
            "You are number 2 in the queue for KUKA iiwa: about 11:30."
        )
        await lab.say(BEN, "/wait")
        assert await lab.tap(BEN, "Leave KUKA iiwa") == "You no longer wait for KUKA iiwa."
        assert lab.waiting.queue("kuka1") == (CEM,)


async def test_leaving() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 now 1h")
        assert await lab.say(BEN, "/wait none") == "You are not waiting for any robot."
        assert await lab.say(BEN, "/wait none kuka1") == "You are not waiting for KUKA iiwa."
        await lab.say(BEN, "/wait kuka1")
        assert await lab.say(BEN, "/wait none kuka1") == "You no longer wait for KUKA iiwa."
        lab.begin(ANN, "arm")
        await lab.say(BEN, "/wait kuka1")
        await lab.say(BEN, "/wait arm")
        assert await lab.say(BEN, "/wait none") == (
            "You no longer wait for The Arm.\nYou no longer wait for KUKA iiwa."
        )
        assert lab.waiting.waits_for(BEN) == ()


async def test_who_has_it_need_not_wait() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 now 1h")
        assert await lab.say(ANN, "/wait kuka1") == (
            "KUKA iiwa is yours already, until 11:00. You need not wait."
        )
        lab.begin(BEN, "cf1")
        assert await lab.say(BEN, "/wait cf1") == "cf1 is yours already. You need not wait."


async def test_waiting_needs_the_right_to_move_it_and_a_name() -> None:
    async with Lab().open() as lab:
        assert await lab.say(VI, "/wait kuka1") == "That needs a right you lack."
        assert isinstance(lab.refusal, NotPermitted)
        assert await lab.say(BEN, "/wait") == "Which robot?"
        assert await lab.say(BEN, "/wait kuka1 tomorrow") == (
            "Say only which robot you wait for; to have it at a time, book it."
        )
        assert isinstance(lab.refusal, NotUnderstood)
        assert lab.waiting.queue("kuka1") == ()


async def test_a_robot_that_becomes_free_is_offered_to_the_first_then_to_the_next() -> None:
    async with Lab().open() as lab:
        lab.begin(ANN)
        await lab.say(BEN, "/wait kuka1")
        await lab.say(CEM, "/wait kuka1")
        assert await lab.told(100) == []
        lab.end()
        assert await lab.told(59.9) == []
        assert await lab.told(0.1) == [(BEN, TURN)]
        assert await lab.told(59.9) == []
        assert await lab.told(0.1) == [
            (BEN, "Your turn with KUKA iiwa has passed on. Say wait to queue again."),
            (CEM, TURN),
        ]
        assert lab.waiting.queue("kuka1") == (CEM,)
        assert await lab.say(BEN, "/wait take kuka1") == "You are not waiting for KUKA iiwa."
        assert await lab.tap_told(CEM, "Take it") == "KUKA iiwa is yours now, until 10:33."
        assert lab.labels() == ["KUKA iiwa"]
        (slot,) = lab.calendar.of(CEM)
        assert slot.end_ns - slot.start_ns == 30 * MIN
        assert lab.waiting.queue("kuka1") == ()
        assert await lab.told(60) == []


async def test_a_slot_that_is_over_makes_it_the_nexts_turn() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 10:00 10 min")
        lab.begin(ANN)
        await lab.say(BEN, "/wait kuka1")
        await lab.told_until(9.9)
        assert await lab.told_until(10) == []  # not before rest is measured
        assert await lab.told(0.5) == [
            (ANN, "Your time with KUKA iiwa is over. It is at rest."),
            (BEN, TURN),
        ]


async def test_an_offer_is_told_once_while_it_stands() -> None:
    async with Lab().open() as lab:
        await lab.say(BEN, "/wait kuka1")
        assert await lab.told() == [(BEN, TURN)]
        await lab.book(ANN, "arm 14:00 1h")  # wakes the keeper
        await lab.say(CEM, "/wait kuka1")
        assert await lab.told(30) == []


async def test_not_now_passes_the_turn_on_at_once() -> None:
    async with Lab().open() as lab:
        lab.begin(ANN)
        await lab.say(BEN, "/wait kuka1")
        await lab.say(CEM, "/wait kuka1")
        lab.end()
        assert await lab.told(60) == [(BEN, TURN)]
        assert await lab.tap_told(BEN, "Not now") == "You no longer wait for KUKA iiwa."
        assert await lab.told() == [(CEM, TURN)]


async def test_a_turn_ends_where_the_next_slot_begins() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 10:20 1h")
        await lab.say(BEN, "/wait kuka1")
        await lab.told(30.25)
        assert await lab.tap_told(BEN, "Take it") == "KUKA iiwa is yours now, until 10:20."
        assert lab.calendar.of(BEN)[0].end_ns == NOW + 20 * MIN
        assert [text for _, text in await lab.told_until(19)] == [
            "Your time with KUKA iiwa ends in 5 min, at 10:20.",
            "Your time with KUKA iiwa ends in 1 min, at 10:20.",
        ]


async def test_a_turn_before_ones_own_slot_goes_on_into_it() -> None:
    async with Lab().open() as lab:
        await lab.book(BEN, "kuka1 10:20 1h")
        await lab.say(BEN, "/wait kuka1")
        await lab.told(30.25)
        assert await lab.tap_told(BEN, "Take it") == "KUKA iiwa is yours now, until 11:20."
        lab.begin(BEN)
        assert [text for _, text in await lab.told_until(21)] == [
            "It is your time: KUKA iiwa is yours until 11:20.",
        ]
        assert lab.handed == []


async def test_a_short_gap_is_nobodys_turn() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 10:04 1h")
        await lab.say(BEN, "/wait kuka1")
        assert await lab.told(200) == []


async def test_while_it_is_offered_nobody_else_has_it() -> None:
    async with Lab().open() as lab:
        lab.begin(ANN, "cf1")
        await lab.say(BEN, "/wait cf1")
        lab.end("cf1")
        assert len(await lab.told(60)) == 1
        assert lab.holder("cf1") == BEN
        assert await lab.told(59.9) == []
        assert (lab.holder("cf1"), lab.waiting.queue("cf1")) == (BEN, (BEN,))
        await lab.told(0.1)
        assert lab.holder("cf1") is None


async def test_whoever_takes_it_has_it_and_not_now_frees_it_at_once() -> None:
    async with Lab().open() as lab:
        await lab.say(BEN, "/wait cf1")
        await lab.say(CEM, "/wait cf1")
        await lab.told()
        await lab.tap_told(BEN, "Not now")
        assert len(await lab.told()) == 1
        assert lab.holder("cf1") == CEM
        await lab.tap_told(CEM, "Take it")
        await lab.told(59)
        assert lab.holder("cf1") == CEM


async def test_whoever_drives_without_a_tap_has_taken_it() -> None:
    async with Lab().open() as lab:
        await lab.say(BEN, "/wait cf1")
        await lab.told(1)
        lab.begin(BEN, "cf1")
        assert await lab.told(60) == []
        assert lab.waiting.queue("cf1") == ()
        assert lab.holder("cf1") == BEN


async def test_where_slots_mean_nothing_a_turn_is_a_turn_without_one() -> None:
    async with Lab().open() as lab:
        lab.begin(ANN, "cf1")
        await lab.say(BEN, "/wait cf1")
        lab.end("cf1")
        assert await lab.told(60) == [
            (BEN, "cf1 is free and it is your turn. Tap within 60 s to take it."),
        ]
        assert await lab.tap_told(BEN, "Take it") == "cf1 is yours now."
        assert len(lab.calendar) == 0


async def test_an_offer_falls_when_somebody_takes_the_robot_and_no_place_is_lost() -> None:
    async with Lab().open() as lab:
        await lab.say(BEN, "/wait kuka1")
        assert await lab.told() == [(BEN, TURN)]
        lab.begin(ANN)
        assert await lab.tap_told(BEN, "Take it") == (
            "KUKA iiwa was taken meanwhile. You stay number 1 in the queue."
        )
        assert isinstance(lab.refusal, RobotTaken)
        lab.end()
        assert await lab.told(60) == [(BEN, TURN)]


async def test_a_stopped_robot_is_offered_to_nobody() -> None:
    async with Lab().open() as lab:
        lab.away.add("kuka1")
        await lab.say(BEN, "/wait kuka1")
        assert await lab.told(600) == []
        lab.away.clear()
        assert await lab.told(5) == [(BEN, TURN)]


async def test_who_has_it_by_now_waits_no_longer() -> None:
    async with Lab().open() as lab:
        lab.begin(ANN)
        await lab.say(BEN, "/wait kuka1")
        lab.leases["kuka1"].release()
        lab.begin(BEN)
        await lab.told(5)
        assert lab.waiting.queue("kuka1") == ()


async def test_who_has_lost_the_right_is_told_and_passed_over() -> None:
    async with Lab().open() as lab:
        lab.begin(ANN)
        await lab.say(BEN, "/wait kuka1")
        await lab.say(CEM, "/wait kuka1")
        lab.forbidden.add(BEN)
        assert await lab.told(5) == [
            (BEN, "You may not move KUKA iiwa any more, so you no longer wait for it."),
        ]
        lab.end()
        assert await lab.told(60) == [(CEM, TURN)]


async def test_a_late_tap_is_refused() -> None:
    store = FullDisk()
    async with Lab(store).open() as lab:
        await lab.say(BEN, "/wait kuka1")
        await lab.told()
        store.full = True  # so that nobody is taken out of the queue
        await lab.told(60)
        assert await lab.tap_told(BEN, "Take it") == (
            "Your turn with KUKA iiwa has passed on. Say wait to queue again."
        )
        assert isinstance(lab.refusal, Expired)
        store.full = False
        await lab.told(10)
        assert await lab.say(BEN, "/wait take kuka1") == "You are not waiting for KUKA iiwa."
        assert len(lab.calendar) == 0


async def test_it_is_nobody_elses_turn() -> None:
    async with Lab().open() as lab:
        await lab.say(BEN, "/wait kuka1")
        await lab.told()
        await lab.say(CEM, "/wait kuka1")
        assert await lab.tap_told(CEM, "Take it") == "This question was asked of somebody else."
        assert await lab.say(CEM, "/wait take kuka1") == (
            "KUKA iiwa is offered to somebody else now. You are number 2 in the queue."
        )
        assert lab.waiting.queue("kuka1") == (BEN, CEM)


async def test_on_a_full_disk_nobody_is_passed_over_and_it_is_tried_again() -> None:
    store = FullDisk()
    async with Lab(store).open() as lab:
        await lab.say(BEN, "/wait kuka1")
        await lab.told()
        store.full = True
        assert await lab.tap_told(BEN, "Take it") == (
            "I cannot write this down now, so nothing was changed. The operator has to look."
        )
        assert (lab.waiting.queue("kuka1"), len(lab.calendar)) == ((BEN,), 0)
        assert await lab.told(100) == []
        store.full = False
        assert await lab.told(10) == [
            (BEN, "Your turn with KUKA iiwa has passed on. Say wait to queue again."),
        ]
        await lab.tap_told(BEN, "Wait again")
        assert await lab.told(1) == [(BEN, TURN)]


async def test_a_required_robot_can_be_moved_after_a_taken_turn() -> None:
    async with Lab().open() as lab:
        await lab.say(BEN, "/wait omni")
        await lab.told()
        await lab.tap_told(BEN, "Take it")
        assert lab.calendar.why_not(BEN, "omni", NOW, required=True) is None
        assert lab.calendar.why_not(CEM, "omni", NOW, required=True) is not None
        assert lab.calendar.next_free("omni", NOW, 60) == NOW + HOUR // 2
