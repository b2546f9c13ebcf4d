"""Where simulated robots live: one world per clock, stepped only while something moves."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary, proxy

from rosic_sim.robots.machines.world import SimulatedWorld, build_world

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.clock import Clock

STEP_S = 0.02
LINK_LOST_S = 1.0


class SimulationLoop:
    """A world and the task that steps it.

    At rest nothing runs: a gateway with six simulated robots idles. It does not keep its clock
    alive, but its robots do: the world ends with the last of them and whoever owns the clock.

    Attributes:
        world: The machines.
        link_lost_s: When nobody could have stopped them for so long, by the clock, they hold or
            land by themselves.
    """

    def __init__(self, clock: Clock) -> None:
        self.link_lost_s = LINK_LOST_S
        self._stepped_s: float | None = None
        self.world: SimulatedWorld = build_world()
        self._clock: Clock = proxy(clock)  # a value that holds its key is never let go
        self._watchers: list[Callable[[], None]] = []
        self._task: asyncio.Task[None] | None = None

    def now_s(self) -> float:
        """Return the present on the world's clock."""
        return self._clock.monotonic_ns() / 1e9

    def stretch_links(self, factor: float) -> None:
        """Let links outlast so many times as long."""
        self.link_lost_s *= factor

    def watch(self, watcher: Callable[[], None]) -> None:
        """Call a watcher after every step."""
        self._watchers.append(watcher)

    def forget(self, watcher: Callable[[], None]) -> None:
        """Call it no more; without watchers nothing is stepped."""
        if watcher in self._watchers:
            self._watchers.remove(watcher)
        if not self._watchers and self._task is not None:
            self._task.cancel()
            self._task = None

    def wake(self) -> None:
        """Step from now on, until everything rests."""
        if self._task is None or self._task.done():
            self._stepped_s = None
            self._task = asyncio.create_task(self._run())

    async def _run(self) -> None:
        while True:
            now_s = self.now_s()
            self._lose_links(now_s)
            self.world.step(now_s)
            self._stepped_s = now_s
            for watcher in tuple(self._watchers):
                watcher()
            if not self.world.moving:
                return
            await self._clock.sleep(STEP_S)

    def _lose_links(self, now_s: float) -> None:
        """Let what moved hold or land by itself, if nobody could have stopped it meanwhile (I6).

        The machines are in this process: when it stands still, so does whoever gives stops.
        """
        if self._stepped_s is None or now_s - self._stepped_s <= self.link_lost_s:
            return
        lost_s = self._stepped_s + self.link_lost_s
        self.world.step(lost_s)
        for machine in self.world.machines.values():
            if machine.moving:
                machine.link_lost(lost_s)


_simulations: WeakKeyDictionary[Clock, SimulationLoop] = WeakKeyDictionary()


def simulation_of(clock: Clock) -> SimulationLoop:
    """Return the simulation of a clock: robots that share a clock share a world."""
    simulation = _simulations.get(clock)
    if simulation is None:
        simulation = _simulations[clock] = SimulationLoop(clock)
    return simulation
