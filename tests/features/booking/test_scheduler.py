"""The keeper: starts, warnings and ends, each once, whatever the clocks do."""

from __future__ import annotations

import pytest

from rosic.core.identity import OPERATOR
from rosic.errors import RobotStopped
from tests.features.booking.booking_handlers import ANN, BEN, CEM, MIN, NOW, Lab

BEGINS = "It is your time: KUKA iiwa is yours until 12:00."
FIVE = "Your time with KUKA iiwa ends in 5 min, at 12:00."
ONE = "Your time with KUKA iiwa ends in 1 min, at 12:00."


async def test_a_slot_is_told_when_it_begins_and_before_it_ends_to_the_second() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        assert await lab.told_until(60 - 1 / 60) == []
        assert await lab.told_until(60) == [(ANN, BEGINS)]
        assert await lab.told_until(115 - 1 / 60) == []
        assert await lab.told_until(115) == [(ANN, FIVE)]
        assert await lab.told_until(119 - 1 / 60) == []
        assert await lab.told_until(119) == [(ANN, ONE)]
        assert await lab.told_until(300) == []
        assert lab.handed == []  # nobody had it at the end


async def test_what_is_booked_from_now_on_is_not_said_twice() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 now 1h")
        assert await lab.told_until(54) == []


async def test_a_slot_that_is_booked_while_the_keeper_sleeps_wakes_it() -> None:
    async with Lab().open() as lab:
        await lab.told_until(0.5)
        await lab.book(ANN, "kuka1 10:02 2 min")
        assert await lab.told_until(2 - 1 / 60) == []
        said = "It is your time: KUKA iiwa is yours until 10:04."
        assert await lab.told_until(2) == [(ANN, said)]
        said = "Your time with KUKA iiwa ends in 1 min, at 10:04."
        assert await lab.told_until(3) == [(ANN, said)]


async def test_a_time_that_goes_on_is_not_said_to_end() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 30 min")
        await lab.book(ANN, "kuka1 11:30 30 min")
        lab.begin(ANN)
        assert [text for _, text in await lab.told_until(119)] == [
            "It is your time: KUKA iiwa is yours until 11:30.",
            BEGINS,
            FIVE,
            ONE,
        ]
        assert lab.handed == []


async def test_robots_that_need_no_booking_keep_nobodys_time() -> None:
    async with Lab().open() as lab:
        async with lab.changes.turn() as turn:
            await turn.write(lab.calendar.book(ANN, "cf1", NOW + 2 * MIN, 600, ANN))
        lab.begin(ANN, "cf1")
        assert await lab.told_until(30) == []
        assert lab.handed == []


# ---- the end ----


async def test_at_the_end_whoever_has_it_comes_to_rest_and_then_it_is_the_nexts() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        await lab.book(BEN, "kuka1 12:00 1h")
        await lab.told_until(61)
        lab.begin(ANN)
        await lab.told_until(119)
        assert lab.handed == []
        assert await lab.told_until(120) == []  # rest is being measured
        assert lab.handed == [("kuka1", "your time is over", 7200.0)]
        assert await lab.told(0.5) == [
            (ANN, "Your time with KUKA iiwa is over. It is at rest."),
            (BEN, "It is your time: KUKA iiwa is yours until 13:00."),
        ]
        assert lab.leases["kuka1"].holder is None
        assert await lab.told_until(170) == []


async def test_a_time_ends_though_somebody_elses_write_hangs() -> None:
    """I8: who waits no more for a robot is written down, and that may take for ever."""
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 10:02 2 min")
        await lab.book(CEM, "omni now 3h")
        assert "You are number 1 in the queue for omni" in await lab.say(BEN, "/wait omni")
        await lab.told_until(3)
        lab.begin(ANN)
        async with lab.changes.turn():
            lab.forbidden.add(BEN)  # who is to be taken out of the queue
            lab.scheduler.look()
            told = [text for _, text in await lab.told_until(4.1)]
            assert lab.handed == [("kuka1", "your time is over", 240.0)]
            assert told == ["Your time with KUKA iiwa is over. It is at rest."]
        assert [who for who, _ in await lab.told(0.5)] == [BEN], "and then they are served"


async def test_an_idle_lease_at_the_end_is_given_back_too() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        lab.begin(ANN)
        await lab.told_until(119.5)
        lab.end()
        assert await lab.told_until(121) == [
            (ANN, "Your time with KUKA iiwa is over. It is at rest."),
        ]
        assert len(lab.handed) == 1


NOT_AT_REST = (
    "Your time with KUKA iiwa is over. It has not confirmed that it is at rest, so it stays "
    "stopped. If it moves, use its own stop button."
)
TO_WAIT = (
    "It is your time with KUKA iiwa, but it has not confirmed that it is at rest, so it stays "
    "stopped. Look at it; somebody who may resume it can do so then. If it moves, use its own "
    "stop button."
)


