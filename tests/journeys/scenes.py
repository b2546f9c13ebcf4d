"""One place for five scenarios: a gateway, people in one messenger, ten robots as ROS 2 nodes."""

from __future__ import annotations

import asyncio
import re
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from rosic.robots.ros2.bindings.parameters import SET_PARAMETERS
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.interfaces.cache import ensure_built, make_importable
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.testing.ros2.graph import RosGraph
from rosic_sim.scenarios.robots import FOLDER
from tests.journeys.gateway import Start
from tests.journeys.ros import VARIABLES
from tests.journeys.running import Gateway, Launcher
from tests.pace import pace
from tests.real.ros2.simulated import link_lost, set_fault

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.testing.ros2.graph import RosProcess
    from tests.journeys.chats import PrivateChats, ShownMessage

PROGRAM = Path(__file__).with_name("ros_robots.py")
BRAINS = Path(__file__).parents[1] / "real" / "ros2" / "fellow_peer.py"
DRONES = ("cf1", "cf2", "cf3")
ROVERS = ("rover1", "rover2")
# What is made of the profiles of the plays: kind, id, groups.
CARRIERS = ("carrier1", "carrier2", "carrier3")
MADE = (
    ("watch", "watch", ()),
    ("carrier", "carrier1", ("carriers", "north")),
    ("carrier", "carrier2", ("carriers", "north", "south")),
    ("carrier", "carrier3", ("carriers", "south")),
    ("rover", "rover1", ("rovers",)),
    ("rover", "rover2", ("rovers",)),
)
SHIPPED = ("kuka1", *DRONES)
STUDENTS = tuple(f"Student {number}" for number in range(1, 21))
ADMIN = "Ada"
PEOPLE = {
    ADMIN: "admin",
    "Ranger": "ranger",
    **dict.fromkeys(STUDENTS, "student"),
    "Teacher": "teacher",
    "Manager": "keeper",
    "North manager": "north",
    "South manager": "south",
    "Night manager": "keeper",
    "Search leader": "leader",
}
SHOWN = 10
GATEWAY = """
[gateway]
data = "data"
lease_idle_s = 20.0
preempt = ["kuka1"]

[limits]
burst = 100000
per_s = 100000
"""
MISSION = """
name: restock
title: Restock
do:
  - together:
      - { on: carriers, steps: [goto x=0.4 y=0.2], battery: 30 }
      - { on: carriers, steps: [goto x=0.4 y=-0.2], battery: 30 }
  - { on: carriers, steps: [goto x=0 y=0.2], battery: 30 }
"""
RULES = """
[[mission]]
file = "restock.yaml"
[role.ranger]
scopes = ["watch:*"]
[role.student]
scopes = ["kuka1:home", "kuka1:grasp", "kuka1:move_joint"]
limits = ["force <= 20 N"]
priority = 10
[role.teacher]
scopes = ["kuka1:*"]
priority = 20
[role.keeper]
scopes = ["carriers:*"]
[role.north]
scopes = ["north:*"]
[role.south]
scopes = ["south:*"]
[role.leader]
scopes = ["crazyflies:*", "rovers:*"]
[role.fellow]
scopes = ["rovers:share", "rovers:ask", "rovers:help", "rovers:read"]
"""


class Scenes:
    """Everybody and everything.

    Attributes:
        chats: What people do there.
        brains: The rovers' own nodes.
    """

    def __init__(self, chats: PrivateChats, runtime: RosRuntime, acted: Path) -> None:
        self.chats = chats
        self.brains: RosProcess | None = None
        self._runtime = runtime
        self._acted = acted
        self._from: dict[str, int] = {}

    async def asks(self, who: str, text: str, expected: str) -> ShownMessage:
        """Have somebody write; return the reply that says what is expected."""
        return await self.reads(who, expected, to=await self.says(who, text))

    async def gives(self, who: str, text: str) -> str:
        """Have somebody give a task; return its number."""
        given = await self.asks(who, f"/task {text}", "Task ")
        found = re.match(r"Task (\d+): ", given.text)
        assert found, given.text
        return found[1]

    async def has(self, who: str, kind: str, text: str) -> str:
        """Return which robot of a kind carries out what somebody reads a card about."""
        card = await self.reads(who, text)
        found = re.search(rf"{kind} (\d): ", card.text)
        assert found, card.text
        return found[1]

    async def says(self, who: str, text: str) -> str:
        """Have somebody write, and wait for nothing."""
        return await self.chats.say(who, text)

    async def reads(self, who: str, expected: str, to: str | None = None) -> ShownMessage:
        """Wait until somebody is shown what is expected."""

        async def look() -> ShownMessage | None:
            for message in await self.chats.messages(who):
                if (to is None or message.reply_to == to) and expected in message.text:
                    return message
            return None

        found: ShownMessage | None = await self.chats.until(who, look)
        if found is None:
            said = [(one.reply_to, one.text) for one in await self.chats.messages(who)]
            raise AssertionError(f"{who} did not read {expected!r}; there is {said[-SHOWN:]}")
        return found

    async def comes_to(self, who: str, text: str, expected: str) -> None:
        """Have somebody ask until they are answered what is expected."""

        async def answered() -> bool:
            return expected in (await self.asks(who, text, ": ")).text

        assert await self.chats.until(who, answered), f"{text} never came to {expected}"

    async def shown(self, who: str, text: str) -> int:
        """Return how many messages of somebody's chat say something now."""
        return sum(text in message.text for message in await self.chats.messages(who))

    async def taps(self, who: str, label: str, expected: str) -> None:
        """Have somebody tap the newest button of a label."""

        async def look() -> tuple[ShownMessage, str] | None:
            for message in reversed(await self.chats.messages(who)):
                for one in message.labels:
                    if label in one:
                        return message, one
            return None

        found = await self.chats.until(who, look)
        assert found, f"nobody showed {who} {label}"
        await self.chats.tap(who, *found)
        await self.reads(who, expected)

    async def breaks(self, robot: str, name: str, value: bool | float) -> None:
        """Break something in a robot, or mend it."""
        await set_fault(self._runtime, robot, name, value)

    async def thinks(self, robot: str, kind: str, **said: object) -> None:
        """Have a robot's own node say something."""
        assert self.brains is not None
        words = msgspec.json.encode({"kind": kind, **said}).decode()
        self.brains.say(f"say {robot} {words}")
        await asyncio.to_thread(self.brains.expect, "ok say")

    async def heard(self, robot: str, kind: str) -> dict[str, Any]:
        """Wait until a robot's own node has heard something of a kind."""
        assert self.brains is not None
        while True:
            line = await asyncio.to_thread(self.brains.expect, f"heard {robot} ")
            told: dict[str, Any] = msgspec.json.decode(line)
            if told["kind"] == kind:
                return told

    def acted(self, robot: str) -> list[str]:
        """Return the skills a robot has begun, as its own process wrote them down."""
        lines = self._acted.read_text().splitlines() if self._acted.exists() else []
        own = [line.split() for line in lines if line.startswith(f"{robot} ")]
        return [words[1] for words in own][self._from.get(robot, 0) :]

    def from_now(self, *robots: str) -> None:
        """Forget what these robots have begun so far."""
        for robot in robots:
            self._from[robot] = 0
            self._from[robot] = len(self.acted(robot))


