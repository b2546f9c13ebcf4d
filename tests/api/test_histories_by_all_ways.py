"""I1-I5, I7-I9, I12-I14 and I6 on random histories in which all ways in are used at once."""

from __future__ import annotations

import asyncio
from random import Random
from typing import TYPE_CHECKING, TypeVar

import pytest
from hypothesis import HealthCheck, Phase, example, given, note, settings
from hypothesis import strategies as st

from tests.api.ways import OLD_KEY, WaysWorld, judge_live
from tests.gateway.judging import judge, nothing_is_left

if TYPE_CHECKING:
    from collections.abc import Sequence

T = TypeVar("T")

A_FEW, MANY = 2, 400
LONGEST = 40
FOCUSED = 0.7  # share
SPEAKERS = ("Ada", "Bo", "Hal", "Vi") + (OLD_KEY,) * 4
CHATTERS = ("Ada", "Bo", "Vi", "stranger")
DRIVERS = (("Bo", "/v1/events"), ("Ada", "/v1/events"), ("Hal", "/rosbridge"), ("Vi", "/v1/events"))
WORDS = ("omni move 1 m", "omni turn left 90 deg", "kuka1 wave", "omni move 1 m left", "kuka1 look")
RESUMES = ("resume", "resume omni", "resume kuka1", "resume omni kuka1")
STOPS = ("stop", "stop omni", "stop kuka1")
ORDERS: tuple[tuple[str, str, dict[str, object]], ...] = (
    ("omni", "move", {"distance": 1.0}),
    ("omni", "turn", {"angle": 90}),
    ("kuka1", "wave", {}),
)
TIMES_S = (0.01, 0.05, 0.1, 0.25, 0.4, 1.0, 1.0, 4.0, 6.0, 31.0)
PAUSES = (0, 1, 3, 10, 60, 200)
HELD = (0, 20, 60, 200)
KINDS = (
    ("order",) * 8
    + ("chat",) * 5
    + ("page",) * 4
    + ("hold",) * 12
    + ("stop",) * 3
    + ("resume",) * 5
    + ("again",) * 3
    + ("tap", "leave", "revoke", "rotate", "rotate", "crash", "restart", "disk", "lead")
    + ("time",) * 10
    + ("work",) * 2
)


class Player:
    """Plays the history of a seed in a world; a shorter one is its beginning."""

    def __init__(self, world: WaysWorld, seed: int) -> None:
        self._world = world
        self._random = Random(seed)  # noqa: S311 - the same history every time
        self._placed: list[tuple[str, str, dict[str, object], str]] = []
        # Who does most of it: otherwise somebody else has the robot nearly always.
        self._focus = self._one(("Ada", "Bo", "Hal"))

    def _one(self, things: Sequence[T]) -> T:
        return self._random.choice(things)

    def _who(self) -> str:
        return self._focus if self._random.random() < FOCUSED else self._one(SPEAKERS)

    async def step(self) -> None:
        """Do one thing, and let the event loop turn for a while."""
        kind = self._one(KINDS)
        note(kind)
        await getattr(self, f"_{kind}")()
        await self._world.turns(self._one(PAUSES))

    async def _order(self) -> None:
        robot, skill, arguments = self._one(ORDERS)
        key = f"k{len(self._placed)}"
        path = f"/v1/robots/{robot}/orders"
        body: dict[str, object] = {"skill": skill, "arguments": arguments}
        who = self._who()
        self._placed.append((who, path, body, key))
        self._world.ask(who, path, body, key)

    async def _again(self) -> None:
        if self._placed:
            self._world.ask(*self._one(self._placed))

    async def _chat(self) -> None:
        self._world.say(self._one(CHATTERS), self._one(WORDS), group=False)

    async def _page(self) -> None:
        self._world.ask(self._who(), "/v1/chat", {"text": self._one(WORDS), "wait_s": 0})

    async def _hold(self) -> None:
        own = [one for one in DRIVERS if one[0] == self._focus]
        who, path = self._one(own if self._random.random() < FOCUSED else DRIVERS)
        for _ in range(self._random.randrange(2, 10)):
            self._world.hold(who, path, "omni", self._one((0.2,) * 7 + (0.4, 0.0)))
            await self._world.turns(self._one(HELD))
            await self._world.clock.advance(self._one((0.02, 0.05, 0.1)))

    async def _stop(self) -> None:
        who, way = self._who(), self._random.randrange(3)
        robots = self._one(((), ("omni",), ("kuka1",)))
        if way == 0:
            self._world.say(self._one(("Ada", "Bo", "Vi")), self._one(STOPS), group=False)
        elif way == 1:
            self._world.stop(who, robots, by_socket=False)
        else:
            self._world.stop(self._one(("Ada", "Bo", "Hal")), robots, by_socket=True)

    async def _resume(self) -> None:
        text = self._one(RESUMES)
        if self._random.random() < 0.5:
            self._world.say(self._one(CHATTERS), text, group=False)
        else:
            self._world.ask(self._who(), "/v1/chat", {"text": text, "wait_s": 0})

    async def _tap(self) -> None:
        self._world.tap(self._one(CHATTERS), self._random.randrange(4))

    async def _leave(self) -> None:
        self._world.leave(*self._one(DRIVERS))

    async def _revoke(self) -> None:
        await self._world.revoke(self._one(("Bo", "Hal", "Vi")))

    async def _lead(self) -> None:
        """Somebody else does most of it from now on."""
        self._focus = self._one(("Ada", "Bo", "Hal"))

    async def _rotate(self) -> None:
        await self._world.rotate()

    async def _crash(self) -> None:
        await self._world.crash(written=self._random.random() < 0.5)
        await self._world.start()

    async def _restart(self) -> None:
        await self._world.close()
        await self._world.start()

    async def _disk(self) -> None:
        disk = self._world.disk
        what = self._one(("break", "slow", "mend", "mend"))
        disk.broken = what == "break"
        if what == "slow":
            disk.ready.clear()
        else:
            disk.ready.set()

    async def _time(self) -> None:
        await self._world.clock.advance(self._one(TIMES_S))
        self._world.disk.flush()

    async def _work(self) -> None:
        self._world.robot(self._one(("omni", "kuka1"))).work_s = self._one((0.0, 0.2, 2.0))


async def play(seed: int, length: int) -> WaysWorld:
    """Play a history, let everything end, and look at all of it."""
    world = WaysWorld()
    await world.start()
    player = Player(world, seed)
    for _ in range(length):
        await player.step()
    await world.heal()
    judge(world)
    judge_live(world.log)
    assert 500 not in world.answers
    await world.close()
    await world.start()
    await world.heal()
    judge(world)
    judge_live(world.log)
    nothing_is_left(world)
    await world.close()
    return world


few = settings(
    max_examples=A_FEW,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    phases=[phase for phase in settings().phases if phase is not Phase.explain],
)
many = settings(few, max_examples=MANY)
seeds, lengths = st.integers(0, 2**32), st.integers(10, LONGEST)


@pytest.mark.limit(300)  # a failing history is made shorter first, which takes its time
@few
# In each of these a guard is needed: an old key, a stop over the page's connection, a silent hand.
@example(15, 40)
@example(12, 40)
@example(5, 40)
@given(seeds, lengths)
def test_whatever_comes_by_whichever_way_no_promise_is_broken(seed: int, length: int) -> None:
    asyncio.run(play(seed, length))


@pytest.mark.campaign
@pytest.mark.limit(7_200)
@many
@given(seeds, lengths)
def test_many_histories_by_all_ways(seed: int, length: int) -> None:
    asyncio.run(play(seed, length))
