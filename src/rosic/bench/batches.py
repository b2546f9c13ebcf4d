"""The paper's Algorithm 11: batches of commands, and how fast people read how they ended."""

from __future__ import annotations

import asyncio
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import msgspec

from rosic.app import runtime
from rosic.app.gateway import Gateway, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.bench.bot_api_process import TOKEN
from rosic.bench.sites import CLOCK, parts_of
from rosic.core.identity import Address
from rosic.core.message import SendPriority
from rosic.core.rate_limit import RateLimit
from rosic.core.robot.profile import Busy, Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from rosic.messengers.telegram.messenger import TelegramMessenger
from rosic.messengers.telegram.rate_limiter import CHAT, OVERALL, PUBLISHED
from rosic.messengers.telegram.settings import read_settings
from rosic.robots.memory import MemoryRobot
from rosic.stores.database import DatabaseStore
from rosic.stores.stop_latch import FileLatch

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.testing.telegram import Control

ROUND_TRIP_S = 0.06
CHAT_PER_S, CHAT_BURST, GROUP_PER_MIN, OVERALL_PER_S = 1.0, 5, 20, 30.0
"""Telegram's published limits; the burst is not published, and the stand-in's own."""
STOP_AFTER_S = 1.5
OVER_WITHIN_S = 300.0
LOOK_EVERY_S = 0.25
SPARE = "spare"
ENDED = "done "


class CommandBatch(msgspec.Struct, frozen=True, kw_only=True):
    """One batch of commands.

    Attributes:
        faster: So many times faster than Telegram, on both sides, for a test of seconds.
        stops: How many stops are said while the outcomes wait, each in another chat.
    """

    name: str
    commands: int
    chats: int = 10
    faster: float = 1.0
    stops: int = 3

    @property
    def permitted_per_s(self) -> float:
        """How many messages and edits a second Telegram takes in the long run."""
        return min(self.chats * CHAT_PER_S, OVERALL_PER_S) * self.faster

    @property
    def kept_per_s(self) -> float:
        """How many of these ROSIC lets itself say: of all chats together fewer, to meet no 429.

        What is on its way counts until a while after its answer.
        """
        counted_s = OVERALL.span_s / self.faster + ROUND_TRIP_S
        return min(self.permitted_per_s, OVERALL.within[SendPriority.OUTCOME] / counted_s)


class BatchFigures(NamedTuple):
    """What one batch came to.

    Attributes:
        rate_per_s: Outcomes delivered per second, after the burst.
        share: Messages and edits a second after the burst, of what is permitted.
        waited_ns: From each command to its outcome, as the server dates them.
        stop_ns: From each stop to its first answer.
        too_many: How often Telegram said 429.
        overtaken: Outcomes that came before the answer to a stop said earlier in their chat.
        wrong: What was lost or doubled; each a sentence.
    """

    rate_per_s: float
    share: float
    waited_ns: list[int]
    stop_ns: list[int]
    too_many: int
    overtaken: int
    wrong: tuple[str, ...] = ()


