"""The node ``chat_interface``: one for all ROS 2 robots of a process, there while one is open."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary, proxy

from rosic.core.i18n import said
from rosic.core.time_units import SECOND_NS
from rosic.errors import ConfigurationError, RosicError
from rosic.robots.ros2.client.graph import GraphSnapshot, snapshot
from rosic.robots.ros2.client.rclpy_import import find_interfaces
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.errors import NotSent
from rosic.robots.ros2.messages.names import is_under
from rosic.robots.ros2.messages.types import TypeRegistry

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from typing import TypeAlias

    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Say
    from rosic.robots.ros2.client.topics import Publisher


if TYPE_CHECKING:
    Watcher: TypeAlias = Callable[[GraphSnapshot], None]

_log = logging.getLogger(__name__)

LOOK_EVERY_S = 1.0
SAY_EVERY_NS = 20 * SECOND_NS


class ChatInterfaceNode:
    """The runtime that robots of one clock share, and one slow look at the graph for them all."""

    def __init__(self, clock: Clock) -> None:
        self._clock: Clock = proxy(clock)  # a value that holds its key is never let go
        self._types: set[str] = set()
        self._runtime: RosRuntime | None = None
        self._watchers: list[Watcher] = []
        self._entering = asyncio.Lock()
        self._looking: asyncio.Task[None] | None = None

    async def enter(self, types: Iterable[str], watcher: Watcher, say: Say) -> RosRuntime:
        """Take part, with the first who does opening the node; `leave` must follow.

        Args:
            types: What the robot's profile names.
            watcher: Called with what is on the graph, every `LOOK_EVERY_S`.
            say: Told how far building is, where interfaces have to be built first.

        Raises:
            ConfigurationError: There is no ROS 2 here, or a type that cannot be built.
        """
        async with self._entering:
            wanted = self._types.union(types)
            told = BuildProgress(say, self._clock.monotonic_ns)
            await asyncio.to_thread(find_interfaces, wanted - self._types, told)
            registry = TypeRegistry(wanted)
            if self._runtime is None:
                self._runtime = await self._opened(registry)
            self._runtime.know(registry)
            self._types = wanted
            self._watchers.append(watcher)
            if self._looking is None:
                self._looking = asyncio.create_task(self._look(self._runtime))
            return self._runtime

    async def learn(self, types: Iterable[str]) -> RosRuntime:
        """Let more types be used from now on; only ever such as the owner has named.

        Returns:
            What they are used by.

        Raises:
            ConfigurationError: There is none of that name here, or it cannot be built.
            NotSent: Nobody takes part.
        """
        async with self._entering:
            wanted, runtime = self._types.union(types), self._runtime
            if runtime is None:
                raise NotSent(said("The robot's link to ROS 2 is closed."))
            if wanted != self._types:
                told = BuildProgress(lambda _text: None, self._clock.monotonic_ns)
                await asyncio.to_thread(find_interfaces, wanted - self._types, told)
                runtime.know(TypeRegistry(wanted))
                self._types = wanted
            return runtime

    async def leave(self, watcher: Watcher) -> None:
        """Take part no more; the last closes the node. May be repeated."""
        async with self._entering:
            if watcher in self._watchers:
                self._watchers.remove(watcher)
            if self._watchers or self._runtime is None:
                return
            if self._looking is not None:
                self._looking.cancel()
                self._looking = None
            runtime, self._runtime = self._runtime, None
            await runtime.close()

    async def _opened(self, registry: TypeRegistry) -> RosRuntime:
        try:
            return await RosRuntime.open(
                registry, now_ns=self._clock.monotonic_ns, wall_ns=self._clock.wall_ns
            )
        except NotSent as fault:
            raise ConfigurationError(
                str(fault), hint="Check RMW_IMPLEMENTATION, ROS_DOMAIN_ID and the network."
            ) from fault

    async def _look(self, runtime: RosRuntime) -> None:
        while runtime.alive:
            try:
                seen = await snapshot(runtime)
            except NotSent as fault:
                _log.warning("the ROS graph could not be read: %s", fault)
            else:
                for watcher in tuple(self._watchers):
                    watcher(seen)
            await self._clock.sleep(LOOK_EVERY_S)


class BuildProgress:
    """Passes on how far building is: to the log each tenth, to whoever is told now and then.

    Args:
        say: Called on the event loop that made this.
        now_ns: A monotonic clock.
    """

    def __init__(self, say: Say, now_ns: Callable[[], int]) -> None:
        self._say = say
        self._now_ns = now_ns
        self._loop = asyncio.get_running_loop()
        self._told_ns: int | None = None
        self._tenths: dict[str, int] = {}

    def __call__(self, package: str, fraction: float) -> None:
        """Take in one step; from any thread."""
        self._loop.call_soon_threadsafe(self._take, package, fraction)

    def _take(self, package: str, fraction: float) -> None:
        tenths = int(fraction * 10)
        if tenths <= self._tenths.get(package, -1):
            return
        self._tenths[package] = tenths
        percent = tenths * 10
        _log.info("building the ROS interfaces %s, once: %d %%", package, percent)
        now_ns = self._now_ns()
        if self._told_ns is None or now_ns - self._told_ns >= SAY_EVERY_NS:
            self._told_ns = now_ns
            self._say(
                said(
                    "building the ROS interfaces {package}, once: {percent} %",
                    package=package,
                    percent=percent,
                )
            )


def others_under(seen: GraphSnapshot, namespace: str) -> bool:
    """Tell whether anybody else is below a namespace: a node, or an end of anything."""
    names = (
        *seen.nodes,
        *(topic.name for topic in seen.topics),
        *(offer.name for offer in (*seen.services, *seen.actions)),
    )
    return any(is_under(name, namespace) for name in names)


_stations: WeakKeyDictionary[Clock, ChatInterfaceNode] = WeakKeyDictionary()


def station_of(clock: Clock) -> ChatInterfaceNode:
    """Return the station of a clock: robots that share a clock share a node."""
    station = _stations.get(clock)
    if station is None:
        station = _stations[clock] = ChatInterfaceNode(clock)
    return station


TOPIC = "link"
TYPE = "std_msgs/msg/Header"
EVERY_S = 0.25


class Heartbeat:
    """Publishes the time on ``<namespace>/link``, four times a second while somebody listens.

    It is sent from the event loop that also gives orders and stops: when that hangs, so does this,
    and the robot comes to rest by itself.
    """

    def __init__(self, namespace: str, clock: Clock) -> None:
        self._namespace = namespace
        self._clock = clock
        self._publisher: Publisher | None = None
        self._task: asyncio.Task[None] | None = None

    def types(self) -> set[str]:
        """Return the type of the message."""
        return {TYPE} if self._namespace else set()

    async def open(self, runtime: RosRuntime) -> None:
        """Begin."""
        if self._namespace:
            self._publisher = await runtime.publisher(f"{self._namespace}/{TOPIC}", TYPE)
            self._task = asyncio.create_task(self._beat(self._publisher, runtime.node_name))

    async def close(self) -> None:
        """Cease."""
        task, self._task = self._task, None
        publisher, self._publisher = self._publisher, None
        if task is not None:
            task.cancel()
        if publisher is not None:
            await publisher.close()

    async def _beat(self, publisher: Publisher, sender: str) -> None:
        while True:
            if publisher.listeners:
                now_ns = self._clock.wall_ns()
                stamp = {"stamp.sec": now_ns // SECOND_NS, "stamp.nanosec": now_ns % SECOND_NS}
                try:
                    publisher.publish({**stamp, "frame_id": sender})
                except RosicError as fault:
                    _log.warning("no sign of life on %s: %s", publisher.topic, fault)
            await self._clock.sleep(EVERY_S)
