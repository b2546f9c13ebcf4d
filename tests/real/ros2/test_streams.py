"""No continuous motion outlives a break (I6): real processes are frozen, killed, and come back."""

from __future__ import annotations

import random
import time
from typing import TYPE_CHECKING

import pytest

from rosic.testing.ros2.graph import RosGraph
from tests.pace import patience
from tests.real.ros2.base_profile import WATCHDOG_S
from tests.real.ros2.stream_site import FREEZE, GO_ON, Site

if TYPE_CHECKING:
    from collections.abc import Iterator

SETTLED_S = 0.5
WOKEN_S = 1.0
"""After a break it has gone on by then, if nothing was sent afresh."""
_NS = 1_000_000_000


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    folder = tmp_path_factory.mktemp("streams")
    with RosGraph(folder) as graph:
        yield Site(graph, folder)


def test_a_gateway_that_was_frozen_drives_no_further(site: Site) -> None:
    site.drive(20.0, 1.0)
    back_ns = site.frozen(site.gateway, 3.0)
    told = site.ended()
    time.sleep(SETTLED_S)
    assert [v for v in site.velocities(back_ns) if v.sent_ns > back_ns] == []
    assert told.startswith("failed drove for 1."), told
    assert "by its odometry; broken off because ROSIC itself stood still for 3." in told


def test_a_stop_that_waited_for_a_frozen_gateway_finds_no_motion(site: Site) -> None:
    site.drive(20.0, 0.5)
    site.gateway.process.send_signal(FREEZE)
    site.gateway.say("stop")
    time.sleep(2.0)
    back_ns = time.time_ns()
    site.gateway.process.send_signal(GO_ON)
    rest, ended = site.told("rest"), site.ended()
    site.tell("resume")
    time.sleep(SETTLED_S)
    assert rest == "True"
    assert ended.split()[0] in {"cancelled", "failed"}
    # Of what was being sent when it was frozen, the rest goes out as it wakes.
    assert [v for v in site.velocities(back_ns) if v.sent_ns > back_ns] == []


def test_a_gap_shorter_than_the_watchdog_breaks_nothing(site: Site) -> None:
    site.drive(2.0, 0.5)
    back_ns = site.frozen(site.gateway, WATCHDOG_S / 5)
    told = site.ended()
    if told.startswith("done"):  # a crowded machine may have added to the gap
        assert site.velocities(back_ns)
        assert told == "done drove for 2 s"
    else:
        assert "stood still" in told


def test_a_robot_that_was_frozen_is_driven_no_further(site: Site) -> None:
    site.drive(20.0, 0.5)
    frozen_ns = time.time_ns()
    back_ns = site.frozen(site.base, 2.5)
    told = site.ended()
    time.sleep(SETTLED_S)
    late = frozen_ns + int(1.5 * patience() * _NS)
    assert [v for v in site.velocities(back_ns) if v.sent_ns > late] == []
    # Where it wakes too late to be asked, whether it rests is not known.
    assert told.startswith(("failed drove for 0.", "robot-unreachable Base: drove for 0.")), told
    assert "broken off because it was not heard for 1." in told


@pytest.fixture
def forgetful(site: Site) -> Iterator[Site]:
    """A base that loses what is sent in a break, rests, and then goes on as before."""
    site.base.say("forgetful")
    site.base.expect("ok forgetful")
    yield site
    site.base.say("mindful")
    site.base.expect("ok mindful")
    site.told_after("presence", "online True at_rest True")


@pytest.mark.parametrize("ordered", ["", "stop"])
@pytest.mark.parametrize("seconds", [1.6, 1.8, 3.9])
def test_what_was_lost_in_a_break_is_sent_afresh(
    forgetful: Site, seconds: float, ordered: str
) -> None:
    """It is heard again within the attempt to bring it to rest, or only after it."""
    forgetful.drive(20.0, 0.5)
    forgetful.base.process.send_signal(FREEZE)
    if ordered:
        forgetful.gateway.say(ordered)
    time.sleep(seconds)
    forgetful.base.process.send_signal(GO_ON)
    told = forgetful.ended()
    if ordered:
        forgetful.told("rest")
        forgetful.gateway.say("resume")
    assert not told.startswith("done"), told
    time.sleep(WOKEN_S)
    forgetful.told_after("presence", "online True at_rest True")