async def test_until_somebody_has_looked_at_a_robot_nobody_has_it() -> None:
    async with Lab().open() as lab:
        lab.confirms = False
        await lab.book(ANN, "kuka1 11:00 1h")
        await lab.book(BEN, "kuka1 12:00 10 min")
        await lab.told_until(61)
        lab.begin(ANN)
        await lab.say(CEM, "/wait kuka1")
        await lab.told_until(119.9)
        assert await lab.told_until(120.1) == [(ANN, NOT_AT_REST), (BEN, TO_WAIT)]
        assert lab._shown("Resume KUKA iiwa").command == "/resume kuka1"
        assert await lab.told_until(122) == []
        assert len(lab.handed) == 1
        lab.away.clear()  # resumed
        said = "It is your time: KUKA iiwa is yours until 12:10."
        assert await lab.told(5) == [(BEN, said)]
        said = "KUKA iiwa is free and it is your turn. Tap within 60 s to take it."
        assert (CEM, said) in await lab.told_until(130)


async def test_nobody_is_told_to_resume_a_robot_that_has_to_stay_stopped() -> None:
    async with Lab().open() as lab:
        lab.confirms = False
        lab.barred["kuka1"] = RobotStopped("KUKA iiwa is retired, so it stays stopped.")
        await lab.book(ANN, "kuka1 11:00 1h")
        await lab.book(BEN, "kuka1 12:00 10 min")
        await lab.told_until(61)
        lab.begin(ANN)
        await lab.told_until(119.9)
        why = (
            "It is your time with KUKA iiwa, but you cannot use it. "
            "KUKA iiwa is retired, so it stays stopped."
        )
        assert await lab.told_until(120.1) == [(ANN, NOT_AT_REST), (BEN, why)]
        with pytest.raises(AssertionError):
            lab._shown("Resume KUKA iiwa")


async def test_a_robot_in_doubt_is_offered_when_somebody_has_seen_to_it() -> None:
    async with Lab().open() as lab:
        lab.confirms = False
        await lab.book(ANN, "kuka1 now 10 min")
        lab.begin(ANN)
        await lab.say(CEM, "/wait kuka1")
        await lab.told_until(9.9)
        assert await lab.told_until(20) == [(ANN, NOT_AT_REST)]
        lab.away.clear()
        said = "KUKA iiwa is free and it is your turn. Tap within 60 s to take it."
        assert await lab.told(5) == [(CEM, said)]


async def test_a_slot_that_begins_while_rest_is_not_confirmed_says_so() -> None:
    async with Lab().open() as lab:
        lab.confirms = False
        await lab.book(ANN, "kuka1 11:00 1h")
        await lab.book(BEN, "kuka1 12:02 1h")
        await lab.told_until(61)
        lab.begin(ANN)
        await lab.told_until(121.9)
        assert await lab.told_until(122) == [(BEN, TO_WAIT)]


async def test_a_handover_that_breaks_is_tried_again_and_nobody_begins_meanwhile() -> None:
    async with Lab().open() as lab:
        lab.breaks = True
        await lab.book(ANN, "kuka1 now 10 min")
        await lab.book(BEN, "kuka1 10:10 1h")
        lab.begin(ANN)
        await lab.told_until(9.9)
        said = (
            "Your time with KUKA iiwa is over, but it does not answer. Look at it. If it moves, "
            "use its own stop button."
        )
        assert await lab.told_until(12) == [(ANN, said)]
        assert len(lab.handed) > 5
        lab.breaks = False
        assert await lab.told_until(12.2) == [
            (ANN, "Your time with KUKA iiwa is over. It is at rest."),
            (BEN, "It is your time: KUKA iiwa is yours until 11:10."),
        ]


async def test_whoever_has_it_without_a_slot_gives_way_when_one_begins() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        lab.begin(BEN)
        assert await lab.told_until(60) == []
        assert await lab.told(1) == [
            (BEN, "KUKA iiwa is booked by Ann from now on. It is at rest."),
            (ANN, BEGINS),
        ]
        assert lab.handed == [("kuka1", "somebody else's time has begun", 3600.0)]


async def test_nobody_gives_way_to_somebody_who_lost_the_right() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 every day 11:00 1h 2 times")
        lab.forbidden.add(ANN)
        lab.begin(BEN)
        back = "You may not move KUKA iiwa any more, so your time with it was given back."
        assert await lab.told_until(61) == [(ANN, back)]
        assert lab.handed == []
        assert lab.calendar.present("kuka1", lab.clock.wall_ns()) is None
        assert lab.decisions()[-1] == ("release", OPERATOR)
        lab.forbidden.clear()  # who may again has what is still to come
        assert [slot.start_ns for slot in lab.times.upcoming(ANN)] == [NOW + (24 * 60 + 60) * MIN]


