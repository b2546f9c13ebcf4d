"""`rosic schedule plan`: wishes in, a proposal out, and booked if that was asked for."""

from __future__ import annotations

import asyncio
import json
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING

import msgspec
import pytest

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.offline import OfflineAdmin, OfflineSeeding
from rosic.app.admin.schedule import BookParameters, KnownNames, SlotBooking, merged_who
from rosic.app.config import load_config
from rosic.core.time_units import MINUTE_NS
from rosic.errors import (
    NotPermitted,
    NotUnderstood,
    OutOfBounds,
    Refusal,
    RobotTaken,
    TooManyRequests,
)
from rosic.organiser.recurrence import SeriesLimits
from rosic.system import SystemClock, SystemEntropy
from tests.cli.offline import Place

if TYPE_CHECKING:
    from pathlib import Path

HEAD = "person,robots,length,earliest,latest,priority\n"
DAY = (datetime.now(tz=UTC) + timedelta(days=7)).strftime("%Y-%m-%d")


@pytest.fixture
def place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Place:
    return Place(tmp_path, capsys).begun()


def wishes(place: Place, *rows: str) -> str:
    path = place.folder / "week.csv"
    path.write_text(HEAD + "".join(f"{row}\n" for row in rows))
    return str(path)


def test_a_plan_is_proposed_and_nothing_is_booked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = Place(tmp_path, capsys)
    file = wishes(
        place,
        f"Ada,omni,1 h,{DAY} 09:00,{DAY} 12:00,",
        f"Bob,omni kuka1,2 h,{DAY} 09:00,{DAY} 12:00,3",
    )
    said = place.good("schedule plan", file)

    assert said.startswith("2 of 2 wishes can be granted.")
    assert "09:00 to 10:00  omni  Ada" in said
    assert "09:00 to 11:00  kuka1  Bob" in said
    assert not (place.folder / "rosic-data").exists()


def test_nothing_is_planned_while_the_place_is_closed(place: Place) -> None:
    file = wishes(place, f"Ada,omni,1 h,{DAY} 06:00,{DAY} 12:00,")
    assert "10:00 to 11:00  omni  Ada" in place.good("schedule plan", file, "--open", "10:00-18:00")
    assert "0 of 1 wish" in place.good("schedule plan", file, "--open", "22:00-6:30")
    for hours in ("soon", "10:00-10:00", "9:75-10:00", "10:00-25:00"):
        wrong = place.wrong("schedule plan", file, "--open", hours)
        assert wrong.endswith("Write --open 08:00-18:00.")


def test_what_was_booked_stands(place: Place) -> None:
    file = wishes(place, f"Bob,omni,2 h,{DAY} 09:00,{DAY} 11:00,")
    assert place.good("schedule plan", file, "--book").endswith("\nBooked: 1 slot.\n")

    again = place.good("schedule plan", file, "--book")

    assert "0 of 1 wish can be granted." in again
    assert "omni is booked" in again
    assert again.endswith("Nothing was booked.\n")


def test_a_list_in_json_is_read_as_well(place: Place) -> None:
    path = place.folder / "week.json"
    row = {
        "person": "Bob",
        "robots": ["omni"],
        "length": "30 min",
        "earliest": f"{DAY} 09:00",
        "latest": f"{DAY} 12:00",
    }
    path.write_text(json.dumps([row]))

    assert "09:00 to 09:30  omni  Bob" in place.good("schedule plan", str(path))


def book(place: Place, *slots: tuple[str, str, int, int]) -> str:
    """Ask for slots (name, robot, minutes from now, seconds) as the second half of a plan does."""
    alone = OfflineAdmin(
        place.folder / "rosic-data", load_config(place.config), SystemClock(), SystemEntropy()
    )

    async def booked() -> str:
        answers = await alone.do(AdminRequest(AdminVerb.WHO), OfflineSeeding.WRITTEN)
        people = merged_who(msgspec.json.decode(text, type=KnownNames) for text in answers).people
        now_ns = SystemClock().wall_ns()
        asked = BookParameters(
            tuple(
                SlotBooking(people[who], robot, now_ns + minutes * MINUTE_NS, length_s)
                for who, robot, minutes, length_s in slots
            )
        )
        ask = AdminRequest(AdminVerb.BOOK, body=msgspec.Raw(msgspec.json.encode(asked)))
        return "".join(await alone.do(ask, OfflineSeeding.WRITTEN))

    return asyncio.run(booked())


