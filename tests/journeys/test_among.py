"""Robots among themselves, as people meet them: what they read, how they help, and interrupt.

Two rovers as ROS 2 nodes, and what their own nodes say; the verbs are typed and tapped at the fake
Bot API server.
"""

from __future__ import annotations

import asyncio
import re
import time
from collections import Counter
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import msgspec
import pytest
import pytest_asyncio

from rosic.features.robot_to_robot.digest import EVERY_S
from rosic.robots.ros2.interfaces.cache import ensure_built, make_importable
from rosic.testing.ros2.graph import RosGraph, why_missing
from tests.journeys.acts import side_by_side
from tests.journeys.lab import Lab, lab
from tests.journeys.ros import VARIABLES
from tests.journeys.scenes import BRAINS, PROGRAM, ROVERS, profile
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from rosic.testing.ros2.graph import RosProcess
    from tests.journeys.running import Launcher

pytestmark = [
    pytest.mark.limit(300),
    pytest.mark.asyncio(loop_scope="module"),
    pytest.mark.skipif(why_missing() is not None, reason=why_missing() or ""),
]
ROLES = """
[role.reader]
scopes = ["rover1:read"]
[role.onlooker]
scopes = ["rovers:read"]
[role.fellow]
scopes = ["rovers:share", "rovers:ask", "rovers:help", "rovers:read", "rovers:strategy"]
"""
MANY = 40


class Here:
    """The rovers, the people around them, and one gateway."""

    def __init__(self, place: Lab, brains: RosProcess) -> None:
        self.place = place
        self.bo = place.bo
        self.ada = place.ada
        self.cy = self.di = self.ed = self.fay = 0
        self.brains = brains
        self._heard: Counter[tuple[str, str]] = Counter()

    async def asks(self, who: int, text: str, expected: str) -> str:
        """Have somebody write; return the reply that says what is expected."""
        return str((await self.place.ask(who, text, expected))["text"])

    async def reads(self, who: int, expected: str) -> str:
        """Wait until somebody is shown something."""
        return str((await self.place.reads(who, expected))["text"])

    async def taps(self, who: int, label: str, under: str, expected: str) -> None:
        """Have somebody tap a button below the newest message that says something."""

        async def look() -> int:
            for message in reversed(await self.place.control.messages(who, by_bot=True)):
                labels = [one["text"] for row in message["buttons"] for one in row]
                if under in message["text"] and label in labels:
                    return int(message["message_id"])
            return 0

        message = await self.place.until(look)
        assert message, f"nobody showed {label} under {under}"
        await self.place.control.tap(who, who, message, label)
        await self.reads(who, expected)

    def think(self, robot: str, kind: str, **said: object) -> None:
        """Have a robot's own node say something."""
        self.brains.say(f"say {robot} {msgspec.json.encode({'kind': kind, **said}).decode()}")

    async def hears(self, robot: str, kind: str, ref: str = "") -> dict[str, Any]:
        """Wait for the next of a kind that a robot's own node hears, perhaps with a mark."""
        heard = f"heard {robot} "

        def look() -> dict[str, Any] | None:
            said = [line.removeprefix(heard) for line in self.brains.lines if heard in line]
            told = [
                one
                for one in map(msgspec.json.decode, said)
                if (one["kind"], one.get("ref", "")) == (kind, ref)
            ]
            seen = self._heard[robot, kind]
            return told[seen] if len(told) > seen else None

        found: dict[str, Any] | None = await self.place.until(look)
        assert found is not None, f"{robot} heard no {kind}"
        self._heard[robot, kind] += 1
        return found

    async def shares(self, robot: str, data: object) -> dict[str, Any]:
        """Have it share something on the road; return what it is answered."""
        self.think(robot, "share", topic="road", data=data, ref="s")
        return await self.hears(robot, "result", "s")

    async def count(self, who: int, text: str) -> int:
        """Return how many messages of the bot say something in somebody's chat."""
        messages = await self.place.control.messages(who, by_bot=True)
        return sum(text in message["text"] for message in messages)


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def here(tmp_path_factory: pytest.TempPathFactory, launcher: Launcher) -> AsyncIterator[Here]:
    make_importable()
    ensure_built()
    async with _rovers(tmp_path_factory.mktemp("among"), launcher) as place:
        yield place