class BatchSite:
    """People with a chat each, at a server that has just been told its limits."""

    def __init__(self, control: Control, batch: CommandBatch) -> None:
        self.control = control
        self.batch = batch
        self.people: list[int] = []

    async def prepare(self) -> None:
        """Open the chats; limits and record begin anew."""
        control, batch = self.control, self.batch
        self.people = [
            await control.create_user(f"Person {number}") for number in range(batch.chats)
        ]
        await control.call("clear_record")
        await control.call("set_latency", seconds=ROUND_TRIP_S / batch.faster)
        await control.call(
            "set_limits",
            limits={
                "chat_per_s": CHAT_PER_S * batch.faster,
                "chat_burst": CHAT_BURST,
                "group_per_min": GROUP_PER_MIN,
                "overall_per_s": OVERALL_PER_S * batch.faster,
            },
        )

    async def command(self) -> None:
        """Have everybody say their share of the commands, all at once."""
        share = self.batch.commands // self.batch.chats
        for number, person in enumerate(self.people):
            await self.control.backlog(person, person, f"robot{number} go 0.5 m", share)

    async def over(self) -> bool:
        """Wait until every command was answered with how it ended; return whether they were."""
        try:
            async with asyncio.timeout(OVER_WITHIN_S):
                seen = -1
                while seen < self.batch.commands:
                    await asyncio.sleep(LOOK_EVERY_S)
                    seen = sum([await self._ended(person) for person in self.people])
        except TimeoutError:
            return False
        return True

    async def _ended(self, person: int) -> int:
        found = await self.control.messages(person, by_bot=True)
        return len({one["reply_to"] for one in found if ENDED in one["text"]})

    async def found(self, stops: Sequence[tuple[int, int]], burst: int, whole: int) -> BatchFigures:
        """Read the server's record.

        Args:
            stops: Chat and message of each.
            burst: How many calls come at once in a chat; 0 counts them as all others.
            whole: Likewise in all chats together.

        Raises:
            AssertionError: No outcome was read, or a stop was not answered.
        """
        chats = {person: await self.control.messages(person) for person in self.people}
        calls = await self.control.calls()
        answers = [_answer_to_stop(chats[chat], message) for chat, message in stops]
        outcomes = {person: _outcomes(chats[person]) for person in self.people}
        waited = [after - said for one in outcomes.values() for said, after in one]
        if not waited:
            raise AssertionError("no outcome was read")
        asked = self.batch.commands
        lost = f"{len(waited)} of {asked} outcomes were read once."
        spoken = {person: _spoken(chats[person]) for person in self.people}
        permitted = self.batch.permitted_per_s
        together = permitted < self.batch.chats * CHAT_PER_S * self.batch.faster
        rate, calls_per_s = (
            _all_after_burst(outcomes, spoken, whole)
            if together
            else _each_after_burst(outcomes, spoken, burst)
        )
        overtaken = 0
        for (chat, _), (said, answered) in zip(stops, answers, strict=True):
            before = sum(said < at < answered for _, at in outcomes[chat])
            overtaken += max(0, before - 1)  # one was under way already
        return BatchFigures(
            rate,
            calls_per_s / permitted,
            [int(seconds * 1e9) for seconds in waited],
            [int((answered - said) * 1e9) for said, answered in answers],
            sum(call["code"] == TOO_MANY for call in calls),
            overtaken,
            () if len(waited) == asked else (lost,),
        )


TOO_MANY = 429


def _outcomes(messages: Sequence[dict[str, Any]]) -> list[tuple[float, float]]:
    """Return of each command when it was said and when its end could be read first."""
    said = {one["message_id"]: _first_s(one) for one in messages if not one["by_bot"]}
    return [
        (said[one["reply_to"]], version["received_s"])
        for one in messages
        if one["by_bot"] and one["reply_to"] in said
        for version in [next((v for v in one["versions"] if ENDED in v["text"]), None)]
        if version is not None
    ]


def _spoken(messages: Sequence[dict[str, Any]]) -> list[float]:
    """Return when the bot sent or edited something, in order."""
    return sorted(v["received_s"] for one in messages if one["by_bot"] for v in one["versions"])


def _answer_to_stop(messages: Sequence[dict[str, Any]], stop: int) -> tuple[float, float]:
    """Return when a stop was said and when its first answer came."""
    said = next(_first_s(one) for one in messages if one["message_id"] == stop)
    answers = [_first_s(one) for one in messages if one["by_bot"] and "STOP" in one["text"]]
    later = [at for at in answers if at >= said]
    if not later:
        raise AssertionError("a stop was not answered")
    return said, min(later)


def _first_s(message: dict[str, Any]) -> float:
    return float(message["versions"][0]["received_s"])


def _each_after_burst(
    outcomes: dict[int, list[tuple[float, float]]], spoken: dict[int, list[float]], burst: int
) -> tuple[float, float]:
    """Return outcomes and calls a second where each chat has a limit of its own: added up."""
    each = [_after_burst(outcomes[chat], times, burst) for chat, times in spoken.items()]
    return sum(rate for rate, _ in each), sum(calls for _, calls in each)


def _all_after_burst(
    outcomes: dict[int, list[tuple[float, float]]], spoken: dict[int, list[float]], burst: int
) -> tuple[float, float]:
    """Return outcomes and calls a second where the limit of all chats together binds."""
    ended = [one for chat in outcomes.values() for one in chat]
    return _after_burst(ended, sorted(at for one in spoken.values() for at in one), burst)


def _after_burst(
    outcomes: Sequence[tuple[float, float]], times: Sequence[float], burst: int
) -> tuple[float, float]:
    """Return outcomes and calls a second, without those of the burst.

    The burst costs the time that is counted nothing: who sends three at once and then one a second
    has sent n after n - 3 s. What fits into the burst as a whole is counted over its own time, and
    so is everything where no burst is asked for.
    """
    if not outcomes:
        return 0.0, 0.0
    said_s = min(said for said, _ in outcomes)
    times = [at for at in times if at >= said_s]
    last_s = times[-1]
    if not burst or len(times) <= burst:
        took_s = max(last_s - said_s, 1e-3)
        return len(outcomes) / took_s, len(times) / took_s
    took_s = max(last_s - times[0], 1e-3)
    later = sum(at > times[burst - 1] for _, at in outcomes)
    return later / took_s, (len(times) - burst) / took_s


