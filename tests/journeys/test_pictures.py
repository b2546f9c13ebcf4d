"""A picture of a chat is compared without its dates and hours, in every language."""

from __future__ import annotations

import pytest

from rosic.config.plugins import LANGUAGES, catalogue
from rosic.core.i18n import in_language, joined
from rosic.core.local_time import LocalTime
from rosic.features.booking.messages import full_day
from rosic.organiser.calendar_messages import clock_and_day, day
from rosic.testing.telegram.transcript import Bubble, Transcript
from tests.journeys.pictures import lines_of

TWO_YEARS = range(20_500, 21_230)


@pytest.mark.parametrize("code", LANGUAGES)
def test_no_day_makes_a_difference(code: str) -> None:
    now = LocalTime.at(TWO_YEARS[365], 23 * 60 + 59)
    seen = set()
    for number in TWO_YEARS:
        then = LocalTime.at(number, number % 1440)
        said = [in_language(one, catalogue(code)) for one in (full_day(then), day(then, now))]
        said.append(in_language(joined(" ", ("(", clock_and_day(then, now), ")")), catalogue(code)))
        lines = lines_of(Transcript("omni", (Bubble(text="\n".join(said), at="", message=1),)))
        seen.add(tuple(lines))
    assert seen == {("bot> DAY", "  DAY", "  ( TIME )")}
