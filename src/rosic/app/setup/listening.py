"""A bounded listen to what a robot reports: what the names and types of its topics do not tell."""

from __future__ import annotations

import asyncio
from math import isfinite
from typing import TYPE_CHECKING, Final, NamedTuple, TypeVar

from rosic.app.setup.profile_draft import (
    BATTERY,
    JOINTS,
    ODOMETRY,
    ReportedTopics,
    SeenRobot,
    rest_of,
)
from rosic.core.time_units import SECOND_NS
from rosic.errors import RosicError
from rosic.robots.ros2.client.topics import TopicQos
from rosic.robots.ros2.profile import AtRest
from rosic.robots.ros2.reported_units import FULL
from rosic.robots.ros2.rest_reading import RestReading

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Iterable

    from rosic.contracts.clock import Clock
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.topics import LatestMessage

T = TypeVar("T")

LISTENED_S: Final = 3.0
ENOUGH: Final = 30
"""After so many messages nothing new is expected."""
AT_MOST: Final = 16
"""Of one robot so many topics are listened to."""
OLD_NS: Final = SECOND_NS
NEWEST: Final = TopicQos(reliable=False, depth=1)


class _Rest(NamedTuple):
    every_s: float | None
    doubt: str


async def listened(runtime: RosRuntime, clock: Clock, seen: SeenRobot) -> SeenRobot:
    """Return a robot with what it said of its rest and its battery, all topics at once."""
    showing = [t for t in sorted(seen.said.items()) if t[1] in {ODOMETRY, JOINTS}][:AT_MOST]
    charged = [t for t in sorted(seen.said.items()) if t[1] == BATTERY][:AT_MOST]
    rests = await _all(_rest(runtime, clock, topic, kind) for topic, kind in showing)
    heard = {topic: rest for (topic, _), rest in zip(showing, rests, strict=True)}
    full = await _all(_charge(runtime, topic) for topic, _ in charged)
    return seen._replace(
        reported=ReportedTopics(
            every_s={topic: rest.every_s for topic, rest in heard.items() if rest.every_s},
            no_rest={topic: rest.doubt for topic, rest in heard.items() if rest.doubt},
            per_cent=frozenset(
                topic for (topic, _), most in zip(charged, full, strict=True) if most > FULL
            ),
        )
    )


async def _rest(runtime: RosRuntime, clock: Clock, topic: str, kind: str) -> _Rest:
    """Listen to what could show rest, until it is known how often it comes, or why it does not."""
    try:
        source = await runtime.latest(topic, kind, NEWEST)
    except RosicError:  # its type is not installed here
        return _Rest(None, "")
    try:
        rest = AtRest(**rest_of(topic, kind))
        reading = RestReading(rest, source, runtime.types.message(kind), clock)
        doubt, first, first_ns = "", 0, 0
        async for count in _messages(source):
            first, first_ns = first or count, first_ns or (source.received_ns or 0)
            doubt = reading.doubt(clock.monotonic_ns() - OLD_NS)
            if doubt:
                break
        more = source.received - first
        past_s = ((source.received_ns or 0) - first_ns) / SECOND_NS
        return _Rest(past_s / more if more else None, doubt)
    finally:
        await source.close()


async def _charge(runtime: RosRuntime, topic: str) -> float:
    """Return the most that a battery said of its charge; 0 for one that said nothing."""
    try:
        source = await runtime.latest(topic, BATTERY, NEWEST)
    except RosicError:
        return 0.0
    most = 0.0
    try:
        async for _ in _messages(source):
            message = source.message()
            told = float("nan") if message is None else float(message.percentage)
            most = max(most, told if isfinite(told) else 0.0)
            if most:
                break
    except RosicError:
        return most
    finally:
        await source.close()
    return most


async def _messages(source: LatestMessage) -> AsyncIterator[int]:
    """Yield how many have come, each time that there are more, for a bounded time."""
    received, end_s = 0, asyncio.get_running_loop().time() + LISTENED_S
    while received < ENOUGH:
        try:
            left_s = end_s - asyncio.get_running_loop().time()
            received = await source.newer(received, timeout_s=left_s)
        except TimeoutError:
            return
        yield received


async def _all(waiting: Iterable[Awaitable[T]]) -> list[T]:
    return list(await asyncio.gather(*waiting))