def test_a_robot_that_was_killed_and_is_back_is_driven_no_further(site: Site) -> None:
    site.drive(28.0, 0.5)
    site.base.kill()
    killed_s = time.monotonic()
    note = site.told("note")
    assert time.monotonic() - killed_s < 3.0 * patience(), "said within 2 s of its deadline"
    assert note.startswith("broken off because it was not heard for 1.")
    time.sleep(1.0)
    back_ns = time.time_ns()
    site.begin_base()
    told = site.ended()
    time.sleep(3.0)
    assert site.velocities(back_ns) == []
    assert "still moves" not in told
    site.drive(0.5, 0.0)
    assert site.ended().startswith("done"), "a new order moves it again"


@pytest.fixture
def unmeasured(site: Site) -> Iterator[Site]:
    """A base whose odometry has gone, and whose battery is heard on."""
    site.base.say("odometry off")
    site.base.expect("ok odometry off")
    time.sleep(1.5)
    yield site
    site.measure_again()


def test_without_a_fresh_measurement_of_rest_nothing_moves(unmeasured: Site) -> None:
    unmeasured.tell("presence")
    assert unmeasured.told("online") == "True at_rest None", "its battery is still heard"
    begun_ns = time.time_ns()
    unmeasured.tell("drive 2")
    assert unmeasured.ended() == (
        "robot-offline Base is there, but whether it rests cannot be measured now. "
        "Nothing was sent. Whoever looks after Base can help."
    )
    assert unmeasured.velocities(begun_ns) == []


def test_what_was_not_measured_is_not_said_to_move(site: Site) -> None:
    site.drive(20.0, 0.5)
    site.base.say("odometry off")
    try:
        told = site.ended()
    finally:
        site.measure_again()
    assert told.startswith("robot-unreachable Base: drove for 0."), told
    assert "broken off because its motion was not measured for 1." in told
    assert told.endswith(
        "Base was sent zero and told to stop; whether it rests could not be measured."
    )


@pytest.mark.parametrize(
    "rounds", [6, pytest.param(200, marks=[pytest.mark.campaign, pytest.mark.limit(7200)])]
)
def test_no_velocity_after_any_break(site: Site, rounds: int) -> None:
    """Robot and gateway in turn, at random moments, for random times."""
    chance = random.Random(rounds)  # noqa: S311 - the same breaks every time
    after: list[tuple[str, float]] = []
    for turn in range(rounds):
        whose = site.gateway if turn % 2 else site.base
        site.drive(20.0, chance.uniform(0.0, 1.5))
        frozen_ns = time.time_ns()
        seconds = chance.uniform(1.0, 2.5) if whose is site.gateway else chance.uniform(1.8, 3.0)
        back_ns = site.frozen(whose, seconds)
        told = site.ended()
        time.sleep(SETTLED_S)
        broken_ns = back_ns if whose is site.gateway else frozen_ns + int(1.3 * _NS)
        late = [v for v in site.velocities(back_ns) if v.sent_ns > broken_ns]
        if late or not told.startswith(("failed", "robot-unreachable", "still-moves")):
            after.append((told, len(late)))
    assert after == []


def test_what_is_measured_to_move_on_is_said_to(site: Site) -> None:
    """The last here: nothing but its end stops this base any more."""
    site.base.say("stuck")
    site.drive(1.0, 0.0)
    told = site.ended()
    assert told.startswith("still-moves Base"), told
    assert "Base was sent zero and told to stop, and still moves." in told
