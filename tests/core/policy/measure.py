"""What looking a right up costs in a small place and in a large one, and what a person weighs.

Deciding with everything looked up is measured by ``rosic bench pipeline``.

    python -m tests.core.policy.measure

Each figure is the median of five runs; a run's p50 is over single calls, the cost of reading the
clock taken off. The two places take turns, so that a busy machine slows both.
"""

from __future__ import annotations

import random
import sys
import tracemalloc
from statistics import median
from time import perf_counter_ns
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from rosic.core.policy.permissions import Permissions
from rosic.core.policy.roles import DEFAULT_ROLES, Grant, Role, RoleRules
from rosic.core.policy.scope import Fleet
from rosic.core.slot import BookedSlot
from tests.core.policy.product import CONVERT, a_skill
from tests.core.policy.worlds import NOW, SKILLS

if TYPE_CHECKING:
    from collections.abc import Callable

CALLS = 20_000
RUNS = 5
HOUR_NS = 3_600_000_000_000


class Size(NamedTuple):
    people: int
    roles: int
    robots: int
    slots: int


SMALL = Size(10, 5, 3, 0)
LARGE = Size(10_000, 100, 50, 50_000)


class Place(NamedTuple):
    """A place of a size, and who is asked about in it."""

    rights: Permissions
    asked: list[tuple[str, str]]
    slots: dict[str, list[BookedSlot]]


Asking: TypeAlias = "Callable[[Place], Callable[[str, str], object]]"


def fleet_of(size: Size) -> Fleet:
    skills = {name: a_skill(name, said) for name, said in SKILLS.items()}
    return Fleet({f"robot{n}": skills for n in range(size.robots)}, {"half": ("robot0", "robot1")})


def rulebook_of(size: Size) -> RoleRules:
    own = {
        f"role{n}": Role(
            scopes=("*:*",) if n % 2 else ("half:move", "*:read"),
            limits=("speed <= 0.5 m/s",) if n % 4 == 0 else (),
            includes=("viewer",),
        )
        for n in range(size.roles - len(DEFAULT_ROLES))
    }
    return RoleRules(roles={**DEFAULT_ROLES, **own})


def people_of(size: Size) -> dict[str, tuple[Grant, ...]]:
    """A role each, half of them with an end of their own, a third on two robots only."""
    lot = random.Random(7)  # noqa: S311
    roles = list(rulebook_of(size).roles)
    people: dict[str, tuple[Grant, ...]] = {}
    for n in range(size.people):
        where = tuple(f"robot{lot.randrange(size.robots)}" for _ in range(2)) if n % 3 == 0 else ()
        ends = NOW + HOUR_NS + n if n % 2 else None
        people[f"p{n}"] = (
            Grant(id=f"g{n}", role=lot.choice(roles), robots=where, expires_ns=ends),
            Grant(role="operator"),
        )
    return people


def a_place(size: Size) -> Place:
    lot = random.Random(11)  # noqa: S311
    rights = Permissions.draw_up(1, rulebook_of(size), fleet_of(size), people_of(size), CONVERT)
    slots: dict[str, list[BookedSlot]] = {f"robot{n}": [] for n in range(size.robots)}
    for n in range(size.slots):
        robot, place = f"robot{n % size.robots}", n // size.robots
        start = NOW + (1 + place) * HOUR_NS
        slots[robot].append(
            BookedSlot(
                id=f"s{n}",
                principal=f"p{n % size.people}",
                robot=robot,
                start_ns=start,
                end_ns=start + HOUR_NS,
                made_ns=0,
                by="p0",
            )
        )
    # As many are asked about in either place: what differs is what lies around them.
    some = [
        (f"p{lot.randrange(size.people)}", f"robot{lot.randrange(size.robots)}") for _ in "x" * 64
    ]
    return Place(rights, some, slots)


def p50_ns(call: Callable[[str, str], object], asked: list[tuple[str, str]]) -> float:
    taken = []
    for n in range(CALLS):
        who, robot = asked[n % len(asked)]
        begun = perf_counter_ns()
        call(who, robot)
        taken.append(perf_counter_ns() - begun)
    return median(taken)


def may(place: Place) -> Callable[[str, str], object]:
    rights = place.rights
    return lambda who, robot: rights.may(who, robot, "home")


def nothing(_place: Place) -> Callable[[str, str], object]:
    return lambda who, _robot: who


def bytes_a_person() -> float:
    """Weigh the rights of the large place: roles, tables and people, shared by its people."""
    rulebook, fleet = rulebook_of(LARGE), fleet_of(LARGE)
    tracemalloc.start()
    people = people_of(LARGE)  # their grants, with ids and ends of their own, weigh as well
    rights = Permissions.draw_up(1, rulebook, fleet, people, CONVERT)
    del people
    weight, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert rights.epoch == 1
    return weight / LARGE.people


def compare(make: Asking) -> tuple[float, float]:
    small, large = a_place(SMALL), a_place(LARGE)
    runs = [
        (p50_ns(make(small), small.asked), p50_ns(make(large), large.asked)) for _ in range(RUNS)
    ]
    return median(a for a, _ in runs), median(b for _, b in runs)


def change_us() -> float:
    """Measure a change of one person's grants in the large place, whole and live."""
    rights = a_place(LARGE).rights
    taken = []
    for n in range(200):
        begun = perf_counter_ns()
        rights = rights.with_grants(2 + n, f"p{n}", (Grant(role="viewer", expires_ns=NOW + n),))
        taken.append(perf_counter_ns() - begun)
    return median(taken) / 1e3


def main() -> None:
    say = sys.stdout.write
    clock, _ = compare(nothing)
    small, large = compare(may)
    small, large = small - clock, large - clock
    say(f"may: p50 {small:.0f} ns small, {large:.0f} ns large, {large / small:.2f} times\n")
    begun = perf_counter_ns()
    Permissions.draw_up(1, rulebook_of(LARGE), fleet_of(LARGE), people_of(LARGE), CONVERT)
    say(f"drawn up anew: {(perf_counter_ns() - begun) / 1e6:.0f} ms\n")
    say(f"one person's grants changed: {change_us():.0f} us\n")
    say(f"a person weighs {bytes_a_person():.0f} bytes, roles and robots shared out\n")


if __name__ == "__main__":
    main()
