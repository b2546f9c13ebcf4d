"""Three drones that change their minds at any moment, and one that is lost: all land.

Some flights in every run; ``-m campaign`` flies a thousand.
"""

from __future__ import annotations

import random

import pytest

from rosic_sim.robots.machines.swarm import APART_M
from tests.rosic_sim.robots.machines.test_swarm import DistantTrio, Trio, order

A_FEW, MANY = 20, 1000
LANDED_WITHIN_S = 12.0


def flight(seed: int) -> tuple[float, bool]:
    """Fly until one is lost; return the nearest that any two came, and whether all have landed."""
    chance = random.Random(seed)  # noqa: S311 - a repeatable flight, not a secret
    trio = Trio() if seed % 2 else DistantTrio(delay_s=0.02 * (seed % 6))
    trio.all("takeoff", height_m=chance.uniform(0.4, 1.5))
    end_s = trio.now_s + chance.uniform(0.5, 6.0)
    while trio.now_s < end_s:
        order(chance.choice(trio.drones), chance, trio.now_s)
        trio.run(chance.uniform(0.02, 0.8))
    while not (flying := [drone.id for drone in trio.drones if drone.airborne]):
        trio.drones[0].begin("takeoff", {"height_m": 0.5}, trio.now_s)
        trio.run(2.0)
    # One that stands on the ground is missed by nobody: whoever is lost was flying.
    lose(trio, chance.choice(flying))
    trio.run(LANDED_WITHIN_S)
    return trio.nearest_m, all(drone.at_rest() for drone in trio.drones)


def lose(trio: Trio, name: str) -> None:
    """Cut one's radio: it hears nobody, nobody hears it, and it notices by itself."""
    if not isinstance(trio, DistantTrio):
        trio.world.lose(name, trio.now_s)
        return
    trio.cut_off.add(name)
    [drone] = [drone for drone in trio.drones if drone.id == name]
    drone.link_lost(trio.now_s)


def check(seeds: range) -> None:
    for seed in seeds:
        nearest_m, landed = flight(seed)
        assert nearest_m >= APART_M, f"seed {seed}: {nearest_m:.3f} m"
        assert landed, f"seed {seed}: not all have landed"


@pytest.mark.parametrize("block", range(2))
def test_they_keep_apart_and_all_land_when_one_is_lost(block: int) -> None:
    each = A_FEW // 2
    check(range(block * each, block * each + each))


@pytest.mark.campaign
@pytest.mark.limit(3600)
def test_they_keep_apart_in_every_one_of_a_thousand_flights() -> None:
    check(range(MANY))
