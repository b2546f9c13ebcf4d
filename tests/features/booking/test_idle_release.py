"""Time that nobody uses goes to whoever waits, after a question; use and a tap keep it."""

from __future__ import annotations

from rosic.core.identity import OPERATOR
from tests.features.booking.booking_handlers import ANN, BEN, CEM, MIN, NOW, Lab

FIVE = "Your time with KUKA iiwa ends in 5 min, at 12:00."


async def test_unused_time_is_released_after_a_question_if_somebody_waits() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        await lab.told_until(60)
        await lab.say(BEN, "/wait kuka1")
        assert await lab.told_until(74 - 1 / 60) == []
        assert await lab.told_until(74) == [
            (
                ANN,
                (
                    "Somebody waits for KUKA iiwa, and you have not used it for 14 min. Use it, or "
                    "tap, within 60 s to keep it."
                ),
            ),
        ]
        assert await lab.told_until(75 - 1 / 60) == []
        assert await lab.told_until(75) == [
            (
                ANN,
                (
                    "KUKA iiwa was not used and somebody waits for it, so it was given back. "
                    "It was yours until 12:00."
                ),
            ),
            (BEN, "KUKA iiwa is free and it is your turn. Tap within 60 s to take it."),
        ]
        assert lab.decisions()[-1] == ("release", OPERATOR)
        assert lab.calendar.of(ANN)[0].end_ns == NOW + 75 * MIN


async def test_the_time_of_somebody_who_lost_the_right_is_offered_at_once() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        await lab.told_until(62)
        lab.forbidden.add(ANN)
        await lab.say(BEN, "/wait kuka1")
        assert await lab.told() == [
            (ANN, "You may not move KUKA iiwa any more, so your time with it was given back."),
            (BEN, "KUKA iiwa is free and it is your turn. Tap within 60 s to take it."),
        ]


async def test_unused_time_stays_if_nobody_waits() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        await lab.told_until(60)
        assert await lab.told_until(100) == []
        await lab.say(BEN, "/wait kuka1")
        said = "Somebody waits for KUKA iiwa, and you have not used it for 40 min. Use it, or "
        assert await lab.told() == [(ANN, f"{said}tap, within 60 s to keep it.")]
        assert [who for who, _ in await lab.told_until(101)] == [ANN, BEN]


async def test_an_order_counts_as_use_from_its_end_on() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        await lab.told_until(60)
        await lab.say(BEN, "/wait kuka1")
        await lab.told_until(70)
        lab.begin(ANN)
        assert await lab.told_until(90) == []
        lab.end()
        assert await lab.told_until(104 - 1 / 60) == []
        assert [who for who, _ in await lab.told_until(104)] == [ANN]
        lab.begin(ANN)  # asked, they use it
        assert [text for _, text in await lab.told_until(115)] == [FIVE]


async def test_the_owner_can_keep_it() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        await lab.told_until(60)
        await lab.say(BEN, "/wait kuka1")
        await lab.told_until(74.5)
        assert await lab.tap_told(BEN, "Keep it") == "This question was asked of somebody else."
        assert await lab.tap_told(ANN, "Keep it") == "KUKA iiwa stays yours."
        assert await lab.told_until(88.4) == []
        assert [who for who, _ in await lab.told_until(88.5)] == [ANN]
        assert await lab.say(BEN, "/wait keep kuka1") == (
            "KUKA iiwa is not yours now. Nothing has changed."
        )


async def test_the_owner_can_give_it_back_at_once() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        await lab.told_until(60)
        await lab.say(BEN, "/wait kuka1")
        await lab.told_until(74.5)
        assert await lab.tap_told(ANN, "Give it back") == (
            "KUKA iiwa is given back. The time was booked until 12:00."
        )
        assert await lab.told() == [
            (BEN, "KUKA iiwa is free and it is your turn. Tap within 60 s to take it."),
        ]


async def test_a_clock_set_back_into_an_earlier_slot_counts_that_one_anew() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 10:00 1h")
        await lab.book(BEN, "kuka1 11:00 1h")
        await lab.told_until(80)
        lab.clock.jump_wall(-30 * 60)
        await lab.say(CEM, "/wait kuka1")
        assert await lab.told(30) == []