@asynccontextmanager
async def _rovers(folder: Path, launcher: Launcher) -> AsyncIterator[Here]:
    tables = []
    for robot in ROVERS:
        (folder / f"{robot}.yaml").write_text(profile("rover", robot, ("rovers",)))
        tables.append(f'[[robot]]\nprofile = "{robot}.yaml"')
        tables.append(
            f'[[principal]]\nname = "{robot}"\naddress = "robot:{robot}"\nrole = "fellow"'
        )
    tables.append(ROLES)
    with RosGraph(folder) as graph:
        graph.start(PROGRAM, *ROVERS, timeout_s=120 * pace())
        brains = graph.start(BRAINS, *ROVERS)
        async with lab(folder, launcher, robots=tables) as place:
            here = Here(place, brains)
            here.cy = await _joins(place, "Cy", "reader")
            here.di = await _joins(place, "Di", "onlooker")
            here.ed = await _joins(place, "Ed", "operator")
            here.fay = await _joins(place, "Fay", "operator")
            place.environment = {name: graph.environment[name] for name in VARIABLES}
            await place.start()
            await _are_heard(here)
            yield here
            assert await place.control.violations() == []


async def _joins(place: Lab, name: str, role: str) -> int:
    """Let somebody be known from the start."""
    account = await place.control.create_user(name)
    table = f'[[principal]]\nname = "{name}"\naddress = "telegram:{account}"\nrole = "{role}"'
    place.config.write_text(f"{place.config.read_text()}\n{table}\n")
    return account


async def _are_heard(here: Here) -> None:
    for rover in ROVERS:
        here.brains.say(f"meet {rover} -")
        await asyncio.to_thread(here.brains.expect, "ok meet")

    async def heard() -> bool:
        told = await here.asks(here.ada, "status", "Rover 1")
        return told.count(": at rest") == len(ROVERS)

    assert await here.place.until(heard), "some robot is not heard"


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def acts(here: Here) -> AsyncIterator[dict[str, asyncio.Task[None]]]:
    """Begin all of it side by side; a test waits for the end of one."""
    stories = {act.__name__: act(here) for act in (_shared, _helped, _worked_otherwise)}
    async with side_by_side(stories) as begun:
        yield begun


async def test_what_a_robot_shares_is_read_followed_and_silenced(
    acts: dict[str, asyncio.Task[None]],
) -> None:
    await acts["_shared"]


async def test_a_robot_is_helped_once_by_whom_somebody_sends(
    acts: dict[str, asyncio.Task[None]],
) -> None:
    await acts["_helped"]


async def test_a_strategy_is_taken_on_kept_over_a_kill_and_taken_back(
    here: Here, acts: dict[str, asyncio.Task[None]]
) -> None:
    await asyncio.wait(acts.values())
    await acts["_worked_otherwise"]
    await _goes_on_after_a_kill(here)


async def _shared(here: Here) -> None:
    await here.asks(here.bo, "/shared", "No robot that you may see shares anything now.")
    assert (await here.shares("rover1", {"wet": True}))["ok"] is True
    assert (await here.shares("rover2", "dry"))["ok"] is True
    assert "Rover 2 · road" in await here.asks(here.bo, "/shared", "Rover 1 · road (")
    assert "Rover 2" not in await here.asks(here.cy, "/shared", "Rover 1 · road (")
    await here.asks(here.cy, "/shared rover2", "I know no robot called rover2.")
    await here.asks(here.cy, "/quiet rover1", "Only who may operate Rover 1 silences it.")

    await here.asks(here.bo, "/shared rover1 road", '{"wet":true}')
    await here.taps(here.bo, "Follow", "Rover 1 · road", "From now on you read here")
    begun_s = time.monotonic()
    for number in range(1, MANY + 1):
        here.think("rover1", "share", topic="road", data=number)
    newest = await here.reads(here.bo, f"Rover 1 shares road: {MANY}")
    assert re.search(r"\(and \d+ before it\)", newest)
    digests = await here.count(here.bo, "Rover 1 shares road: ")
    assert digests <= 1 + (time.monotonic() - begun_s) / EVERY_S, "a digest, not a stream"

    label = "Silence Rover 1"
    await here.taps(here.bo, label, "Rover 1 shares road: ", "Rover 1 is silenced among the robots")
    assert "by Bo" in await here.reads(here.ada, "Rover 1 is silenced among the robots until")
    refused = await here.shares("rover1", "unheard")
    while refused["ok"]:
        refused = await here.hears("rover1", "result", "s")
    assert refused["why"] == "You are silenced for now; a person did that."
    assert "unheard" not in await here.asks(here.ada, "/shared rover1", "Rover 1 · road")
    await here.asks(here.bo, "rover1 goto x=0.2 y=0", "done ")

    await here.asks(here.bo, "/quiet rover1 off", "Rover 1 is heard among the robots again.")
    assert (await here.shares("rover1", "again"))["ok"] is True
    await here.reads(here.bo, 'Rover 1 shares road: "again"')
    assert await here.count(here.bo, "unheard") == 0
    assert await here.count(here.cy, "shares road") == 0, "who does not follow reads no digest"
    await here.asks(here.bo, "/shared rover1 road unfollow", "You read no more here")


