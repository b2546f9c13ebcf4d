"""Places of a size: people with keys and roles, half of them with a right of their own that ends.

Whole gateways over a record that was written before.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec

from rosic.app.gateway import Gateway, GatewayParts, GatewaySettings
from rosic.app.runtime import face_of
from rosic.config.units import compile_units
from rosic.core.identity import OPERATOR, Address, AuthorisationKey
from rosic.core.policy.roles import DEFAULT_ROLES, Grant, Role, RoleRules
from rosic.core.records import Enrolled, KeyIssued, Letter, PersonRecord
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from rosic.core.slot import BookedSlot
from rosic.core.time_units import HOUR_NS
from rosic.organiser.grants import fact_of
from rosic.robots.memory import MemoryRobot
from rosic.stores.stop_latch import MemoryLatch
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rosic.contracts.adapter import RobotFactory
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.store import StopLatch, Store
    from rosic.core.records import Record


# ---- parts ----

# What every gateway under measurement is made of, whatever is measured.

CLOCK = SystemClock()
ACTS_AT_MOST = 1_000_000
"""So many order numbers a robot remembers whose acts are counted: all of them."""


def parts_of(
    store: Store,
    *messengers: Messenger,
    robot: RobotFactory = MemoryRobot,
    latch: StopLatch | None = None,
) -> GatewayParts:
    """Return the parts of a gateway with real clocks, over a store.

    Args:
        store: Where it writes.
        messengers: Through which it is spoken to.
        robot: Makes each of its robots.
        latch: Where stops outlive a crash; None: in memory.
    """
    return GatewayParts(
        messengers=messengers,
        robot_factory=lambda _kind: robot,
        store=store,
        latch=MemoryLatch() if latch is None else latch,
        clock=CLOCK,
        entropy=SystemEntropy(),
        units=compile_units(),
        face=face_of(),
    )


# ---- sites ----

SHARED = 256  # records that are written together


class SiteSize(NamedTuple):
    """How much there is of everything."""

    people: int
    roles: int
    robots: int
    slots: int

    def __str__(self) -> str:
        return f"{self.people} people, {self.roles} roles, {self.robots} robots, {self.slots} slots"


SMALL = SiteSize(10, 5, 3, 0)
LARGE = SiteSize(10_000, 100, 50, 50_000)
# A role of a kind is the same in either place; what differs is how many others lie around it.
KINDS = (
    Role(scopes=("*:*",)),
    Role(scopes=("*:*",), limits=("speed <= 0.5 m/s",)),
    Role(scopes=("*:move", "*:read")),
    Role(scopes=("*:move",), includes=("viewer",)),
    Role(includes=("operator",), priority=5),
)
# Those who use skills of all names, within no limits.
FREE = (Role(scopes=("*:*",)), Role(includes=("operator",)))
SKILLS = {
    "move": Skill(
        id="move",
        parameters={
            "speed": Parameter(unit="m/s", min=0.0, max=1.0),
            "distance": Parameter(unit="m", min=0.01, max=5.0),
        },
    ),
    "wave": Skill(id="wave"),
}


def rulebook_of(roles: int, kinds: tuple[Role, ...] = KINDS) -> RoleRules:
    """Return so many roles of a place's own, of all kinds, beside the default ones."""
    own = {f"role{n}": kinds[n % len(kinds)] for n in range(roles)}
    return RoleRules(roles={**DEFAULT_ROLES, **own})


def records_of(size: SiteSize, now_ns: int) -> Iterator[Record]:
    """Yield everything that is on record in a place of a size."""
    for n in range(size.people):
        who = f"p{n}"
        record = PersonRecord(f"person {n}", (Address("bench", str(n)),))
        letter = Letter(who, msgspec.msgpack.encode(record))
        yield Enrolled(principal=who, roles=(f"role{n % size.roles}",), at_ns=now_ns, letter=letter)
        yield KeyIssued(
            key=AuthorisationKey(id=f"k{n}", principal=who, issuer=OPERATOR, issued_ns=now_ns)
        )
        if n % 2:
            robot = f"robot{n % size.robots}"
            ends_ns = now_ns + 24 * HOUR_NS + n
            yield fact_of(
                who, Grant(id=f"g{n}", role="operator", robots=(robot,), expires_ns=ends_ns)
            )
    yield from (slot.fact() for slot in slots_of(size, now_ns, "p{}".format))


def slots_of(
    size: SiteSize, now_ns: int, principal_of: Callable[[int], str]
) -> Iterator[BookedSlot]:
    """Yield slots of an hour, one after another on each robot, the first of them in an hour."""
    for n in range(size.slots):
        start_ns = now_ns + (1 + n // size.robots) * HOUR_NS
        yield BookedSlot(
            id=f"s{n}",
            principal=principal_of(n % size.people),
            robot=f"robot{n % size.robots}",
            start_ns=start_ns,
            end_ns=start_ns + HOUR_NS,
            made_ns=now_ns,
            by=OPERATOR,
        )


def gateway_over(size: SiteSize, store: Store) -> Gateway:
    """Return a gateway without messengers; nothing is opened."""
    settings = GatewaySettings(
        profiles=tuple(
            Profile(id=f"robot{n}", link=Link(kind="memory"), skills=SKILLS)
            for n in range(size.robots)
        ),
        rulebook=rulebook_of(size.roles),
    )
    return Gateway(settings, parts_of(store))


async def fill(store: Store, size: SiteSize) -> None:
    """Write the record of a place."""
    await store.open()
    waiting: list[Record] = []
    for record in records_of(size, CLOCK.wall_ns()):
        waiting.append(record)
        if len(waiting) == SHARED:
            await store.write(*waiting)
            waiting.clear()
    if waiting:
        await store.write(*waiting)
    await store.close()
