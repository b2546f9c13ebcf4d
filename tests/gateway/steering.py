"""A place whose omni is driven live, and a hand at its controls."""

from __future__ import annotations

from contextlib import asynccontextmanager
from itertools import count
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.identity import Address
from rosic.core.message import Chat, Inbound
from rosic.gateway.requests import line_id
from tests.gateway.place import ADA, Place

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping

    from rosic.contracts.store import Store
    from rosic.core.message import Button
    from rosic.core.policy.roles import RoleRules
    from rosic.core.robot.profile import Profile
    from rosic.core.sample_gate import SampleResult
    from rosic.gateway.live_control import LiveControl, LiveInput

# Whoever steers has a clock of their own.
APART_NS = 7_000_000_123_456
OMNI = load_profile(shipped_profiles()["omni"])


def live(place: Place) -> LiveControl:
    """Return who has live orders steered there."""
    return place.gateway.pipeline.live


def person(place: Place, account: str = ADA) -> str:
    """Return who somebody is."""
    known = place.gateway.rooms.authoriser.directory.at(Address("memory", account))
    assert known is not None
    return known[0].id


@asynccontextmanager
async def steered(
    rulebook: RoleRules | None = None,
    roles: Mapping[str, str] | None = None,
    fleet: tuple[Profile, ...] = (OMNI,),
    store: Store | None = None,
) -> AsyncIterator[Place]:
    """Run a place with omni, and with rules of its own."""
    place = Place(store, fleet=fleet)
    settings = place.gateway._settings
    people = tuple(
        replace(seed, roles=(roles[seed.name],)) if roles and seed.name in roles else seed
        for seed in settings.people
    )
    place.gateway._settings = replace(
        settings, rulebook=rulebook or settings.rulebook, people=people
    )
    async with place.open():
        yield place


async def ordered(place: Place, *, account: str = ADA, **how: Any) -> Inbound:  # noqa: ANN401
    """Have a line carried out as a live order; return its message."""
    await place.clock.advance(0.001)
    now_ns = place.clock.wall_ns()
    inbound = Inbound(
        sender=Address("memory", account),
        chat=Chat("memory", account),
        message=f"live-{now_ns}",
        text=live(place).line("omni", "drive"),
        sent_ns=now_ns,
        received_ns=now_ns,
        live=True,
    )
    inbound = place.chat.deliver(replace(inbound, **how))
    await place.quiet()
    return inbound


async def tapped_live(place: Place, button: Button, under: str, account: str = ADA) -> Inbound:
    """Tap a button where people steer."""
    how = {"text": "", "nonce": button.nonce, "tap": "t", "under": under}
    return await ordered(place, account=account, **how)


class Hand:
    """Steers one live order, as somebody with a clock of their own.

    Attributes:
        input: The controls.
        ahead_s: So much their clock was set forward.
    """

    def __init__(self, place: Place, controls: LiveInput) -> None:
        self.place = place
        self.input = controls
        self.ahead_s = 0.0
        self.sequence = count(1)

    def now_ns(self, late_s: float = 0.0) -> int:
        """Return what their clock shows, or showed."""
        ours_ns = self.place.clock.monotonic_ns()
        return ours_ns + APART_NS + int((self.ahead_s - late_s) * 1e9)

    def put(self, late_s: float = 0.0, /, **values: float) -> SampleResult:
        """Send a sample that took its time."""
        return self.input.put(values, self.now_ns(late_s), next(self.sequence))

    async def hold(self, seconds: float, **values: float) -> list[SampleResult]:
        """Hold a stick for a while, at 20 Hz."""
        results = []
        for _ in range(round(seconds * 20)):
            results.append(self.put(**values))
            await self.place.clock.advance(0.05)
        return results


async def hand(place: Place, account: str = ADA) -> Hand:
    """Begin a live order of omni, and take its controls."""
    inbound = await ordered(place, account=account)
    return Hand(place, live(place).open(line_id(inbound, 0), person(place, account)))


def said(place: Place) -> str:
    """Return everything that was told there."""
    return "\n".join(told.outbound.text for told in place.chat.told)


def driven(place: Place, name: str = "linear") -> list[float]:
    """Return what omni was driven with; it is sent zero at the end."""
    return [float(values.get(name, 0.0)) for values in place.robot("omni").steered]
