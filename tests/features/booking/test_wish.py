"""`/wish`: one more, the list, one less, and what is refused."""

from __future__ import annotations

from rosic.core.records import Fact
from rosic.errors import NotPermitted, NotUnderstood, OutOfBounds, TooManyRequests
from rosic.organiser.planning.wishes import MOST_EACH, WISH
from tests.features.booking.booking_handlers import ANN, BEN, HOUR, VI, FullDisk, Lab


async def test_a_wish_is_noted_listed_and_taken_back() -> None:
    async with Lab().open() as lab:
        assert await lab.say(ANN, "/wish kuka1 1h tomorrow 9:00 to 17:00") == (
            "I noted your wish: KUKA iiwa for 1 h, tomorrow 09:00 to 17:00. "
            "Nothing is booked yet; I tell you when it is."
        )
        await lab.say(ANN, "/wish arm tomorrow 14-16 1 h 30 min")
        assert lab.calendar.of(ANN) == ()
        assert await lab.say(ANN, "/wish") == (
            "Your wishes. /wish off 1 takes the first one back.\n"
            "1. KUKA iiwa for 1 h, tomorrow 09:00 to 17:00\n"
            "2. The Arm for 1 h 30 min, tomorrow 14:00 to 16:00"
        )
        assert await lab.say(BEN, "/wish") == (
            "You have no wishes. Say one as /wish ROBOT 1h tomorrow 9:00 to 17:00."
        )
        assert "KUKA iiwa" in await lab.say(ANN, "/wish off 1")
        assert [wished.robots for wished in lab.wishes.of(ANN)] == [("arm",)]
        await lab.say(ANN, "/wish off 2")
        assert isinstance(lab.refusal, NotUnderstood)
        await lab.say(BEN, "/wish off 1")
        assert isinstance(lab.refusal, NotUnderstood), "only mine are numbered"


async def test_a_wish_says_how_much_it_is_wished_for() -> None:
    async with Lab().open() as lab:
        for text in ("priority 3", "Priorität 3", "prio 3."):
            noted = await lab.say(ANN, f"/wish kuka1 1h tomorrow 9-17 {text}")
            assert "tomorrow 09:00 to 17:00, priority 3." in noted, text
        assert [wished.priority for wished in lab.wishes.of(ANN)] == [3, 3, 3]
        for wrong in ("priority 0", "priority 6"):
            await lab.say(ANN, f"/wish kuka1 1h tomorrow 9-17 {wrong}")
            assert lab.refusal is not None
            assert lab.refusal.sentence == "A priority is a number from 1 to 5."
        assert len(lab.wishes.of(ANN)) == 3


async def test_the_button_takes_the_wish_back() -> None:
    async with Lab().open() as lab:
        await lab.say(ANN, "/wish kuka1 1h tomorrow 9-17")
        await lab.tap(ANN, "Take it back")
        assert lab.wishes.of(ANN) == ()


async def test_any_of_a_group_leaves_out_what_is_not_booked() -> None:
    async with Lab().open() as lab:
        await lab.say(ANN, "/wish any of swarm 1h tomorrow 9-17")
        assert isinstance(lab.refusal, OutOfBounds)
        await lab.say(VI, "/wish kuka1 1h tomorrow 9-17")
        assert isinstance(lab.refusal, NotPermitted)
        assert lab.wishes.everybodys() == ()


async def test_what_cannot_be_is_refused() -> None:
    async with Lab().open() as lab:
        for text, kind in (
            ("kuka1", NotUnderstood),
            ("kuka1 1h", NotUnderstood),
            ("kuka1 tomorrow 9-17", NotUnderstood),
            ("nobody 1h tomorrow 9-17", NotUnderstood),
            ("kuka1 3h tomorrow 9-11", OutOfBounds),
            ("kuka1 1h today 8-9:30", OutOfBounds),
            ("kuka1 1h every tue 9-17 3 times", OutOfBounds),
            ("kuka1 1h 2029-01-01 9-17", OutOfBounds),
        ):
            await lab.say(ANN, f"/wish {text}")
            assert isinstance(lab.refusal, kind), (text, lab.refusal, lab.reply)
        assert lab.wishes.everybodys() == ()


async def test_nobody_has_more_than_ten() -> None:
    async with Lab().open() as lab:
        for _ in range(MOST_EACH):
            await lab.say(ANN, "/wish kuka1 1h tomorrow 9-17")
            assert lab.refusal is None
        await lab.say(ANN, "/wish kuka1 1h tomorrow 9-17")
        assert isinstance(lab.refusal, TooManyRequests)
        assert len(lab.wishes.of(ANN)) == MOST_EACH


async def test_a_wish_is_forgotten_when_its_window_is_over() -> None:
    async with Lab().open() as lab:
        await lab.say(ANN, "/wish kuka1 1h today 11-12:30")
        await lab.clock.advance(2 * HOUR / 1e9)
        assert "no wishes" in await lab.say(ANN, "/wish")
        await lab.say(BEN, "/wish kuka1 1h tomorrow 9-17")
        assert len((await lab.store.open()).facts[WISH]) == 1, "it is gone from the disk as well"


async def test_wishes_outlive_a_restart_and_what_cannot_be_read_is_left_out() -> None:
    async with Lab().open() as lab:
        await lab.say(ANN, "/wish kuka1 1h tomorrow 9-17")
        await lab.store.write(Fact(kind=WISH, key="x", body=b"\xc1"))
    async with Lab(lab.store, lab.clock).open() as again:
        (wished,) = again.wishes.of(ANN)
        assert wished.robots == ("kuka1",)
        await again.say(ANN, "/wish kuka1 1h tomorrow 9-17")
        assert len(again.wishes.of(ANN)) == 2
        again.wishes.restore(again.wishes.end_all(ANN))
        assert again.wishes.everybodys() == (), "nothing is left of somebody who leaves"


async def test_a_wish_that_cannot_be_written_is_none() -> None:
    store = FullDisk()
    async with Lab(store).open() as lab:
        store.full = True
        assert "nothing was changed" in await lab.say(ANN, "/wish kuka1 1h tomorrow 9-17")
        assert lab.wishes.of(ANN) == ()
