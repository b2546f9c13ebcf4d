"""The gateway is killed while ROS 2 robots move: they come to rest by themselves."""

from __future__ import annotations

import asyncio
import os
import time
from collections import defaultdict
from random import Random
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.interfaces.cache import ensure_built, make_importable
from rosic.testing.ros2.graph import why_missing
from tests.journeys.counter import Counted
from tests.journeys.counting import Event
from tests.journeys.lab import Lab, lab
from tests.journeys.reading import Reply, read_reply
from tests.journeys.report import percentile
from tests.journeys.ros import Onlooker, onlooker
from tests.journeys.verdict import Said, judge
from tests.pace import patience

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

SEED = int(os.environ.get("ROSIC_SEED", "20261121"))
OMNI = ['[[robot]]\nprofile = "omni"']
# The robots' own patience with a silent gateway, and braking from half a metre a second.
REST_WITHIN_S = 2.5

pytestmark = pytest.mark.skipif(why_missing() is not None, reason=why_missing() or "")


@pytest.mark.limit(480)
async def test_robots_come_to_rest_by_themselves_over_3_kills(
    tmp_path: Path, launcher: Launcher, capfd: pytest.CaptureFixture[str]
) -> None:
    await kill_in_motion(3, tmp_path, launcher, capfd)


@pytest.mark.campaign
@pytest.mark.limit(1800)
async def test_robots_come_to_rest_by_themselves_over_20_kills(
    tmp_path: Path, launcher: Launcher, capfd: pytest.CaptureFixture[str]
) -> None:
    await kill_in_motion(20, tmp_path, launcher, capfd)


async def kill_in_motion(
    kills: int, folder: Path, launcher: Launcher, capfd: pytest.CaptureFixture[str]
) -> None:
    make_importable()
    ensure_built()
    chance = Random(SEED)  # noqa: S311 - a seed makes it repeatable
    commands: list[Said] = []
    rests_s: list[float] = []
    async with (
        onlooker(folder, "omni") as (looking, variables),
        lab(folder, launcher, robots=OMNI) as place,
    ):
        place.environment = variables
        for number in range(kills):
            way = "forward" if number % 2 == 0 else "back"
            gateway = await place.start()
            commands.append(await set_moving(place, looking, way))
            before = len(looking.robots.actuations("omni"))
            await asyncio.sleep(chance.uniform(0, 1.0))
            assert looking.moves, "it was to be killed in motion"
            gateway.kill()
            rests_s.append(await seconds_to_rest(place, looking))
            assert len(looking.robots.actuations("omni")) == before
        await place.start()
        await place.ask(place.ada, "status", "stopped")
        await place.until(lambda: all_told(place, commands))

        verdict = judge(commands, await replies(place), events(looking))
        with capfd.disabled():
            endings = {end.value: count for end, count in verdict.endings.items()}
            shown = [f"p{share} {percentile(rests_s, share):.2f} s" for share in (50, 99)]
            print(f"\n{kills} kills in motion, seed {SEED}: {endings}")  # noqa: T201
            print(f"  at rest by itself after {', '.join(shown)}")  # noqa: T201
        assert verdict.wrong == []
        assert len(looking.robots.actuations("omni")) == kills
        assert max(rests_s) < REST_WITHIN_S * patience()


async def set_moving(place: Lab, looking: Onlooker, way: str) -> Said:
    """Have the robot resumed, if it is held, and move; return the command."""

    async def heard() -> bool:
        told = await place.ask(place.ada, "status omni", "omni: ")
        return "not there" not in told["text"] and "link not known" not in told["text"]

    assert await place.until(heard)
    await place.say(place.ada, "resume omni")
    await place.drained()
    text = f"omni move {way} 4 m speed 0.5 m/s"
    message = await place.say(place.bo, text)
    assert await place.until(lambda: looking.moves), "it does not move"
    return Said(place.bo, place.bo, message, text, ("omni",))


async def seconds_to_rest(place: Lab, looking: Onlooker) -> float:
    killed_s = time.monotonic()
    assert await place.until(lambda: not looking.moves), "it moves on without a gateway"
    return time.monotonic() - killed_s


async def all_told(place: Lab, commands: list[Said]) -> bool:
    return not judge(commands, await replies(place), []).untold


async def replies(place: Lab) -> dict[tuple[int, int], list[Reply]]:
    found: dict[tuple[int, int], list[Reply]] = defaultdict(list)
    for message in await place.control.messages(place.bo, by_bot=True):
        found[place.bo, message["reply_to"]].append(read_reply(message))
    return found


def events(looking: Onlooker) -> list[Counted]:
    """Return what the robot's side wrote down: the id of a goal is that of its command."""
    found = []
    for line in looking.robots.actuations("omni"):
        skill, cid, number = line.split()
        event = Event(robot="omni", generation=0, process=0, cid=cid, n=int(number), skill=skill)
        found.append(Counted(event, 0.0))
    return found
