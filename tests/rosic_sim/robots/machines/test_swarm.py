from __future__ import annotations

import random
from collections import deque
from math import cos, dist, hypot, sin
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic_sim.robots.machines.activity import ActivityRefused, ActivityState
from rosic_sim.robots.machines.crazyflie import Crazyflie
from rosic_sim.robots.machines.swarm import (
    APART_M,
    KEEP_M,
    SeparationBound,
    Swarm,
    SwarmReport,
    keep_apart,
    slots,
)
from rosic_sim.robots.machines.world import SWARM_PLACES, build_world

if TYPE_CHECKING:
    from collections.abc import Sequence

TICK_S = 0.02
SHAPES = ("line", "triangle", "column")


def nearest_m(drones: Sequence[Crazyflie]) -> float:
    """The smallest horizontal distance of any two, flying or not."""
    return min(
        hypot(a.flight.x_m - b.flight.x_m, a.flight.y_m - b.flight.y_m)
        for i, a in enumerate(drones)
        for b in drones[:i]
    )


class Trio:
    """Three drones that share what they know at once, as in one process."""

    def __init__(self) -> None:
        self.world = build_world()
        self.drones = self.world.drones
        self.now_s = 0.0
        self.nearest_m = nearest_m(self.drones)
        self.world.step(0.0)

    def tick(self) -> None:
        self.now_s += TICK_S
        self.world.step(self.now_s)
        self.nearest_m = min(self.nearest_m, nearest_m(self.drones))

    def run(self, duration_s: float) -> None:
        end_s = self.now_s + duration_s
        while self.now_s < end_s:
            self.tick()

    def all(self, skill: str, **arguments: float | str) -> None:
        for drone in self.drones:
            drone.begin(skill, arguments, self.now_s, start_s=self.now_s + 0.1)
        self.to_ends()

    def to_ends(self, limit_s: float = 60.0) -> None:
        end_s = self.now_s + limit_s
        while any(d.activity is not None and d.activity.running for d in self.drones):
            assert self.now_s < end_s
            self.tick()


class DistantTrio(Trio):
    """Three drones, each with a knowledge of its own, fed late: as in three processes."""

    def __init__(self, delay_s: float) -> None:
        members = tuple(SWARM_PLACES)
        self.drones = tuple(
            Crazyflie(name, Swarm(members), place) for name, place in SWARM_PLACES.items()
        )
        self.now_s = 0.0
        self.delay_s = delay_s
        self.on_the_way: deque[tuple[float, SwarmReport]] = deque()
        self.cut_off: set[str] = set()
        self.nearest_m = nearest_m(self.drones)
        for drone in self.drones:
            drone.step(0.0)
            for other in self.drones:
                other.swarm.hear(drone.sighting(0.0))

    def tick(self) -> None:
        self.now_s += TICK_S
        for drone in self.drones:
            if drone.id not in self.cut_off:
                self.on_the_way.append((self.now_s + self.delay_s, drone.sighting(self.now_s)))
        while self.on_the_way and self.on_the_way[0][0] <= self.now_s:
            _, sighting = self.on_the_way.popleft()
            for drone in self.drones:
                if drone.id != sighting.robot:
                    drone.swarm.hear(self.dated(sighting))
        for drone in self.drones:
            drone.step(self.now_s)
        self.nearest_m = min(self.nearest_m, nearest_m(self.drones))

    def dated(self, sighting: SwarmReport) -> SwarmReport:
        """Without clocks that agree, what is heard counts as said just now."""
        return sighting._replace(time_s=self.now_s)


class DatedTrio(DistantTrio):
    """The same with clocks that agree, as over the topic: known is when something was said."""

    def dated(self, sighting: SwarmReport) -> SwarmReport:
        return sighting


def test_a_show_in_step_and_in_formation() -> None:
    trio = Trio()
    trio.all("takeoff", height_m=1.0)
    starts = {d.activity.facts["started_s"] for d in trio.drones if d.activity is not None}
    assert max(starts) - min(starts) < 1e-9, "start skew"
    for shape in SHAPES * 2:
        trio.all("formation", shape=shape, spacing_m=0.8)
        places = slots(shape, 0.8, 3, (0.0, 0.0))
        for drone, place in zip(trio.drones, places, strict=True):
            assert drone.activity is not None
            assert drone.activity.state is ActivityState.DONE
            assert dist((drone.flight.x_m, drone.flight.y_m), place) < 0.02
    trio.all("land")
    assert all(drone.at_rest() for drone in trio.drones)
    assert trio.nearest_m >= APART_M


