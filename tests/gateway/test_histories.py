"""I1-I5, I7-I9, I12-I14, I17 and L1 on random histories of whole gateways over one disk."""

from __future__ import annotations

import asyncio
from random import Random
from typing import TYPE_CHECKING, TypeVar

import pytest
from hypothesis import HealthCheck, Phase, given, note, settings
from hypothesis import strategies as st

from rosic.core.message import MessageValidity
from tests.gateway.events import Mode
from tests.gateway.histories import World
from tests.gateway.judging import everybody_is_answered_once, judge, nothing_is_left

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

A_FEW = 150
MANY = 20_000

# What a history is about. Few robots and few words make it likely that things meet.
THEMES = (
    ("omni wave", "omni move 1 m", "omni look", "omni wave\nomni move 1 m", "omni move 99 m"),
    ("kuka1 wave", "kuka1 move 1 m", "kuka1 look", "kuka1 wave\nkuka1 move 1 m"),
    ("arm wave", "arm move 1 m", "arm wave\narm wave"),
    ("wave", "wave", "move 1 m", "use omni", "use swarm", "use cf1", "omni wave"),
    ("swarm wave", "swarm move 1 m", "cf1 wave", "swarm wave\nswarm wave"),
    ("omni wave", "kuka1 wave", "omni wave\nkuka1 wave", "arm wave", "status"),
)
RESUMES = (
    ("resume", "resume omni"),
    ("resume kuka1",),
    ("resume arm",),
    ("resume", "resume omni swarm"),
    ("resume swarm", "resume cf1", "resume cf2"),
    ("resume omni kuka1 arm", "resume omni kuka1"),
)
STOPS = (
    ("stop omni",),
    ("stop kuka1",),
    ("stop arm",),
    ("stop omni", "stop swarm"),
    ("stop swarm", "stop cf2", "stop"),
    ("stop omni", "stop kuka1", "stop kuka1"),
)
FOCUS = (("omni",), ("kuka1",), ("arm",), ("omni", "cf1"), ("cf1", "cf2"), ("omni", "kuka1"))
SPEAKERS = ("Ada",) * 8 + ("Bo",) * 3 + ("Vi", "stranger")

Step = tuple[str, tuple[object, ...]]
History = list[tuple[Step, int]]
T = TypeVar("T")

STANDINGS = tuple(standing for standing in MessageValidity if standing is not MessageValidity.FRESH)
AGES_S = (0,) * 20 + (3, 4.9, 40)
TIMES_S = (0.001, 0.01, 0.3, 0.6, 1.0, 1.0, 1.0, 1.0, 4.0, 6.0, 31.0)
# After each step the event loop turns this often; the rest of it waits for the next step.
PAUSES = (0, 1, 2, 3, 5, 40, 40, 40, 40)
USUAL = (
    ("command",) * 14
    + ("resume",) * 6
    + ("stop",) * 2
    + ("again",) * 4
    + ("tap",) * 2
    + ("time",) * 9
    + ("work",) * 3
    + ("rest", "inert")
)
FAULTS = ("disk",) * 5 + ("mode",) * 2 + ("restart", "crash")
DISKS = ("break", "mend", "mend", "slow", "slow", "ready", "ready", "ready")
MODES = (Mode.WELL,) * 4 + tuple(Mode)
SHORTEST, LONGEST = 10, 45
SOMEBODY_ENDS, IN_A_GROUP, WRITTEN = 0.5, 0.3, 0.5  # shares


class Author:
    """Writes histories. The same seed gives the same one; a shorter one is its beginning."""

    def __init__(self, seed: int, *, faults: bool) -> None:
        self._random = Random(seed)  # noqa: S311 - the same history every time
        self._theme = self._random.randrange(len(THEMES))
        self._kinds = USUAL + FAULTS if faults else USUAL
        ends = self._random.random() < SOMEBODY_ENDS
        self._revoked_at = self._random.randrange(LONGEST) if ends else -1

    def write(self, length: int) -> History:
        """Return a history of so many steps."""
        return [(self._step(at), self._one(PAUSES)) for at in range(length)]

    def _one(self, things: Sequence[T]) -> T:
        return self._random.choice(things)

    def _step(self, at: int) -> Step:  # noqa: C901, PLR0911 - one case each
        if at == self._revoked_at:
            return ("revoke", (self._one(("Ada", "Bo", "Vi")),))
        kind = self._one(self._kinds)
        if kind in {"command", "resume", "stop"}:
            return ("say", self._words(kind))
        robot = self._one(FOCUS[self._theme])
        match kind:
            case "inert":
                return (kind, (*self._words("command")[:2], self._one(STANDINGS)))
            case "again":
                return (kind, (self._random.randrange(5),))
            case "tap":
                return (kind, (self._one(SPEAKERS), self._random.randrange(4)))
            case "time":
                return (kind, (self._one(TIMES_S),))
            case "work":
                return (kind, (robot, self._one((0.0, 0.2, 2.0, 20.0))))
            case "rest":
                return (kind, (robot, self._one((0.0, 0.5, 2.0))))
        return self._fault(kind, robot)

    def _words(self, kind: str) -> tuple[object, ...]:
        texts = {"command": THEMES, "resume": RESUMES, "stop": STOPS}[kind][self._theme]
        group = self._random.random() < IN_A_GROUP
        return (self._one(SPEAKERS), self._one(texts), group, self._one(AGES_S))

    def _fault(self, kind: str, robot: str) -> Step:
        match kind:
            case "disk":
                return (kind, (self._one(DISKS),))
            case "mode":
                return (kind, (robot, self._one(MODES)))
            case "crash":
                return (kind, (self._random.random() < WRITTEN,))
        return (kind, ())


