"""`/plan`: what is proposed, and booking all of it or nothing."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import msgspec

from rosic.errors import NotPermitted
from tests.features.booking.booking_handlers import ADA, ANN, BEN, CEM, Lab

if TYPE_CHECKING:
    import pytest

LATE = "kuka1 1h tomorrow 9-11"
EARLY = "kuka1 1h tomorrow 9-10"
ALL = "Book all of it"


async def _two_wishes(lab: Lab) -> str:
    """Let Ann come first, so that in the order of arrival Ben would get nothing."""
    await lab.say(ANN, f"/wish {LATE}")
    await lab.say(BEN, f"/wish {EARLY}")
    return await lab.say(ADA, "/plan")


async def test_everybody_is_served_by_one_tap_and_told() -> None:
    async with Lab().open() as lab:
        assert await _two_wishes(lab) == (
            "2 of 2 wishes can be granted.\n"
            "Ben: KUKA iiwa, tomorrow 09:00 to 10:00\n"
            "Ann: KUKA iiwa, tomorrow 10:00 to 11:00\n"
            "In use for 100 % of the free time; first come first served: 50 %."
        )
        assert lab.labels() == [ALL, "Leave it"]
        assert lab.calendar.of(ANN) == lab.calendar.of(BEN) == ()
        await lab.told()
        assert await lab.tap(ADA, ALL) == "Booked: 2 times. I told whose they are."
        assert sorted(await lab.told()) == [
            (ANN, "Your wish came true: KUKA iiwa is yours, tomorrow 10:00 to 11:00."),
            (BEN, "Your wish came true: KUKA iiwa is yours, tomorrow 09:00 to 10:00."),
        ]
        assert [len(lab.calendar.of(who)) for who in (ANN, BEN, ADA)] == [1, 1, 0]
        assert lab.wishes.everybodys() == ()
        assert lab.decisions() == [("book", ADA)]
        assert await lab.say(ADA, "/plan") == "Nobody wishes for anything now."


async def test_who_gets_nothing_is_told_why() -> None:
    async with Lab().open() as lab:
        await lab.book(CEM, "arm tomorrow 9:00 2h")
        await lab.say(ANN, f"/wish {EARLY}")
        await lab.say(BEN, f"/wish {EARLY}")
        await lab.say(CEM, "/wish arm 1h tomorrow 9-11")
        text = await lab.say(ADA, "/plan")
        assert text.startswith("1 of 3 wishes can be granted.")
        assert "in that window it goes to other wishes." in text
        assert "Cem gets nothing for The Arm for 1 h, tomorrow 09:00 to 11:00: it is booked" in text
        assert await lab.tap(ADA, "Leave it") == "Nothing was booked. The wishes stay."
        assert len(lab.wishes.everybodys()) == 3


async def test_who_says_a_priority_goes_first_and_the_admin_sees_it() -> None:
    async with Lab().open() as lab:
        await lab.say(ANN, f"/wish {EARLY}")
        await lab.say(BEN, f"/wish {EARLY} priority 4")
        text = await lab.say(ADA, "/plan")
        assert "\nBen: KUKA iiwa, tomorrow 09:00 to 10:00, priority 4\n" in text
        assert "\nAnn gets nothing for" in text


async def test_a_right_that_ended_meanwhile_gets_nothing() -> None:
    async with Lab().open() as lab:
        await lab.say(ANN, f"/wish {EARLY}")
        lab.forbidden.add(ANN)
        text = await lab.say(ADA, "/plan")
        assert "they may not use it any more." in text
        assert lab.labels() == []


async def test_nothing_is_booked_when_the_calendar_changed_meanwhile() -> None:
    async with Lab().open() as lab:
        await _two_wishes(lab)
        proposed = lab.reply
        await lab.book(CEM, "kuka1 tomorrow 10:00 1h")
        lab.reply = proposed
        await lab.told()
        text = await lab.tap(ADA, ALL)
        assert text.startswith(
            "Things have changed meanwhile, so nothing was booked. This is a new plan.\n"
            "1 of 2 wishes can be granted."
        )
        assert lab.calendar.of(ANN) == lab.calendar.of(BEN) == ()
        assert await lab.told() == []
        assert await lab.tap(ADA, ALL) == "Booked: 1 time. I told whose it is."
        assert len(lab.wishes.everybodys()) == 1


async def test_a_wish_taken_back_meanwhile_is_not_booked() -> None:
    async with Lab().open() as lab:
        await _two_wishes(lab)
        proposed = lab.reply
        await lab.say(BEN, "/wish off 1")
        lab.reply = proposed
        assert "Things have changed" in await lab.tap(ADA, ALL)
        assert lab.calendar.of(BEN) == lab.calendar.of(ANN) == ()


async def test_after_a_restart_it_is_proposed_anew() -> None:
    async with Lab().open() as lab:
        await _two_wishes(lab)
        proposed = lab.reply
    async with Lab(lab.store, lab.clock).open() as again:
        again.reply = proposed
        assert "This is a new plan." in await again.tap(ADA, ALL)
        assert again.calendar.of(ANN) == ()
        assert "Booked: 2 times." in await again.tap(ADA, ALL)


async def test_only_an_admin_makes_plans() -> None:
    async with Lab().open() as lab:
        await _two_wishes(lab)
        proposed = lab.reply
        assert "Only an admin" in await lab.say(ANN, "/plan")
        assert isinstance(lab.refusal, NotPermitted)
        lab.reply = proposed
        await lab.tap(BEN, ALL)
        assert isinstance(lab.refusal, NotPermitted)
        assert lab.calendar.of(BEN) == ()


async def test_nobody_gets_more_times_than_one_may_have() -> None:
    async with Lab().open() as lab:
        lab.calendar.limits = msgspec.structs.replace(lab.calendar.limits, most_upcoming=2)
        await lab.book(ANN, "arm tomorrow 14:00 1h")
        for robot in ("kuka1", "omni"):
            assert "I noted" in await lab.say(ANN, f"/wish {robot} 1h tomorrow 9-17")
        text = await lab.say(ADA, "/plan")
        assert text.startswith("1 of 2 wishes can be granted.")
        assert "Ann gets nothing for omni for 1 h" in text
        assert "they have as many times booked as one may." in text
        assert await lab.tap(ADA, ALL) == "Booked: 1 time. I told whose it is."
        assert "0 of 1 wish can be granted." in await lab.say(ADA, "/plan")
        assert lab.labels() == []


async def test_without_the_solver_it_is_the_order_of_arrival(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in [name for name in sys.modules if name.split(".")[0] == "scipy"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "scipy", None)
    async with Lab().open() as lab:
        text = await _two_wishes(lab)
        assert text.startswith("1 of 2 wishes")
        last = "weighing all wishes together needs the extra schedule."
        assert text.endswith(f"This is first come first served: {last}")


async def test_of_a_group_one_robot_is_enough() -> None:
    async with Lab().open() as lab:
        for who in (ANN, BEN):
            said = await lab.say(who, "/wish any of desks 1h tomorrow 9-10")
            assert "KUKA iiwa or The Arm for 1 h" in said
        assert (await lab.say(ADA, "/plan")).startswith("2 of 2 wishes can be granted.")
        await lab.tap(ADA, ALL)
        robots = [slot.robot for who in (ANN, BEN) for slot in lab.calendar.of(who)]
        assert sorted(robots) == ["arm", "kuka1"]