@given(
    shape=st.sampled_from(SHAPES),
    spacing_m=st.floats(0.6, 2.0),
    x=st.floats(-1, 1),
    y=st.floats(-1, 1),
)
def test_slots_are_spaced_around_the_centre(
    shape: str, spacing_m: float, x: float, y: float
) -> None:
    places = slots(shape, spacing_m, 3, (x, y))
    gaps = [dist(a, b) for i, a in enumerate(places) for b in places[:i]]
    assert min(gaps) >= spacing_m - 1e-9
    assert sum(p[0] for p in places) / 3 == pytest.approx(x)
    assert sum(p[1] for p in places) / 3 == pytest.approx(y)


def test_a_crossing_is_passed_on_the_right() -> None:
    trio = Trio()
    trio.all("takeoff", height_m=1.0)
    first, _, third = trio.drones
    first.begin("goto", {"x_m": 2.0, "y_m": 0.0}, trio.now_s)
    third.begin("goto", {"x_m": -2.0, "y_m": 0.0}, trio.now_s)
    trio.to_ends()
    first.begin("goto", {"x_m": -1.2, "y_m": 0.0}, trio.now_s)
    third.begin("goto", {"x_m": 1.2, "y_m": 0.0}, trio.now_s)
    trio.to_ends()
    for drone in (first, third):
        assert drone.activity is not None
        assert drone.activity.state is ActivityState.DONE
    assert trio.nearest_m >= APART_M
    assert trio.nearest_m < KEEP_M + 0.2, "they never met: the test shows nothing"


def test_a_place_that_is_taken_is_declined() -> None:
    trio = Trio()
    trio.all("takeoff", height_m=1.0)
    first, second, _ = trio.drones
    with pytest.raises(ActivityRefused, match="cf1: cf2 is there or on its way there"):
        first.begin("goto", {"x_m": 0.1, "y_m": 0.1}, trio.now_s)
    second.begin("goto", {"x_m": 1.0, "y_m": 0.0}, trio.now_s)
    with pytest.raises(ActivityRefused, match="cf2 is there or on its way there"):
        first.begin("goto", {"x_m": 1.1, "y_m": 0.1}, trio.now_s)


# ------------------------------------------------------------------------------ many random flights


def order(drone: Crazyflie, chance: random.Random, now_s: float) -> bool:
    """Give one drone something at random; tell whether it took it."""
    kind = chance.random()
    try:
        if kind < 0.1:
            drone.halt(now_s)
        elif kind < 0.2:
            drone.set_position(chance.uniform(-1, 1), chance.uniform(-1, 1), 1.0, now_s)
        elif kind < 0.25:
            drone.begin("takeoff", {"height_m": chance.uniform(0.2, 2.0)}, now_s)
        elif kind < 0.4:
            shape = SHAPES[int(now_s) % 3]
            drone.begin("formation", {"shape": shape, "spacing_m": 0.6}, now_s)
        elif kind < 0.55:
            leader = chance.choice([name for name in SWARM_PLACES if name != drone.id])
            bearing_rad = chance.uniform(-1.5, 1.5)
            drone.begin("follow", {"leader": leader, "bearing_rad": bearing_rad}, now_s)
        else:
            place = {"x_m": chance.uniform(-1.2, 1.2), "y_m": chance.uniform(-1.2, 1.2)}
            drone.begin("goto", place, now_s, start_s=now_s + chance.choice((0.0, 0.3)))
    except ActivityRefused:
        return False
    return True


def wild_flight(trio: Trio, seed: int) -> int:
    """Fly with changes of mind at any moment; return how many orders were taken."""
    chance = random.Random(seed)  # noqa: S311  a repeatable flight, not a secret
    taken = 0
    trio.all("takeoff", height_m=0.6)
    end_s = trio.now_s + 6.0
    while trio.now_s < end_s:
        drone = chance.choice(trio.drones)
        taken += order(drone, chance, trio.now_s)
        trio.run(chance.uniform(0.02, 0.8))
    for drone in trio.drones:
        drone.halt(trio.now_s)
    trio.run(8.0)
    assert all(drone.at_rest() for drone in trio.drones)
    return taken


@pytest.mark.parametrize("block", range(6))
def test_separation_over_random_flights(block: int) -> None:
    taken = 0
    for seed in range(block * 25, block * 25 + 25):
        trio = Trio()
        taken += wild_flight(trio, seed)
        assert trio.nearest_m >= APART_M, f"seed {seed}: {trio.nearest_m:.3f} m"
    assert taken > 100


@pytest.mark.parametrize("block", range(6))
def test_separation_when_everybody_knows_late(block: int) -> None:
    taken = 0
    for seed in range(block * 25, block * 25 + 25):
        trio = DistantTrio(delay_s=0.02 * (seed % 6))
        taken += wild_flight(trio, seed)
        assert trio.nearest_m >= APART_M, f"seed {seed}: {trio.nearest_m:.3f} m"
    assert taken > 100