async def play(history: History, *, edits: bool, faultless: bool) -> None:
    """Play a history, let everything end, and look at all of it."""
    world = World(edits=edits)
    await world.start()
    for (kind, arguments), pause in history:
        await STEPS[kind](world, *arguments)
        await world.turns(pause)
    await world.heal()
    judge(world)
    if faultless:
        nothing_is_left(world)
        if edits:
            everybody_is_answered_once(world)
    await world.close()
    await world.start()
    await world.heal()
    judge(world)
    nothing_is_left(world)
    await world.close()


async def say(world: World, who: str, text: str, group: bool, age_s: float) -> None:
    world.say(who, text, group=group, age_s=age_s)


async def inert_say(world: World, who: str, text: str, standing: MessageValidity) -> None:
    world.say(who, text, group=True, standing=standing)


async def say_again(world: World, which: int) -> None:
    world.say_again(which)


async def tap(world: World, who: str, which: int) -> None:
    world.tap(who, which)


async def time_goes(world: World, seconds: float) -> None:
    await world.clock.advance(seconds)
    world.disk.flush()


async def works(world: World, robot: str, work_s: float) -> None:
    world.robot(robot).work_s = work_s


async def rests(world: World, robot: str, rest_s: float) -> None:
    world.robot(robot).rest_s = rest_s


async def revoke(world: World, who: str) -> None:
    await world.revoke(who)


async def disk(world: World, what: str) -> None:
    if what in {"break", "mend"}:
        world.disk.broken = what == "break"
    elif what == "slow":
        world.disk.ready.clear()
    else:
        world.disk.ready.set()


async def mode(world: World, robot: str, how: Mode) -> None:
    world.robot(robot).mode = how


async def restart(world: World) -> None:
    await world.close()
    await world.start()


async def crash(world: World, written: bool) -> None:
    await world.crash(written=written)
    await world.start()


STEPS: dict[str, Callable[..., Awaitable[None]]] = {
    "say": say,
    "inert": inert_say,
    "again": say_again,
    "tap": tap,
    "time": time_goes,
    "work": works,
    "rest": rests,
    "revoke": revoke,
    "disk": disk,
    "mode": mode,
    "restart": restart,
    "crash": crash,
}

quiet = [HealthCheck.too_slow]
without_explaining = [phase for phase in settings().phases if phase is not Phase.explain]
a_few = settings(
    max_examples=A_FEW, deadline=None, suppress_health_check=quiet, phases=without_explaining
)
many = settings(a_few, max_examples=MANY)
seeds, lengths = st.integers(0, 2**32), st.integers(SHORTEST, LONGEST)


def tell(seed: int, length: int, *, edits: bool, faults: bool) -> None:
    """Play the history of a seed; should it fail, the report shows its steps."""
    history = Author(seed, faults=faults).write(length)
    for step, pause in history:
        note(f"{step}, then {pause} turns")
    asyncio.run(play(history, edits=edits, faultless=not faults))


@pytest.mark.limit(300)  # a failing history is made shorter first, which takes its time
@a_few
@given(seeds, lengths, st.booleans())
def test_without_faults_everything_is_done_once_and_told_once(
    seed: int, length: int, edits: bool
) -> None:
    tell(seed, length, edits=edits, faults=False)


@pytest.mark.limit(300)  # a failing history is made shorter first, which takes its time
@a_few
@given(seeds, lengths, st.booleans())
def test_whatever_fails_no_promise_is_broken(seed: int, length: int, edits: bool) -> None:
    tell(seed, length, edits=edits, faults=True)


@pytest.mark.campaign
@pytest.mark.limit(3_600)
@many
@given(seeds, lengths, st.booleans(), st.booleans())
def test_many_histories(seed: int, length: int, edits: bool, faults: bool) -> None:
    tell(seed, length, edits=edits, faults=faults)
