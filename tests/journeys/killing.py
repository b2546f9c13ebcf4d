"""Kill the gateway again and again while people give commands; then see what became of each."""

from __future__ import annotations

import asyncio
import signal
import time
from collections import Counter as Counted
from collections import defaultdict
from contextlib import suppress
from random import Random
from typing import TYPE_CHECKING

import msgspec

from tests.journeys.counter import Counter
from tests.journeys.fleet import write_place
from tests.journeys.gateway import Start
from tests.journeys.reading import Reply, read_reply, summarised
from tests.journeys.report import Report
from tests.journeys.running import Gateway, Launcher, fake_telegram
from tests.journeys.stream import Crowd, Stream, gather
from tests.journeys.verdict import Verdict, judge
from tests.pace import slowness

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.testing.telegram import Control

LONGEST_S = 1.5
MOMENTS = ("opening", "listening", "acting", "delivering", "telling")


class Plan(msgspec.Struct, frozen=True, kw_only=True):
    """One journey.

    Attributes:
        kills: How often the gateway is killed.
        fault: Name of a faulty part in it; empty for none.
        pause_s: Mean time between two messages of all people together.
        twice: Share of updates that the server gives out twice.
        cold_every: Every so many lives begin with a Python that has nothing imported; 0 for none.
        moments: At which kinds of moment it is killed.
        settled_within_s: How long everybody may wait in the end.
    """

    kills: int
    seed: int
    fault: str = ""
    pause_s: float = 0.06
    twice: float = 0.08
    cold_every: int = 0
    moments: tuple[str, ...] = MOMENTS
    settled_within_s: float = 180.0


class Journey:
    """Everything that takes part in one, and what was seen."""

    def __init__(
        self, plan: Plan, folder: Path, launcher: Launcher, control: Control, counter: Counter
    ) -> None:
        self.plan = plan
        self.chance = Random(plan.seed)  # noqa: S311 - a seed makes it repeatable
        self.control = control
        self.counter = counter
        self.ready_s: list[float] = []
        self.moments: Counted[str] = Counted()
        # What a gateway gets done in a second on a free machine, it is given the time for.
        self._longest_s = LONGEST_S * slowness()
        self._folder = folder
        self._launcher = launcher
        self._crowd: Crowd | None = None
        self._config: Path | None = None

    async def run(self) -> Report:
        """Make the whole journey."""
        began_s = time.monotonic()
        crowd = self._crowd = await gather(self.control)
        self._config = write_place(self._folder, self.control.url, crowd.known)
        stream = Stream(self.control, crowd, self.chance, self.plan.pause_s, self.plan.twice)
        talking = asyncio.create_task(stream.run())
        try:
            for number in range(self.plan.kills):
                await self._live_and_die(stream, number)
        finally:
            talking.cancel()
            await asyncio.gather(talking, return_exceptions=True)
        verdict = await self._settle(stream)
        verdict.wrong += [str(found) for found in await self.control.violations()]
        return Report(
            plan=self.plan,
            took_s=time.monotonic() - began_s,
            verdict=verdict,
            ready_s=self.ready_s,
            moments=self.moments,
            commands=len(stream.commands),
            actuations=len(self.counter.actuations),
            stops=stream.stops,
            duplicated=stream.duplicated,
            resumes=len(stream.resumes),
            unanswered=len(set(stream.resumes) - set(await self.replies())),
        )

    def _start(self, number: int) -> Gateway:
        assert self._config is not None
        log = self._folder / "gateway.log"
        start = Start(
            config=str(self._config),
            log=str(log),
            counter_port=self.counter.port,
            fault=self.plan.fault,
        )
        if self.plan.cold_every and number % self.plan.cold_every == 0:
            return Gateway(self._launcher, start, cold=True)
        return Gateway(self._launcher, start)

    async def _live_and_die(self, stream: Stream, number: int) -> None:
        """Start a gateway and kill it at a moment that chance chose."""
        moment = self.chance.choice(self.plan.moments)
        gateway = self._start(number)
        if moment == "opening":
            await asyncio.sleep(self.chance.uniform(0, 0.4))
        else:
            self.ready_s.append(await gateway.listens())
            stream.unheard = False
            await stream.resume_all()
            with suppress(TimeoutError):
                async with asyncio.timeout(self._longest_s):
                    await self._come(moment)
        gateway.kill()
        stream.unheard = True
        self.moments[moment] += 1

    async def _come(self, moment: str) -> None:
        """Wait for a moment: soon after something happened, so that little of it is written."""
        chance = self.chance
        if moment == "listening":
            await asyncio.sleep(chance.uniform(0, self._longest_s))
        elif moment == "acting":
            count = len(self.counter.actuations) + chance.randint(2, 10)
            await self.counter.wait_for(count, self._longest_s)
            await asyncio.sleep(chance.uniform(0, 0.02))
        else:
            kinds = ["sent", "edited"] if moment == "telling" else ["delivered", "confirmed"]
            for _ in range(chance.randint(2, 12)):
                await self.control.wait(await self.control.seq(), self._longest_s, kinds)
            await asyncio.sleep(chance.uniform(0, 0.01))

    async def _settle(self, stream: Stream) -> Verdict:
        """Start once more, and wait until everybody was told, but not for ever."""
        gateway = self._start(-1)
        try:
            self.ready_s.append(await gateway.listens())
            end_s = time.monotonic() + self.plan.settled_within_s
            while True:
                seq = await self.control.seq()
                verdict = await self._judge(stream)
                if not verdict.untold or time.monotonic() > end_s:
                    break
                await self.control.wait(seq, 2.0, ["sent", "edited"])
            await gateway.ends(60.0, signal.SIGTERM)
        finally:
            if not gateway.is_gone():
                gateway.kill()
        return await self._judge(stream)

    async def _judge(self, stream: Stream) -> Verdict:
        return judge(stream.commands, await self.replies(), self.counter.events)

    async def replies(self) -> dict[tuple[int, int], list[Reply]]:
        """Return what the bot said, by chat and by the message that it answers."""
        assert self._crowd is not None
        found: dict[tuple[int, int], list[Reply]] = defaultdict(list)
        for chat in self._crowd.chats:
            for message in await self.control.messages(chat, by_bot=True):
                if message["reply_to"] is not None or summarised(message):
                    found[chat, message["reply_to"] or 0].append(read_reply(message))
        return found


async def journey(plan: Plan, folder: Path, launcher: Launcher) -> Report:
    """Make one journey and return what was seen."""
    chance = Random(plan.seed + 1)  # noqa: S311 - a seed makes it repeatable
    async with (
        fake_telegram(folder, launcher, "--no-limits", "--no-privacy") as control,
        Counter(chance, failing=0.05, silent=0.01) as counter,
    ):
        return await Journey(plan, folder, launcher, control, counter).run()
