"""`/cancel`: a list with buttons, one, all of them, and other people's."""

from __future__ import annotations

from rosic.errors import NotPermitted, NotUnderstood
from tests.features.booking.booking_handlers import ADA, ANN, BEN, MIN, NOW, Lab


async def test_mine_are_listed_with_a_button_each() -> None:
    async with Lab().open() as lab:
        assert await lab.say(ANN, "/cancel booking") == "You have no times booked."
        await lab.book(ANN, "kuka1 14:00 1h")
        await lab.book(ANN, "arm every tue 14:00 1h 5 times")
        await lab.book(BEN, "kuka1 15:00 1h")
        assert await lab.say(ANN, "/cancel booking") == (
            "Which one is to be cancelled (Europe/Vienna)?\n"
            "KUKA iiwa: 14:00 to 15:00\n"
            "The Arm: Tue 24 Nov 14:00 to 15:00 (and 4 more like it)"
        )
        assert lab.labels() == ["KUKA iiwa: 14:00 to 15:00", "The Arm: Tue 24 Nov 14:00 to 15:00"]
        assert await lab.tap(ANN, "KUKA iiwa: 14:00 to 15:00") == (
            "Cancelled: KUKA iiwa on Sat 21 Nov 2026 from 14:00 to 15:00 (Europe/Vienna)."
        )
        assert lab.decisions()[-1] == ("cancel", ANN)
        assert len(lab.calendar.of(ANN)) == 5


async def test_a_robots_name_lists_the_times_with_it() -> None:
    async with Lab().open() as lab:
        assert (
            await lab.say(ANN, "/cancel booking kuka1") == "You have no time booked with KUKA iiwa."
        )
        await lab.book(ANN, "arm 11:00 1h")
        for hour in range(11, 21):
            await lab.book(ANN, f"kuka1 {hour}:00 30 min")
        said = (await lab.say(ANN, "/cancel booking kuka1 tomorrow 14:30")).splitlines()
        assert said[0] == "Which one is to be cancelled (Europe/Vienna)?"
        assert all(line.startswith("KUKA iiwa: ") for line in said[1:-1])
        assert said[-1] == "and 2 more"
        assert (await lab.tap(ANN, "More")).splitlines()[1:] == [
            "KUKA iiwa: 19:00 to 19:30",
            "KUKA iiwa: 20:00 to 20:30",
        ]
        assert (await lab.tap(ANN, "KUKA iiwa: 20:00 to 20:30")).startswith("Cancelled: KUKA iiwa")


async def test_a_long_list_has_pages() -> None:
    async with Lab().open() as lab:
        for hour in range(11, 21):
            await lab.book(ANN, f"kuka1 {hour}:00 30 min")
        assert (await lab.say(ANN, "/cancel booking")).endswith("\nand 2 more")
        assert (await lab.tap(ANN, "More")).splitlines()[1:] == [
            "KUKA iiwa: 19:00 to 19:30",
            "KUKA iiwa: 20:00 to 20:30",
        ]
        assert "More" not in lab.labels()


async def test_of_a_series_one_or_all() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "arm every tue 14:00 1h 3 times")
        await lab.say(ANN, "/cancel booking")
        question = "The Arm, Tue 24 Nov 14:00 to 15:00, is one of 3 times. Cancel this one, or all"
        assert await lab.tap(ANN, "The Arm: Tue 24 Nov 14:00 to 15:00") == f"{question} of them?"
        assert lab.labels() == ["This one", "All of them"]
        assert len(lab.calendar) == 3
        assert await lab.tap(ANN, "This one") == (
            "Cancelled: The Arm on Tue 24 Nov 2026 from 14:00 to 15:00 (Europe/Vienna)."
        )
        assert len(lab.calendar) == 2
        await lab.say(ANN, f"/cancel booking {lab.calendar.of(ANN)[0].id}")
        assert await lab.tap(ANN, "All of them") == (
            "Cancelled: The Arm, 2 times, first on Tue 1 Dec 2026 from 14:00 to 15:00, last on "
            "Tue 8 Dec 2026 (Europe/Vienna)."
        )
        assert len(lab.calendar) == 0