async def test_a_senior_who_may_stays_and_the_owner_is_told() -> None:
    async with Lab().open() as lab:
        lab.seniors.add(BEN)
        await lab.book(ANN, "kuka1 11:00 1h")
        lab.begin(BEN)
        said = "It is your time with KUKA iiwa, but Ben has it now, and goes before. Ask Ben."
        assert await lab.told_until(61) == [(ANN, said)]
        assert [text for _, text in await lab.told_until(121)] == [FIVE, ONE]
        assert lab.handed == []


async def test_without_a_slot_one_keeps_the_robot_while_it_is_nobodys_time() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 10 min")
        await lab.told_until(61)
        lab.leases["kuka1"].release()
        lab.seniors.add(BEN)
        lab.begin(BEN)  # took it over, as the policy lets seniors do
        await lab.told_until(90)
        assert lab.handed == []


async def test_a_slot_given_back_while_it_is_used_ends_at_rest() -> None:
    async with Lab().open() as lab:
        slot = await lab.book(ANN, "kuka1 11:00 1h")
        await lab.told_until(70)
        lab.begin(ANN)
        await lab.say(ANN, f"/cancel booking {slot.id}")
        assert await lab.told(1) == [(ANN, "Your time with KUKA iiwa is over. It is at rest.")]
        assert len(lab.handed) == 1
        assert await lab.told_until(130) == []


# ---- pauses and clocks ----


async def test_after_a_pause_only_what_is_still_true_is_told() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        lab.clock.jump_wall(60 * 60 + 57 * 60)  # over the start and the first warning
        said = "Your time with KUKA iiwa ends in 3 min, at 12:00."
        assert await lab.told(20) == [(ANN, said)]
        assert await lab.told(99) == []
        assert await lab.told(1) == [(ANN, ONE)]


async def test_after_a_pause_over_all_of_it_nothing_is_told() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        lab.clock.jump_wall(3 * 3600)
        assert await lab.told(600) == []
        assert lab.handed == []


async def test_after_a_pause_whoever_still_has_it_comes_to_rest() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        await lab.told_until(61)
        lab.begin(ANN)
        lab.clock.jump_wall(3 * 3600)
        assert await lab.told(21) == [(ANN, "Your time with KUKA iiwa is over. It is at rest.")]


async def test_a_clock_set_back_tells_nothing_twice() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        assert [text for _, text in await lab.told_until(116)] == [BEGINS, FIVE]
        lab.clock.jump_wall(-3600)
        assert await lab.told_until(118) == []
        lab.clock.jump_wall(-86_400)
        assert await lab.told(3600) == []
        lab.clock.jump_wall(86_400 - 3600)
        assert await lab.told_until(119) == [(ANN, ONE)]


async def test_after_a_restart_nothing_is_told_again() -> None:
    lab = Lab()
    async with lab.open():
        await lab.book(ANN, "kuka1 11:00 1h")
        assert await lab.told_until(61) == [(ANN, BEGINS)]
        lab.begin(ANN)
        await lab.say(BEN, "/wait kuka1")
        assert await lab.told_until(116) == [(ANN, FIVE)]
    again = Lab(lab.store, lab.clock)
    async with again.open():
        assert again.waiting.queue("kuka1") == (BEN,)
        assert await again.told_until(118) == []
        assert await again.told_until(119) == [(ANN, ONE)]
        said = "KUKA iiwa is free and it is your turn. Tap within 60 s to take it."
        assert await again.told_until(120) == [(BEN, said)]


async def test_a_fault_of_one_thing_does_not_end_the_keeper() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        lab.begin(ANN)
        whole = lab.leases.pop("arm")
        lab.waiting.apply(lab.waiting.join(BEN, "arm")[0])  # its lease cannot be looked at
        await lab.say(CEM, "/wait cf1")
        said = " is free and it is your turn. Tap within 60 s to take it."
        assert await lab.told(1) == [(CEM, f"cf1{said}")]
        lab.leases["arm"] = whole
        assert await lab.told(10) == [(BEN, f"The Arm{said}")]
        assert (ANN, BEGINS) in await lab.told_until(60)


async def test_a_start_waits_for_rest_however_long_it_takes() -> None:
    async with Lab().open() as lab:
        lab.rest_s = 30.0
        await lab.book(ANN, "kuka1 11:00 1h")
        lab.begin(BEN)
        assert await lab.told_until(60.49) == []
        assert [who for who, _ in await lab.told_until(60.51)] == [BEN, ANN]
        assert len(lab.handed) == 1


async def test_a_robot_that_comes_to_rest_is_nobodys_turn() -> None:
    async with Lab().open() as lab:
        lab.rest_s = 30.0
        await lab.book(ANN, "kuka1 10:00 10 min")
        lab.begin(ANN)
        await lab.say(BEN, "/wait kuka1")
        await lab.told_until(9.99)
        lab.leases["kuka1"].release()  # gone without a word, just as it begins to come to rest
        lab.begin(ANN)
        await lab.told_until(10.01)
        lab.leases["kuka1"].release()
        lab.scheduler.look()
        assert await lab.told_until(10.49) == []
        assert [who for who, _ in await lab.told_until(10.51)] == [ANN, BEN]