def test_a_person_gets_no_more_than_one_may_have(place: Place) -> None:
    most = SeriesLimits().most_upcoming
    with pytest.raises(TooManyRequests, match=f"Bob would have {most + 1} slots to come"):
        book(place, *[("Bob", "omni", 10 * i, 300) for i in range(1, most + 2)])

    assert book(place, ("Bob", "omni", 10, 300)) == "Booked: 1 slot."


def test_nobody_is_booked_who_may_not_move_the_robot(place: Place) -> None:
    place.config.write_text(place.config.read_text().replace('"operator"', '"viewer"'))
    with pytest.raises(NotPermitted, match=r"Bob may not move omni now. Nothing was booked."):
        book(place, ("Ada", "kuka1", 10, 300), ("Bob", "omni", 10, 300))
    place.good("lock", "Ada")
    with pytest.raises(NotPermitted, match="Ada may not move KUKA iiwa now"):
        book(place, ("Ada", "kuka1", 10, 300))


def test_the_times_of_whoever_is_revoked_are_free_again(place: Place) -> None:
    assert book(place, ("Bob", "omni", 10, 300)) == "Booked: 1 slot."
    with pytest.raises(RobotTaken):
        book(place, ("Ada", "omni", 10, 300))
    assert "no access any more" in place.good("revoke", "Bob")
    assert book(place, ("Ada", "omni", 10, 300)) == "Booked: 1 slot."


@pytest.mark.parametrize(
    ("slots", "refusal", "sentence"),
    [
        ([("Bob", "omni", 10, 3600), ("Ada", "omni", 60, 3600)], RobotTaken, "given twice"),
        ([("Bob", "omni", 10, 600), ("Ada", "kuka9", 60, 600)], NotUnderstood, "called kuka9"),
        ([("Bob", "omni", 10, 600), ("Ada", "omni", -60, 600)], OutOfBounds, "over"),
        ([("Bob", "omni", 10, 600), ("Ada", "kuka1", 60, 0)], OutOfBounds, "longer"),
    ],
)
def test_all_of_a_plan_is_booked_or_nothing(
    place: Place,
    slots: list[tuple[str, str, int, int]],
    refusal: type[Refusal],
    sentence: str,
) -> None:
    with pytest.raises(refusal, match=sentence):
        book(place, *slots)

    assert book(place, ("Bob", "omni", 10, 600)) == "Booked: 1 slot."


def test_wrong_lines_are_named_and_nothing_is_planned(place: Place) -> None:
    file = wishes(
        place,
        f"Zed,omni,1 h,{DAY} 09:00,{DAY} 12:00,",
        f"Ada,kuka9,1 h,{DAY} 09:00,{DAY} 12:00,",
        f"Ada,omni,0 h,{DAY} 09:00,{DAY} 12:00,",
        "Ada,omni,1 h,2020-01-01 09:00,2020-01-01 12:00,",
    )
    said = place.rosic("schedule plan", file, "--book")

    assert (said.status, said.out) == (2, "")
    lines = said.err.splitlines()
    assert lines[0] == 'week.csv:2: I know nobody called "Zed".'
    assert lines[1] == 'week.csv:3: I know no robot called "kuka9".'
    assert lines[2].startswith('week.csv:4: "0 h" is not a length')
    assert lines[3:] == [
        "week.csv:5: That time is over.",
        "4 lines are wrong. Nothing was planned.",
    ]


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("none.csv", None, "There is no such file."),
        ("week.txt", "", "ends in .csv or .json"),
        ("week.csv", b"\xff\xfe\xff", "The file is not UTF-8 text."),
    ],
)
def test_what_is_no_list_is_one_sentence(
    place: Place, name: str, text: str | bytes | None, sentence: str
) -> None:
    path = place.folder / name
    if text is not None:
        path.write_bytes(text if isinstance(text, bytes) else text.encode())

    assert sentence in place.wrong("schedule plan", str(path))


def test_without_the_solver_it_says_how_to_get_it(
    place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys  # noqa: PLC0415 - only to take a library away

    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    file = wishes(place, f"Bob,omni,2 h,{DAY} 09:00,{DAY} 12:00,")

    said = place.good("schedule plan", file)

    assert "This is the order of arrival." in said
    assert "pip install 'rosic[schedule]' (in a checkout: " in said