# ---- ROSIC ----


async def through_rosic(control: Control, batch: CommandBatch) -> BatchFigures:
    """Have a gateway with its record on disk follow a batch.

    What came to nothing, and what came twice, is said in what is returned.

    Raises:
        AssertionError: There is nothing to measure: no outcome, or a stop without an answer.
        TimeoutError: The gateway did not take in what was said.
    """
    place = BatchSite(control, batch)
    await place.prepare()
    with tempfile.TemporaryDirectory(prefix="rosic-bench-") as folder:
        latch = FileLatch(Path(folder) / "stops")
        gateway = _gateway(place, DatabaseStore(Path(folder), clock=CLOCK), latch)
        try:
            await gateway.open()
            runtime.settle()
            running = asyncio.create_task(gateway.run())
            try:
                await _listening(place)
                await place.command()
                stops = await _say_stops(place)
                over = await place.over()
                found = await place.found(stops, CHAT.at_once[-2], OVERALL.at_once[-2])
            finally:
                running.cancel()
                await asyncio.wait([running])
                await gateway.close()
        finally:
            await latch.close()
    acted = sum(len(set(r.acted)) for r in gateway.robots.values() if isinstance(r, MemoryRobot))
    wrong = list(found.wrong)
    if not over:
        wrong.append(f"Some commands were not answered in {OVER_WITHIN_S:.0f} s.")
    if acted != batch.commands:
        wrong.append(f"{batch.commands} commands, {acted} acts.")
    return found._replace(wrong=tuple(wrong))


async def _listening(place: BatchSite) -> None:
    """Wait until the gateway answers: what came before that would be backlog."""
    person = place.people[-1]
    end_s = time.monotonic() + OVER_WITHIN_S
    while time.monotonic() < end_s:
        if any(call["method"] == "getUpdates" for call in await place.control.calls()):
            break
        await asyncio.sleep(LOOK_EVERY_S)
    await place.control.say(person, person, "status")
    while not await place.control.messages(person, by_bot=True):
        if time.monotonic() > end_s:
            raise AssertionError("the gateway does not answer")
        await asyncio.sleep(LOOK_EVERY_S)
    # Whatever was said so far is paid for.
    await asyncio.sleep(2 * CHAT_BURST / place.batch.faster)
    await place.control.call("clear_record")


async def _say_stops(place: BatchSite) -> list[tuple[int, int]]:
    """Say stop in some chats, once everything was received and waits to be answered."""
    stops: list[tuple[int, int]] = []
    async with asyncio.timeout(OVER_WITHIN_S):
        while await place.control.pending():  # noqa: ASYNC110 - a process of its own
            await asyncio.sleep(LOOK_EVERY_S)
    for person in place.people[: place.batch.stops]:
        await asyncio.sleep(STOP_AFTER_S / place.batch.faster)
        stops.append((person, await place.control.say(person, person, f"stop {SPARE}")))
    return stops


def _gateway(place: BatchSite, store: DatabaseStore, latch: FileLatch) -> Gateway:
    batch = place.batch
    settings = read_settings(
        "bench", {"token": TOKEN, "api_base": place.control.api_base, "poll_timeout_s": 1}
    )
    messenger = TelegramMessenger("bench", settings, CLOCK, rates=PUBLISHED.times(batch.faster))
    people = [
        ConfiguredPerson(f"person {person}", (Address("telegram", str(person)),), ("operator",))
        for person in place.people
    ]
    robots = [f"robot{number}" for number in range(batch.chats)]
    return Gateway(
        GatewaySettings(
            profiles=tuple(_profile(name, batch.commands) for name in (*robots, SPARE)),
            people=tuple(people),
            limit=RateLimit(burst=1e9, per_s=1e9),
        ),
        parts_of(store, messenger, latch=latch),
    )


def _profile(name: str, commands: int) -> Profile:
    return Profile(
        id=name,
        link=Link(kind="memory"),
        busy=Busy.QUEUE,
        queue_length=commands,
        skills={
            "go": Skill(
                id="go",
                lifetime_s=OVER_WITHIN_S,
                parameters={"distance": Parameter(unit="m", min=0.01, max=5.0)},
            )
        },
    )
