"""A robot that is driven live over ROS 2: real processes, frozen, killed, late, and silent.

What moved is asked of the robot's own side: the velocities that it took, and its speed.
"""

from __future__ import annotations

import random
import threading
import time
from itertools import count
from statistics import median
from typing import TYPE_CHECKING

import pytest

from rosic.core.sample_gate import LATE_S
from rosic.testing.ros2.graph import RosGraph
from tests.pace import patience
from tests.real.ros2.base_profile import WATCHDOG_S
from tests.real.ros2.live_driver import CAP_M_S
from tests.real.ros2.stream_site import FREEZE, GO_ON, Site

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

_NS = 1_000_000_000
SETTLED_S = 0.5
RESTS_WITHIN_S = WATCHDOG_S + 0.3


class LiveSite(Site):
    """A base, the gateway's side, and a hand at its controls in a thread of its own."""

    driver = "tests.real.ros2.live_driver"

    def __init__(self, graph: RosGraph, folder: Path) -> None:
        super().__init__(graph, folder)
        self.number = count(1)
        self.last_ns = 0
        self.ahead_ns = 0
        self._held: threading.Thread | None = None
        self._lets_go = threading.Event()
        self._writes = threading.Lock()

    def put(self, m_s: float, late_s: float = 0.0, number: int | None = None) -> None:
        """Send one sample, dated when it was sent, or earlier."""
        now_ns = time.time_ns()
        sent_ns = now_ns - int(late_s * _NS) + self.ahead_ns
        with self._writes:
            self.gateway.say(f"sample {number or next(self.number)} {sent_ns} {m_s}")
        self.last_ns = now_ns

    def hold(self, speed: Callable[[float], float] | float, hz: float = 20.0) -> None:
        """Hold a stick from now on: at a speed, or at one of the time since then."""
        self.fall_silent()
        self._lets_go = lets_go = threading.Event()
        begun_s = time.monotonic()

        def hold() -> None:
            for turn in count():
                past_s = time.monotonic() - begun_s
                self.put(speed if isinstance(speed, float) else speed(past_s))
                if lets_go.wait(max(0.0, begun_s + (turn + 1) / hz - time.monotonic())):
                    return

        self._held = threading.Thread(target=hold, daemon=True)
        self._held.start()

    def fall_silent(self) -> None:
        """Send nothing any more."""
        if self._held is not None:
            self._lets_go.set()
            self._held.join()
        self._held = None

    def begin(self, speed: Callable[[float], float] | float = 0.2, hz: float = 20.0) -> None:
        """Begin a live order and hold a stick; return once the robot is measured to move."""
        self.number = count(1)
        self.ahead_ns = 0
        self.tell("live")
        self.hold(speed, hz)
        self.told("driving")

    def speed(self) -> float:
        """Ask the robot's side how fast it is."""
        self.base.say("speed")
        return float(self.base.expect("speed"))

    def rests_since_ns(self, limit_s: float) -> int:
        """Wait until the robot's side says that it rests; return when that was."""
        end_s = time.monotonic() + limit_s
        while self.speed():
            assert time.monotonic() < end_s, "it moves on"
            time.sleep(0.01)
        return time.time_ns()

    def counts(self) -> dict[str, int]:
        """Return how many samples became what."""
        self.tell("counts")
        pairs = [pair.split("=") for pair in self.told("counts").split()]
        return {name: int(number) for name, number in pairs}


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveSite]:
    folder = tmp_path_factory.mktemp("live")
    with RosGraph(folder) as graph:
        yield LiveSite(graph, folder)


@pytest.fixture
def site(shared: LiveSite) -> Iterator[LiveSite]:
    yield shared
    shared.fall_silent()
    shared.gateway.say("release")
    # The base rests before its order has ended, and that end is not one of the next test.
    shared.told_after("presence", "orders 0")
    shared.told_after("presence", "online True at_rest True")


def test_values_arrive_within_the_bounds_and_it_is_done_at_rest(site: LiveSite) -> None:
    begun_ns = time.time_ns()
    site.begin(0.1)
    for speed in (0.3, 5.0, -5.0):
        site.hold(speed)
        time.sleep(0.3 * patience())
    site.fall_silent()
    site.gateway.say("release")
    assert site.ended().startswith("done - drove for ")
    assert site.speed() == 0.0
    seen = list(dict.fromkeys(v.m_s for v in site.velocities(begun_ns)))
    assert seen == [0.1, 0.3, CAP_M_S, -CAP_M_S]


def test_silence_brings_it_to_rest_for_good(site: LiveSite) -> None:
    site.begin()
    site.fall_silent()
    silent_ns = site.last_ns
    rests_ns = site.rests_since_ns(5.0 * patience())
    assert (rests_ns - silent_ns) / _NS <= RESTS_WITHIN_S * patience()
    site.hold(0.2)
    assert site.ended().startswith("cancelled controls-silent the controls fell silent; drove for")
    time.sleep(SETTLED_S)
    late_ns = silent_ns + int((LATE_S + 0.1) * patience() * _NS)
    assert site.velocities(late_ns) == []
    assert site.speed() == 0.0


