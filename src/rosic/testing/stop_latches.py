"""What every stop latch must do, in executable form, and latches that break one rule each."""
# ruff: noqa: D102 - the name of a rule is its sentence, and a sinner's sin is its own

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from rosic.contracts.store import StopLatch
    from rosic.core.robot.profile import RobotId

OMNI, KUKA = "omni", "kuka1"


class LatchPremises(Protocol):
    """Where latches of one kind can be had."""

    def make(self) -> StopLatch:
        """Return a latch without any data."""
        ...

    def survivor(self, latch: StopLatch) -> StopLatch:
        """Return what the next process would find if the one that owns ``latch`` died now."""
        ...


class LatchConformance:
    """The rules; give it a fixture named ``premises``."""

    async def test_a_new_latch_holds_nothing(self, premises: LatchPremises) -> None:
        assert premises.make().read() == {}

    async def test_a_stop_survives(self, premises: LatchPremises) -> None:
        latch = premises.make()
        latch.read()
        await latch.write(OMNI, 3, latched=True)
        assert premises.survivor(latch).read() == {OMNI: (3, True)}

    async def test_a_resumed_robot_stays_resumed(self, premises: LatchPremises) -> None:
        latch = premises.make()
        latch.read()
        await latch.write(OMNI, 3, latched=True)
        await latch.write(OMNI, 3, latched=False)
        assert premises.survivor(latch).read() == {OMNI: (3, False)}

    async def test_a_generation_never_decreases(self, premises: LatchPremises) -> None:
        latch = premises.make()
        latch.read()
        await latch.write(OMNI, 3, latched=True)
        await latch.write(OMNI, 2, latched=False)
        assert premises.survivor(latch).read() == {OMNI: (3, True)}

    async def test_a_generation_never_decreases_over_a_restart(
        self, premises: LatchPremises
    ) -> None:
        latch = premises.make()
        latch.read()
        await latch.write(OMNI, 3, latched=True)
        second = premises.survivor(latch)
        await second.write(OMNI, 2, latched=False)
        assert premises.survivor(second).read() == {OMNI: (3, True)}

    async def test_robots_do_not_mix(self, premises: LatchPremises) -> None:
        latch = premises.make()
        latch.read()
        robots = [f"robot{index}" for index in range(50)]
        await asyncio.gather(
            *(
                latch.write(robot, index + 1, latched=bool(index % 2))
                for index, robot in enumerate(robots)
            )
        )
        states = premises.survivor(latch).read()
        assert states == {r: (i + 1, bool(i % 2)) for i, r in enumerate(robots)}

    async def test_the_last_of_many_writes_counts(self, premises: LatchPremises) -> None:
        latch = premises.make()
        latch.read()
        await asyncio.gather(
            *(latch.write(OMNI, index, latched=bool(index % 2)) for index in range(1, 40))
        )
        assert premises.survivor(latch).read() == {OMNI: (39, True)}


class WickedLatch:
    """An honest latch inside, and a way to do wrong outside."""

    def __init__(self, inner: StopLatch, diary: dict[Any, Any]) -> None:
        self.inner = inner
        self.diary = diary

    def read(self) -> dict[RobotId, tuple[int, bool]]:
        """Tell what is in the honest latch."""
        return self.inner.read()

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        """Write to the honest latch."""
        await self.inner.write(robot, generation, latched=latched)


class WickedLatchPremises:
    """Premises on which every latch sins in the same way."""

    def __init__(self, honest: LatchPremises, sinner: type[WickedLatch]) -> None:
        self._honest = honest
        self._sinner = sinner
        self._diary: dict[Any, Any] = {}

    def make(self) -> WickedLatch:
        """Return a wicked latch without data."""
        return self._sinner(self._honest.make(), self._diary)

    def survivor(self, latch: StopLatch) -> WickedLatch:
        """Return the wicked latch that the next process would find."""
        assert isinstance(latch, WickedLatch)
        return self._sinner(self._honest.survivor(latch.inner), self._diary)


class InventsStops(WickedLatch):
    """Holds a robot that nobody stopped."""

    def read(self) -> dict[RobotId, tuple[int, bool]]:
        return self.inner.read() | {"ghost": (1, True)}


class ForgetsStopsOnDisk(WickedLatch):
    """Lets go as soon as nobody looks."""

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        if not latched:
            await self.inner.write(robot, generation, latched=latched)


class NeverResumes(WickedLatch):
    """Holds on for ever."""

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        if latched:
            await self.inner.write(robot, generation, latched=latched)


class BelievesTheLast(WickedLatch):
    """Lets a late word undo a newer stop."""

    def read(self) -> dict[RobotId, tuple[int, bool]]:
        return {robot: state for robot, state in self.diary.items() if isinstance(robot, str)}

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        self.diary[robot] = (generation, latched)


class MixesRobots(WickedLatch):
    """Has one place for whoever has nearly the same name."""

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        await self.inner.write(robot[:5], generation, latched=latched)


class KeepsTheFirstWord(WickedLatch):
    """Hears only the first of what is said at the same time."""

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        if not self.diary.setdefault(robot, False):
            self.diary[robot] = True
            await asyncio.sleep(0)
            await self.inner.write(robot, generation, latched=latched)
            self.diary[robot] = False


LATCH_SINNERS: dict[str, type[WickedLatch]] = {
    "test_a_new_latch_holds_nothing": InventsStops,
    "test_a_stop_survives": ForgetsStopsOnDisk,
    "test_a_resumed_robot_stays_resumed": NeverResumes,
    "test_a_generation_never_decreases": BelievesTheLast,
    "test_a_generation_never_decreases_over_a_restart": BelievesTheLast,
    "test_robots_do_not_mix": MixesRobots,
    "test_the_last_of_many_writes_counts": KeepsTheFirstWord,
}