def profile(kind: str, robot: str, groups: tuple[str, ...]) -> str:
    """Return a profile of the plays under another name, reached over ROS 2."""
    text = (FOLDER / f"{kind}.yaml").read_text()
    text = text.replace(f"/{kind}", f"/{robot}").replace(f"id: {kind}\n", f"id: {robot}\n")
    shown = f"{kind.capitalize()} {robot[-1]}"
    text = text.replace(f"title: {kind.capitalize()}\n", f"title: {shown}\n")
    if kind == "rover":
        text = text.replace("min: -10, max: 10", "min: -50, max: 50")
        text = text.replace("model: omni }", "model: omni, among: true }")
    return f"{text}groups: [{', '.join(groups)}]\n"


@asynccontextmanager
async def scenes(folder: Path, launcher: Launcher, chats: PrivateChats) -> AsyncIterator[Scenes]:
    """Let all of it run while inside."""
    make_importable()
    ensure_built()
    acted = folder / "acted"
    robots = [f'[[robot]]\nprofile = "{name}"' for name in SHIPPED]
    for kind, robot, groups in MADE:
        (folder / f"{robot}.yaml").write_text(profile(kind, robot, groups))
        robots.append(f'[[robot]]\nprofile = "{robot}.yaml"')
    (folder / "restock.yaml").write_text(MISSION)
    await chats.open(tuple(PEOPLE))
    config = _write(folder, chats, robots)
    with RosGraph(folder) as graph:
        named = (*SHIPPED, *(robot for _, robot, _ in MADE))
        graph.start(PROGRAM, "--actuations", acted, *link_lost(), *named, timeout_s=120 * pace())
        types = TypeRegistry([SET_PARAMETERS])
        opening = RosRuntime.open(types, node_name="onlooker", domain_id=graph.domain_id)
        environment = {name: graph.environment[name] for name in VARIABLES}
        start = Start(config=str(config), log=str(folder / "gateway.log"), environment=environment)
        async with await opening as runtime:
            gateway = Gateway(launcher, start)
            try:
                await gateway.listens()
                await chats.meet()
                here = Scenes(chats, runtime, acted)
                here.brains = await asyncio.to_thread(graph.start, BRAINS, *ROVERS)
                await _are_there(here)
                yield here
                await chats.settle()
            finally:
                gateway.kill()


def _write(folder: Path, chats: PrivateChats, robots: list[str]) -> Path:
    """Write the configuration: everybody, every robot, one messenger."""
    people = [(name, chats.address(name), role) for name, role in PEOPLE.items()]
    people += [(robot, f"robot:{robot}", "fellow") for robot in ROVERS]
    principals = [
        f'[[principal]]\nname = "{name}"\naddress = "{address}"\nrole = "{role}"'
        for name, address, role in people
    ]
    messenger = f'[[messenger]]\nname = "lab"\n{chats.messenger}'
    file = folder / "rosic.toml"
    file.write_text("\n\n".join([GATEWAY, messenger, *robots, *principals, RULES]))
    return file


async def _are_there(here: Scenes) -> None:
    """Wait until every robot was heard, and the rovers' own nodes are listened to."""
    assert here.brains is not None
    for rover in ROVERS:
        here.brains.say(f"meet {rover} -")
        await asyncio.to_thread(here.brains.expect, "ok meet")

    async def heard() -> bool:
        told = await here.asks(ADMIN, "status", "KUKA")
        return "not " not in told.text and told.text.count(": at rest") == len(MADE) + 4

    assert await here.chats.until(ADMIN, heard), "some robot is not heard"