def test_what_is_late_or_out_of_order_never_reaches_it(site: LiveSite) -> None:
    begun_ns = time.time_ns()
    site.begin(0.1)
    for number in range(10):
        site.put(0.35, late_s=LATE_S + 0.1 + number)
        site.put(0.36, number=1)
        time.sleep(0.02)
    counts = site.counts()
    assert counts["late"] >= 10
    assert counts["out-of-order"] >= 10
    assert {v.m_s for v in site.velocities(begun_ns)} == {0.1}


def test_zero_is_held_and_it_goes_on_from_there(site: LiveSite) -> None:
    """Whoever holds a stick in the middle has not let go: it rests, and is under way."""
    site.begin(lambda past_s: 0.2 if past_s < 0.5 or past_s > 3.0 else 0.0)
    time.sleep(2.5)
    assert site.speed() == 0.0
    end_s = time.monotonic() + 10 * patience()
    while not site.speed():
        assert time.monotonic() < end_s
        time.sleep(0.05)
    site.fall_silent()
    site.gateway.say("release")
    assert site.ended().startswith("done")


@pytest.mark.parametrize("seconds", [0.4, 3.0])
def test_a_gateway_that_was_frozen_drives_no_further(site: LiveSite, seconds: float) -> None:
    """Samples go on coming meanwhile: the robot's watchdog ends it, and nothing begins it again."""
    site.begin()
    site.gateway.process.send_signal(FREEZE)
    frozen_ns = time.time_ns()
    if seconds > RESTS_WITHIN_S * patience():
        rests_ns = site.rests_since_ns(seconds)
        assert (rests_ns - frozen_ns) / _NS <= RESTS_WITHIN_S * patience()
    time.sleep(max(0.0, seconds - (time.time_ns() - frozen_ns) / _NS))
    back_ns = time.time_ns()
    site.gateway.process.send_signal(GO_ON)
    told = site.ended()
    time.sleep(SETTLED_S)
    # What was on its way as it was frozen goes out as it wakes.
    assert [v for v in site.velocities(back_ns) if v.sent_ns > back_ns] == []
    assert told.startswith(("failed stood-still", "cancelled controls-silent")), told
    assert site.speed() == 0.0


def test_a_stop_ends_it_at_any_moment(site: LiveSite) -> None:
    chance = random.Random(7)  # noqa: S311 - the same moments every time
    for _ in range(4):
        site.begin()
        time.sleep(chance.uniform(0.0, 0.3))
        site.gateway.say("stop")
        assert site.told("rest") == "True"
        rested_ns = time.time_ns()
        assert site.ended().startswith("cancelled")
        time.sleep(0.2)  # the stick is still held
        assert [v for v in site.velocities(rested_ns) if v.sent_ns > rested_ns] == []
        assert site.speed() == 0.0
        site.gateway.say("resume")
        site.fall_silent()


@pytest.mark.parametrize("ahead_s", [2.0, -2.0])
def test_a_clock_of_the_sender_that_is_set_brings_it_to_rest(
    site: LiveSite, ahead_s: float
) -> None:
    site.begin()
    site.ahead_ns = int(ahead_s * _NS)
    set_ns = time.time_ns()
    rests_ns = site.rests_since_ns(5.0 * patience())
    assert (rests_ns - set_ns) / _NS <= RESTS_WITHIN_S * patience()
    assert site.ended().startswith("cancelled controls-silent")


def test_a_robot_that_was_killed_and_is_back_is_driven_no_further(site: LiveSite) -> None:
    site.begin()
    site.base.kill()
    note = site.told("note")
    assert note.startswith("broken off because"), note
    back_ns = time.time_ns()
    site.begin_base()
    site.ended()
    time.sleep(1.0)
    assert site.velocities(back_ns) == []
    site.fall_silent()


def test_two_hundred_samples_a_second_go_out_as_they_come(site: LiveSite) -> None:
    """Nothing waits for a tick: most are at the robot a moment after they were sent."""
    begun_ns, seconds = time.time_ns(), 3.0
    steps: list[int] = []

    def speed(_past_s: float) -> float:
        steps.append(time.time_ns())
        return 0.1 + 0.0001 * len(steps)  # each tells which it is

    site.begin(speed, hz=200.0)
    time.sleep(seconds)
    site.fall_silent()
    site.gateway.say("release")
    assert site.ended().startswith("done")
    taken: dict[int, int] = {}
    for velocity in site.velocities(begun_ns):
        taken.setdefault(round((velocity.m_s - 0.1) / 0.0001), velocity.taken_ns)
    late_ms = [(taken[n] - steps[n - 1]) / 1e6 for n in taken if 1 <= n <= len(steps)]
    share = len(taken) / len(steps)
    assert list(taken) == sorted(taken), "never an older one after a newer one"
    assert share > 0.5, f"{share:.1%} of {len(steps)} at the robot"
    assert median(late_ms) < 20 * patience(), "most wait for nothing"
