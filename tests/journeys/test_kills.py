"""The gateway is killed at random moments; what robots were told is counted elsewhere."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import pytest

from tests.journeys.killing import Plan, journey

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

SEED = int(os.environ.get("ROSIC_SEED", "20261121"))
KILLS = int(os.environ.get("ROSIC_KILLS", "20"))


@pytest.mark.limit(590)
async def test_nothing_is_done_twice_and_everything_is_told_over_20_kills(
    tmp_path: Path, launcher: Launcher, capsys: pytest.CaptureFixture[str]
) -> None:
    report = await journey(Plan(kills=KILLS, seed=SEED), tmp_path, launcher)

    with capsys.disabled():
        print(f"\n{report.text()}")  # noqa: T201 - the figures are the point
    assert report.verdict.wrong == []


@pytest.mark.campaign
@pytest.mark.limit(1800)
@pytest.mark.parametrize("number", range(10))
async def test_nothing_is_done_twice_and_everything_is_told_over_980_kills(
    number: int, tmp_path: Path, launcher: Launcher, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = Plan(kills=98, seed=SEED + number, cold_every=10)
    report = await journey(plan, tmp_path, launcher)

    with capsys.disabled():
        print(f"\n{report.text()}")  # noqa: T201 - the figures are the point
    assert report.verdict.wrong == []


@pytest.mark.parametrize(
    ("fault", "moment", "caught"),
    [
        ("dedup-off", "listening", ("I1: ", "I7: ")),
        ("claim-after-act", "acting", ("I1: ", "I7: ")),
        ("numbers-forgotten", "acting", ("I3: ",)),
        ("unfinished-forgotten", "acting", ("L1: ",)),
    ],
)
@pytest.mark.limit(400)
async def test_a_planted_fault_is_seen(
    fault: str, moment: str, caught: tuple[str, ...], tmp_path: Path, launcher: Launcher
) -> None:
    seen: list[str] = []
    for attempt in range(6):  # chance decides whether a kill hits what is wrong
        plan = Plan(
            kills=5,
            seed=SEED + attempt,
            fault=fault,
            pause_s=0.05,
            twice=0.5,
            moments=(moment,),
            settled_within_s=3.0,
        )
        folder = tmp_path / str(attempt)
        folder.mkdir()
        report = await journey(plan, folder, launcher)
        if any(one.startswith(caught) for one in report.verdict.wrong):
            return
        seen.append(report.text())
    pytest.fail("thirty kills found nothing wrong: " + "\n".join(seen))
