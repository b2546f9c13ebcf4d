"""A place with one bot and a few people, for journeys that go one step at a time."""

from __future__ import annotations

import asyncio
import time
from contextlib import asynccontextmanager
from random import Random
from typing import TYPE_CHECKING, Any

from tests.journeys.counter import Counter
from tests.journeys.fleet import Person, write_config, write_place
from tests.journeys.gateway import Start
from tests.journeys.running import Gateway, Launcher, fake_telegram
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Sequence
    from pathlib import Path

    from rosic.testing.telegram import Control

WITHIN_S = 60.0 * pace()
SHOWN = 10


class Lab:
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
        self.control = control
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

    # ---- what people do and read ----

    async def say(self, user: int, text: str, chat: int = 0, **unusual: Any) -> int:  # noqa: ANN401
        """Write in somebody's private chat, or in another one; return the message's id."""
        return await self.control.say(chat or user, user, text, **unusual)

    async def ask(
        self,
        user: int,
        text: str,
        expected: str,
        *,
        within_s: float = WITHIN_S,
        **more: Any,  # noqa: ANN401
    ) -> dict[str, Any]:
        """Write, and wait for a reply that says what is expected. Return it."""
        message = await self.say(user, text, **more)
        chat = more.get("chat", user)
        return await self.reads(chat, expected, to=message, within_s=within_s)

    async def reads(
        self, chat: int, expected: str, *, to: int | None = None, within_s: float = WITHIN_S
    ) -> dict[str, Any]:
        """Wait until the bot shows what is expected in a chat, perhaps in reply to a message."""

        async def look() -> dict[str, Any] | None:
            for message in await self.control.messages(chat, by_bot=True):
                if (to is None or message["reply_to"] == to) and expected in (
                    message["text"] or ""
                ):
                    return message
            return None

        found: dict[str, Any] | None = await self.until(look, within_s)
        if found is None:
            said = [(m["reply_to"], m["text"]) for m in await self.control.messages(chat)]
            newest = said[-SHOWN:]
            raise AssertionError(f"nobody read {expected!r} in {within_s:g} s; there is {newest}")
        return found

    async def until(self, look: Callable[[], Any], within_s: float = WITHIN_S) -> Any:  # noqa: ANN401
        """Look again after every change at the server, until something is found; None in the end.

        What is looked for may also change by itself, so it is looked for a few times a second.
        """
        end_s = time.monotonic() + within_s
        while True:
            seq = await self.control.seq()
            found = look()
            found = await found if asyncio.iscoroutine(found) else found
            if found or time.monotonic() > end_s:
                return found or None
            await self.control.wait(seq, 0.2, ["sent", "edited", "answered", "confirmed"])

    async def drained(self, within_s: float = WITHIN_S) -> None:
        """Wait until the gateway has settled everything that people sent."""

        async def empty() -> bool:
            return await self.control.pending() == 0

        assert await self.until(empty, within_s), "there are updates that were not settled"

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
