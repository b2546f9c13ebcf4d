"""What `rosic bench matrix` measures, at a real homeserver; not how fast that is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.bench import matrix
from rosic.bench.command import BENCHES, main
from rosic.bench.comparison import budgets
from rosic.bench.matrix import MatrixLoad, measured
from rosic.bench.matrix_users import ChatFault, MatrixUser
from rosic.bench.recorder import BenchRecorder
from tests.servers import synapse_python

if TYPE_CHECKING:
    from pathlib import Path

    from tests.real.matrix.synapse import Synapse

SMALL = MatrixLoad(turns=1, messages=2, rooms=2, per_s=2.0, lasts_s=1.0)


@pytest.mark.limit(180)
def test_each_message_is_answered_by_both_and_they_stand_beside_each_other() -> None:
    report = measured(BenchRecorder("matrix"), SMALL, synapse_python())

    assert [case.name for case in report.cases] == [
        "echo, plain",
        "ROSIC, plain",
        "echo, encrypted",
        "ROSIC, encrypted",
        "echo, 2 rooms",
        "ROSIC, 2 rooms",
    ]
    assert all(0 < case.p50_us <= case.p99_us for case in report.cases)
    assert [case.lost_share for case in report.cases[-2:]] == [0.0, 0.0]
    assert report.failures == ()
    asked = {budget.ratio for budget in budgets() if budget.bench == "matrix"}
    assert asked
    assert asked <= {ratio.name for ratio in report.ratios}
    (memory,) = report.tables
    assert [row[0] for row in memory.rows] == ["echo", "ROSIC"]
    assert "8 in all" in report.method


@pytest.mark.limit(180)
def test_what_was_measured_before_an_interrupt_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    class InterruptedBench(matrix.MatrixBench):
        """Is interrupted before there are many rooms."""

        async def _in_rooms(self, *_of: object) -> None:
            raise KeyboardInterrupt

    monkeypatch.setattr(matrix, "MatrixBench", InterruptedBench)
    recorder = BenchRecorder("matrix")
    with pytest.raises(KeyboardInterrupt):
        measured(recorder, SMALL, synapse_python())

    report = recorder.partial("It was interrupted.")
    assert [case.name for case in report.cases][-1] == "ROSIC, encrypted"
    assert report.failures == ("It was interrupted.",)


@pytest.mark.limit(90)
async def test_a_message_that_nobody_answers_is_said_to_be_that(
    synapse: Synapse, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rosic.bench.matrix_users.WITHIN_S", 0.2)
    ada = MatrixUser(synapse.create_account("ada"), tmp_path)
    await ada.log_in()
    try:
        async with ada.listening():
            room = await ada.create_room(encrypted=False)
            with pytest.raises(ChatFault, match="'sort' was not answered in"):
                await ada.ask(room, "sort")
    finally:
        await ada.close()


def test_an_environment_without_synapse_is_said_to_be_that(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    nowhere = tmp_path / "bin" / "python"

    with pytest.raises(Exception, match=r"Synapse did not start: No such file or directory"):
        main(["matrix", "--quick", "--synapse", str(nowhere)])
    assert capsys.readouterr().out == ""


def test_without_a_homeserver_a_report_says_so_and_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))

    report = matrix.measure(BenchRecorder("matrix", quick=True), no_install=True)

    assert report.findings == ("matrix-synapse is not installed.",)
    assert (report.cases, report.ratios, report.failures) == ((), (), ())
    assert BENCHES["matrix"].report_options == ("--no-install",)
