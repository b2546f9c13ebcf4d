"""For every test: no skip in silence, no hang, no hours unasked, and the longest files first."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, Phase, settings

from tests.leaks import leaks
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator
    from types import FrameType

REQUIRE_ALL = "ROSIC_REQUIRE_ALL"
# It ends what hangs, and is no measure of how fast a test should be: a machine may be slow. It and
# every other limit is longer by the pace of the run.
USUAL_LIMIT_S = 180.0
RING_AGAIN_S = 5.0

# Hundreds of processes import the same source. Where nothing may be compiled for keeps, most of
# their time goes into compiling it over and over.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# What people read in a terminal follows the terminal's language, and no test depends on that.
for name in ("LC_ALL", "LC_MESSAGES", "LANGUAGE"):
    os.environ.pop(name, None)
os.environ["LANG"] = "C.UTF-8"

# A slow example is no fault of what is tested; a test that means a time limit measures it itself.
settings.register_profile("rosic", deadline=None, suppress_health_check=[HealthCheck.too_slow])
# For a run that has to fail and is not read: the first example that fails will do.
settings.register_profile(
    "unread", settings.get_profile("rosic"), phases=[Phase.explicit, Phase.generate]
)
settings.load_profile("rosic")


# Where several workers share the files, the longest come first, or one would be left with them at
# the end while the others wait. About how long each takes; what is not named takes less.
SECONDS = {
    "tests/journeys/test_kills.py": 120,
    "tests/console/test_page.py": 140,
    "tests/planted/test_faults.py": 550,
    "tests/gateway/test_histories.py": 100,
    "tests/gateway/test_steps.py": 100,
    "tests/api/test_security.py": 55,
    "tests/api/test_limits.py": 40,
    "tests/api/test_rosbridge.py": 40,
    "tests/api/test_client.py": 35,
    "tests/console/test_hostile.py": 35,
    "tests/console/test_breaks.py": 30,
    "tests/console/test_tabs.py": 60,
    "tests/real/ros2/test_rosbridge.py": 45,
    "tests/real/xmpp/test_conformance.py": 35,
    "tests/real/xmpp/test_connection.py": 30,
    "tests/real/xmpp/test_scenarios.py": 50,
    "tests/real/ros2/test_console.py": 35,
    "tests/real/ros2/test_doubtful_rest.py": 95,
    "tests/cli/test_record.py": 50,
    "tests/journeys/test_people.py": 100,
    "tests/real/matrix/test_scenarios.py": 90,
    "tests/real/matrix/test_bench_matrix.py": 60,
    "tests/journeys/test_scenarios.py": 80,
    "tests/journeys/test_bad_network.py": 75,
    "tests/journeys/test_backlog.py": 75,
    "tests/cli/test_bench.py": 90,
    "tests/real/ros2/test_simulation.py": 55,
    "tests/real/ros2/test_server_gone.py": 55,
    "tests/real/ros2/test_streams.py": 60,
    "tests/real/ros2/test_frozen_goal.py": 30,
    "tests/real/ros2/test_robot_stopping.py": 50,
    "tests/real/ros2/test_frozen_fleet.py": 34,
    "tests/real/ros2/test_breaks.py": 30,
    "tests/real/ros2/test_live.py": 30,
    "tests/real/ros2/test_interfaces.py": 50,
    "tests/real/changes/test_half_applied.py": 25,
    "tests/real/ros2/test_discovering.py": 45,
    "tests/real/ros2/test_simulation_swarm.py": 45,
    "tests/real/stores/test_kills.py": 45,
    "tests/journeys/test_among.py": 40,
    "tests/cli/test_run.py": 40,
    "tests/real/ros2/test_actions.py": 40,
    "tests/real/ros2/test_doctor_try.py": 40,
    "tests/journeys/test_account.py": 40,
    "tests/journeys/test_asking.py": 35,
    "tests/journeys/test_buttons.py": 35,
    "tests/journeys/test_first_time.py": 35,
    "tests/real/ros2/test_my_robot_page.py": 35,
    "tests/real/ros2/test_ten_minutes_page.py": 30,
    "tests/real/ros2/test_others.py": 35,
    "tests/stores/test_sifting.py": 35,
    "tests/real/ros2/test_topics.py": 30,
    "tests/journeys/test_single_ros2.py": 30,
    "tests/journeys/test_walk.py": 25,
    "tests/journeys/test_kills_ros2.py": 30,
    "tests/app/test_add_a_command.py": 30,
    "tests/app/test_add_a_feature.py": 30,
    "tests/rosic_sim/robots/machines/test_swarm.py": 30,
    "tests/cli/test_demo.py": 30,
    "tests/real/ros2/test_robot_conformance.py": 75,
    "tests/robots/test_add_a_robot_link.py": 100,
    "tests/real/ros2/test_robot_bindings.py": 25,
    "tests/real/ros2/test_among.py": 25,
    "tests/real/ros2/test_services.py": 25,
    "tests/real/ros2/test_sights.py": 25,
    "tests/real/ros2/test_programs.py": 25,
    "tests/stores/test_facts.py": 25,
    "tests/cli/test_running_access.py": 25,
    "tests/cli/test_mcp.py": 60,
    "tests/api/test_description.py": 40,
    "tests/cli/test_plays.py": 25,
    "tests/journeys/test_stepping.py": 25,
    "tests/journeys/test_card.py": 25,
    "tests/mutants/test_mutants.py": 20,
    "tests/organiser/test_planning_problem.py": 20,
    "tests/core/policy/test_exhaustive.py": 20,
    "tests/rendering/test_drawings.py": 20,
    "tests/journeys/test_channel.py": 20,
    "tests/journeys/test_given_again.py": 20,
    "tests/journeys/test_groups.py": 20,
    "tests/journeys/test_seeing.py": 20,
    "tests/journeys/test_stops.py": 20,
    "tests/journeys/test_two_gateways.py": 20,
    "tests/journeys/test_large_files.py": 20,
    "tests/cli/test_doctor.py": 20,
    "tests/real/ros2/test_robot_dialogue.py": 15,
    "tests/core/policy/test_planted.py": 15,
    "tests/cli/test_robot_add.py": 15,
    "tests/cli/test_plays_interrupted.py": 15,
    "tests/shape/test_conduct.py": 15,
    "tests/shape/test_alone.py": 15,
    "tests/real/ros2/test_common_start.py": 15,
    "tests/testing/telegram/test_clients.py": 15,
    "tests/journeys/test_single.py": 15,
}


def pytest_configure() -> None:
    """Measure the pace before anything runs, unless `make` has."""
    pace()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave campaigns out, unless the mark expression speaks of them. Put the longest first."""
    _leave_campaigns_out(config, items)
    if hasattr(config, "workerinput"):
        items.sort(key=lambda item: -SECONDS.get(item.nodeid.partition("::")[0], 0))


