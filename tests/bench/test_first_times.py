"""`rosic bench security` and `rosic bench usability`, on real gateways."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.bench import usability
from rosic.bench.recorder import BenchRecorder
from rosic.bench.security import AttemptFigures, attempted, measure, report_of

if TYPE_CHECKING:
    from rosic.bench.usability import FirstTimeSite, PathFigures


@pytest.mark.limit(240)
async def test_an_attempt_that_is_let_through_is_counted_and_the_others_are_refused() -> None:
    # Vi may order here: what is an attempt elsewhere moves the robot.
    seen = {one.name: one async for one in attempted(2, {"Vi": "operator"})}

    assert len(seen) == 11
    # The second may come while the robot is at the first.
    assert seen.pop("an order without the right").through >= 1
    assert {one.name: one.through for one in seen.values() if one.through} == {}
    assert seen["a stranger's order"].listed == 2
    assert seen["a key of the API that never was"].listed == 2


def test_whatever_is_let_through_is_a_failure() -> None:
    recorder = BenchRecorder("security")
    seen = [
        AttemptFigures("a stranger's order", 5, 1, 4, 0),
        AttemptFigures("a guessed join code", 5, 0, 5, 0),
        AttemptFigures("an order that comes twice", 5, 0, 0, 0, tried=False),
    ]

    report = report_of(recorder, seen, 10, 5)

    assert report.failures == (
        "a stranger's order: 1 of 5 attempts were let through.",
        "an order that comes twice: nothing was done the first time, so nothing was tried.",
    )
    assert report.tables[0].rows[0] == ("a stranger's order", 5, 4, 1, 4, 0)


@pytest.mark.campaign
@pytest.mark.limit(400)
def test_the_bench_of_security_times_who_somebody_is() -> None:
    report = measure(BenchRecorder("security", quick=True))

    assert report.failures == ()
    assert len(report.cases) == 7
    assert all(0 < case.p50_us <= case.p99_us for case in report.cases)


@pytest.mark.limit(300)
def test_first_times_take_what_the_documents_promise() -> None:
    report = usability.measure(BenchRecorder("usability", quick=True))

    assert report.failures == ()
    taps_and_words = {row[0]: row[1:3] for row in report.tables[0].rows}
    assert taps_and_words == {
        "join by invitation": (2, 0),
        "join, and a first safe motion": (4, 0),
        "stop a motion": (1, 0),
        "book a time": (1, 1),
        "ask for a right, and use it": (1, 8),
    }
    for *_, seconds in report.tables[0].rows:
        assert isinstance(seconds, float)
        assert seconds > 0


@pytest.mark.limit(240)
def test_a_path_that_does_not_lead_there_is_a_failure_and_the_others_are_walked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def astray(place: FirstTimeSite) -> PathFigures:
        cy, code = await place.newcomer("operator")
        await cy.start(code, "You are invited")
        place.reader.within_s = 0.5
        try:
            await cy.tap("Join", "words that nobody says")
        finally:
            place.reader.within_s = 60.0
        pytest.fail("it was read")

    monkeypatch.setattr(usability, "PATHS", (("astray", astray), usability.PATHS[0]))

    report = usability.measure(BenchRecorder("usability", quick=True))

    assert [row[0] for row in report.tables[0].rows] == ["join by invitation"]
    assert report.failures[0].startswith("astray: nobody read 'words that nobody says'")
