"""How long the steps of the event loop are while something is received (I15)."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

from rosic.bench.recorder import pace_of_machine
from rosic.bench.strangers import LoopStep, MeteredLoop, undisturbed
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from tests.gateway.place import FLEET
from tests.gateway.received import ADA, Receiving, receiving

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterable

    from rosic.core.fleet.mission import Mission

LONGEST_STEP_S = 0.020
TRIES = 20
"""What is too long is so every time; a neighbour that takes the processor's time goes."""


def run(
    act: Callable[[Receiving], Awaitable[None]],
    fleet: tuple[Profile, ...] = FLEET,
    missions: tuple[Mission, ...] = (),
) -> None:
    """Receive on a loop of its own, which meters its steps."""

    async def main() -> None:
        async with receiving(fleet=fleet, missions=missions) as place:
            await place.longest(place.message(ADA, "status"))  # what is made once is made
            await act(place)

    with undisturbed(), asyncio.Runner(loop_factory=MeteredLoop) as runner:
        runner.run(main())


async def too_long(
    place: Receiving, updates: Callable[[], list[dict[str, Any]]]
) -> LoopStep | None:
    """Return the longest step of receiving something, if that is too long however often tried.

    A step that looks for garbage, or loads what is used for the first time, is not what was sent.
    Each is held against the pace beside it, before and after: whoever shares the processor's caches
    comes and goes.
    """
    steps: list[LoopStep] = []
    pace = 1.0
    for _ in range(TRIES):
        step = await place.longest(*updates())
        if step.cpu_ns <= LONGEST_STEP_S * 1e9:
            return None
        before, pace = pace, pace_of_machine()
        if step.cpu_ns <= LONGEST_STEP_S * 1e9 * max(before, pace):
            return None
        steps.append(step)
    return min(steps)


async def none_is_long(place: Receiving, who: int, said: Iterable[str]) -> None:
    """See that no text of somebody makes a step too long."""
    slow = []
    for text in said:
        step = await too_long(place, lambda text=text: [place.message(who, text)])  # type: ignore[misc]
        if step is not None:
            slow.append((round(step.cpu_ns / 1e6, 1), text[:60], step.what))
    assert not slow, sorted(slow, reverse=True)[:20]


def herd(count: int) -> tuple[Profile, ...]:
    """Return robots of one group, each with ten skills that no other has, named much alike."""
    bounds = Parameter(unit="m", min=0.01, max=5.0)
    return tuple(
        Profile(
            id=f"rob{n}",
            link=Link(kind="memory"),
            groups=("herd",),
            skills={
                name: Skill(id=name, title=name, parameters={"distance": bounds})
                for name in ("move", *(f"skill{n}x{k}" for k in range(10)))
            },
        )
        for n in range(count)
    )