async def test_the_last_of_a_series_is_not_asked_about() -> None:
    async with Lab().open() as lab:
        slot = await lab.book(ANN, "arm every tue 14:00 1h 1 times")
        assert (await lab.say(ANN, f"/cancel booking {slot.id}")).startswith(
            "Cancelled: The Arm on Tue 24"
        )
        assert lab.calendar.series(slot.series) is None


async def test_a_time_that_has_begun_is_given_back() -> None:
    async with Lab().open() as lab:
        slot = await lab.book(ANN, "kuka1 now 1h")
        await lab.told(600)
        assert await lab.say(ANN, f"/cancel booking {slot.id}") == (
            "KUKA iiwa is given back. The time was booked until 11:00."
        )
        assert lab.calendar.of(ANN)[0].end_ns == NOW + 10 * MIN
        assert await lab.say(ANN, f"/cancel booking {slot.id}") == (
            "That time is over already. Nothing has changed."
        )


async def test_an_id_that_is_none_any_more() -> None:
    async with Lab().open() as lab:
        gone = "0123456789abcdef"
        for said in (gone, f"only {gone}", f"all {gone}"):
            assert await lab.say(ANN, f"/cancel booking {said}") == (
                "There is no such time any more. Nothing has changed."
            )
            assert isinstance(lab.refusal, NotUnderstood)


async def test_what_is_neither_a_robot_nor_a_time() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 14:00 1h")
        for said, name in (("everything", "everything"), ("all of it", "of it"), ("1", "1")):
            assert await lab.say(ANN, f"/cancel booking {said}") == (
                f"I know no robot and no time called {name}. Nothing has changed."
            )
            assert lab.offers() == ("cancel booking",)
        for said in ("all", "only", "all kuka1", "only kuka1 tomorrow"):
            assert "KUKA iiwa: 14:00 to 15:00" in await lab.say(ANN, f"/cancel booking {said}"), (
                said
            )
        assert len(lab.calendar) == 1, "nothing is cancelled before it is said which"


async def test_other_peoples_times_stay_but_for_who_may_cancel_any() -> None:
    async with Lab().open() as lab:
        slot = await lab.book(ANN, "kuka1 14:00 1h")
        series = await lab.book(ANN, "arm every tue 14:00 1h 2 times")
        await lab.told()
        assert await lab.say(BEN, f"/cancel booking {slot.id}") == (
            "That time with KUKA iiwa is Ann's. They can cancel it, or an admin. It stays."
        )
        assert isinstance(lab.refusal, NotPermitted)
        assert (await lab.say(BEN, f"/cancel booking all {series.series}")).startswith(
            "That time with The"
        )
        assert len(lab.calendar) == 3
        assert await lab.say(ADA, f"/cancel booking {slot.id}") == (
            "Cancelled: KUKA iiwa on Sat 21 Nov 2026 from 14:00 to 15:00 (Europe/Vienna)."
        )
        await lab.say(ADA, f"/cancel booking all {series.series}")
        assert await lab.told() == [
            (
                ANN,
                (
                    "Ada cancelled your time with KUKA iiwa on Sat 21 Nov 2026 from 14:00 to 15:00 "
                    "(Europe/Vienna)."
                ),
            ),
            (
                ANN,
                (
                    "Ada cancelled 2 of your times with The Arm, first on Tue 24 Nov 2026 from "
                    "14:00 to 15:00 (Europe/Vienna)."
                ),
            ),
        ]


async def test_of_a_robot_that_one_may_not_see_one_hears_nothing() -> None:
    async with Lab().open() as lab:
        lab.hidden.add("arm")
        slot = await lab.book(ANN, "arm every tue 14:00 1h 2 times")
        for said in (slot.id, f"only {slot.id}", f"all {slot.series}"):
            assert await lab.say(BEN, f"/cancel booking {said}") == (
                "There is no such time any more. Nothing has changed."
            )
        assert len(lab.calendar) == 2