async def _helped(here: Here) -> None:
    await here.asks(here.ed, "/assist", "No robot asks for help.")
    here.think("rover2", "help", what="stuck at aisle 4")
    call = "Rover 2 asks for help: stuck at aisle 4."
    await here.reads(here.ada, call)
    listed = await here.asks(here.ada, "/assist", "Rover 2 asks for help: stuck at aisle 4 (")
    found = re.search(r"/assist (\w+)\)", listed)
    assert found
    ident = found[1]
    await here.asks(here.cy, "/assist", "No robot asks for help.")
    await here.asks(here.cy, f"/assist {ident}", "I know no robot called rover2.")
    await here.asks(here.di, f"/assist {ident}", "Help needs the right")

    await here.taps(here.ed, "Send Rover 1", call, "Rover 1 helps Rover 2 (stuck at aisle 4), sent")
    assert (await here.hears("rover1", "assigned"))["to"] == "rover2"
    assert (await here.hears("rover2", "helped"))["by"] == "rover1"
    late = await here.asks(here.ada, f"/assist {ident}", "That was accepted already, by Ed.")
    assert late.endswith("Nothing was changed.")
    await here.asks(here.ed, "/assist", "Rover 2 is helped by Rover 1: stuck at aisle 4")

    await here.asks(here.ed, f"/assist {ident} done", "Rover 2 needs no more help")
    for rover in ROVERS:
        await here.hears(rover, "over")
    await here.asks(here.ed, "/assist", "No robot asks for help.")


async def _worked_otherwise(here: Here) -> None:
    await here.asks(here.fay, "/strategy rover2", "Rover 2: as usual. There are: careful.")
    await here.asks(here.di, "/strategy rover2 careful", "needs the right")
    await here.asks(
        here.fay, "/strategy rover2 careful speed=9 now", "speed must be from 0.05 to 0.8 m/s."
    )
    await here.asks(here.fay, "/strategy rover2 wild now", "There are: careful.")
    usual_s = await _takes_s(here, "0.3")

    await here.asks(here.fay, "/strategy rover2 careful speed=0.1 now", "I say when it has taken")
    await here.reads(here.fay, "Rover 2 has taken on: Careful (speed 0.1 m/s).")
    careful_s = await _takes_s(here, "0")
    assert careful_s > 2.9, "0.3 m, at most 0.1 m a second"
    assert usual_s < careful_s


async def _goes_on_after_a_kill(here: Here) -> None:
    here.place.close()
    await here.place.start()
    await _are_heard(here)
    await here.asks(here.fay, "/strategy rover2", "Rover 2: Careful (speed 0.1 m/s).")
    await here.asks(here.fay, "/strategy rover2 back", "as soon as it carries out nothing")
    await here.reads(here.fay, "Rover 2 has taken on: as usual.")
    await here.asks(here.fay, "/strategy rover2", "Rover 2: as usual.")


async def _takes_s(here: Here, x_m: str) -> float:
    """Let it drive, and return how long it moved by its own word."""
    begun = time.monotonic()
    await here.asks(here.fay, f"rover2 goto x={x_m} y=0", "done ")
    return time.monotonic() - begun