@pytest.mark.parametrize("block", range(4))
def test_flights_to_places_that_suit_all_arrive(block: int) -> None:
    for seed in range(block * 10, block * 10 + 10):
        chance = random.Random(seed)  # noqa: S311  a repeatable flight, not a secret
        trio = Trio()
        trio.all("takeoff", height_m=0.6)
        for leg in range(2):
            if chance.random() < 0.5:
                trio.all("formation", shape=SHAPES[(seed + leg) % 3], spacing_m=0.6)
            else:
                for drone in trio.drones:
                    place = {"x_m": chance.uniform(-1.5, 1.5), "y_m": chance.uniform(-1.5, 1.5)}
                    while not _free(trio, drone, place["x_m"], place["y_m"]):
                        place["x_m"] = chance.uniform(-1.5, 1.5)
                    drone.begin("goto", place, trio.now_s, start_s=trio.now_s + 0.2)
                trio.to_ends()
            for drone in trio.drones:
                assert drone.activity is not None
                assert drone.activity.state is ActivityState.DONE, f"seed {seed}: {drone.activity}"
        assert trio.nearest_m >= APART_M


def _free(trio: Trio, drone: Crazyflie, x_m: float, y_m: float) -> bool:
    others = (trio.world.swarm.last(d.id) for d in trio.drones if d is not drone)
    return all(o is None or dist((o.goal_x_m, o.goal_y_m), (x_m, y_m)) > 0.6 for o in others)


# ------------------------------------------------------------------------------- one lost, all land


@pytest.mark.parametrize("lost", ["cf1", "cf2", "cf3"])
def test_one_lost_all_land(lost: str) -> None:
    trio = Trio()
    trio.all("takeoff", height_m=1.0)
    for drone, y in zip(trio.drones, (1.0, 0.0, -1.0), strict=True):
        drone.begin("goto", {"x_m": 2.5, "y_m": y}, trio.now_s)
    trio.run(0.5)
    trio.world.lose(lost, trio.now_s)
    lost_s = trio.now_s
    others = [drone for drone in trio.drones if drone.id != lost]
    while all(drone.telemetry()["mode"] != "landing" for drone in others):
        trio.tick()
    assert trio.now_s - lost_s == pytest.approx(1.0, abs=0.1)
    for drone in others:
        assert drone.note == f"{lost} not heard for 1 s, landing"
        assert drone.activity is not None
        assert drone.activity.state is ActivityState.FAILED
    trio.run(4.0)
    assert all(drone.at_rest() for drone in trio.drones)
    assert trio.nearest_m >= APART_M
    with pytest.raises(ActivityRefused, match=f"{lost} flies and is not heard"):
        others[0].begin("takeoff", {}, trio.now_s)
    trio.world.find(lost, trio.now_s)
    assert others[0].begin("takeoff", {}, trio.now_s).running


def test_one_cut_off_from_the_others_lands_them_also_across_processes() -> None:
    trio = DistantTrio(delay_s=0.05)
    trio.all("takeoff", height_m=1.0)
    trio.run(3.0)
    assert all(drone.holding for drone in trio.drones)
    trio.cut_off.add("cf2")
    trio.run(5.0)
    assert [drone.at_rest() for drone in trio.drones] == [True, False, True]
    # cf2 still hears the others say that they have landed: it is alone, but not lost.
    assert trio.drones[1].holding


def test_a_peer_that_has_landed_is_not_lost() -> None:
    trio = Trio()
    trio.all("takeoff", height_m=0.5)
    trio.drones[0].begin("land", {}, trio.now_s)
    trio.run(6.0)
    assert trio.drones[0].at_rest()
    assert trio.drones[1].holding
    assert trio.drones[2].holding


def test_a_long_gap_between_steps_lands_nobody() -> None:
    trio = Trio()
    trio.all("takeoff", height_m=0.5)
    trio.now_s += 5.0
    trio.world.step(trio.now_s)
    assert all(drone.holding for drone in trio.drones)


def test_older_news_does_not_replace_newer() -> None:
    swarm = Swarm(("cf1", "cf2"))
    new = SwarmReport("cf1", 2.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, flying=True)
    swarm.hear(new)
    swarm.hear(new._replace(time_s=1.0, x_m=0.0))
    assert swarm.last("cf1") == new


@given(
    wanted=st.tuples(st.floats(-1, 1), st.floats(-1, 1)),
    peers=st.lists(st.tuples(st.floats(-3.2, 3.2), st.floats(-0.3, 1.0)), min_size=1, max_size=4),
)
def test_the_velocity_that_is_flown_is_allowed_or_a_retreat(
    wanted: tuple[float, float], peers: list[tuple[float, float]]
) -> None:
    bounds = [SeparationBound(cos(angle), sin(angle), most) for angle, most in peers]
    flown = keep_apart(wanted, bounds)
    allowed = all(limit.excess(flown) <= 1e-5 for limit in bounds)
    assert allowed or hypot(*flown) <= 0.3 + 1e-9
    assert hypot(*flown) <= max(hypot(*wanted), 0.3) * 2.0 + 1e-6
