"""A place with one bot and a few people, for journeys that go one step at a time."""

from __future__ import annotations

from contextlib import asynccontextmanager
from random import Random
from typing import TYPE_CHECKING

from rosic.testing.telegram.newcomer import ChatReader
from tests.journeys.counter import Counter
from tests.journeys.fleet import Person, write_config, write_place
from tests.journeys.gateway import Start
from tests.journeys.running import Gateway, Launcher, fake_telegram
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence
    from pathlib import Path

    from rosic.testing.telegram import Control

WITHIN_S = 60.0 * pace()


class Lab(ChatReader):
    """Everything around a gateway that may come and go.

    Attributes:
        ada: An admin.
        bo: An operator.
        data: The gateway's data folder.
        environment: What is different for gateways: the ROS domain of their robots.
    """

    def __init__(
        self, folder: Path, launcher: Launcher, control: Control, counter: Counter
    ) -> None:
        self.folder = folder
        self.data = folder / "data"
        super().__init__(control, WITHIN_S)
        self.counter = counter
        self.ada = self.bo = 0
        self.environment: dict[str, str] = {}
        self.config = folder / "rosic.toml"
        self._launcher = launcher
        self._gateways: list[Gateway] = []

    async def settle_in(self, robots: Sequence[str], more: Sequence[Person]) -> None:
        """Open accounts and write the configuration."""
        self.ada = await self.control.create_user("Ada")
        self.bo = await self.control.create_user("Bo")
        people = [Person(self.ada, "Ada", "admin"), Person(self.bo, "Bo"), *more]
        if robots:
            write_config(self.folder, self.control.url, people, robots)
        else:
            write_place(self.folder, self.control.url, people)

    async def start(self, *, listens: bool = True) -> Gateway:
        """Start a gateway, and wait until it listens."""
        start = Start(
            config=str(self.config),
            log=str(self.folder / "gateway.log"),
            counter_port=self.counter.port,
            environment=self.environment,
        )
        gateway = Gateway(self._launcher, start)
        self._gateways.append(gateway)
        if listens:
            await gateway.listens()
        return gateway

    def close(self) -> None:
        """Kill whatever gateway is left."""
        for gateway in self._gateways:
            gateway.kill()

    async def hangs(self) -> bool:
        """Whether a poll has begun that is never answered, because the server was told so."""
        return any(call.get("fault") == "hang" for call in await self.control.calls())

    def acted(self, robot: str = "") -> int:
        """Return how often a robot, or any robot, acted."""
        return sum(1 for e in self.counter.actuations if not robot or e.robot == robot)


@asynccontextmanager
async def lab(
    folder: Path,
    launcher: Launcher,
    *,
    robots: Sequence[str] = (),
    people: Sequence[Person] = (),
    options: Sequence[str] = ("--no-limits", "--no-privacy"),
) -> AsyncIterator[Lab]:
    """Prepare a place; no gateway runs yet.

    Args:
        robots: Tables of the configuration; none takes the five that are counted.
        people: Besides Ada and Bo.
        options: Of the fake server.
    """
    chance = Random(1)  # noqa: S311 - a seed makes it repeatable
    async with (
        fake_telegram(folder, launcher, *options) as control,
        Counter(chance, work_s=0.02) as counter,
    ):
        place = Lab(folder, launcher, control, counter)
        await place.settle_in(robots, people)
        try:
            yield place
        finally:
            place.close()