def _leave_campaigns_out(config: pytest.Config, items: list[pytest.Item]) -> None:
    if "campaign" in config.getoption("markexpr"):
        return
    long = [item for item in items if item.get_closest_marker("campaign")]
    if long:
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if item not in long]


# ---- no skip where everything must run ----


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    _refuse_skip(report)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    report = yield
    _refuse_skip(report)
    return report


def _refuse_skip(report: pytest.TestReport | pytest.CollectReport) -> None:
    """Turn a skip into a failure that keeps its sentence. An expected failure is no skip."""
    if os.environ.get(REQUIRE_ALL) != "1" or not report.skipped or hasattr(report, "wasxfail"):
        return
    sentence = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    report.outcome = "failed"
    report.longrepr = f"{REQUIRE_ALL}=1, and this was skipped: {sentence}"


# ---- no token in anything that was written ----


@pytest.fixture(scope="session", autouse=True)
def _no_token_was_written(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    yield
    found = leaks(tmp_path_factory.getbasetemp())
    assert not found, f"a token stands in {', '.join(found)}"


# ---- no test without end ----


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Generator[None, None, None]:
    with _limited(item):
        yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, None, None]:
    with _limited(item):
        yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item) -> Generator[None, None, None]:
    with _limited(item):
        yield


@contextmanager
def _limited(item: pytest.Item) -> Iterator[None]:
    """Fail the phase from inside when its time is up: fixtures still put their servers away.

    It rings again and again, because a failure raised inside an asyncio task stays in that task.
    """
    marker = item.get_closest_marker("limit")
    limit_s = (float(marker.args[0]) if marker else USUAL_LIMIT_S) * pace()

    def ring(_signal: int, _frame: FrameType | None) -> None:
        pytest.fail(f"took longer than {limit_s:g} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, limit_s, RING_AGAIN_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
