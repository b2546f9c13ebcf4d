"""What every stop latch must do, in executable form, and latches that break one rule each."""
# ruff: noqa: D102 - the name of a rule is its sentence, and a faulty one's fault is its own

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from rosic.contracts.store import StopLatch
    from rosic.core.robot.profile import RobotId

OMNI, KUKA = "omni", "kuka1"


class LatchFixture(Protocol):
    """Where latches of one kind can be had."""

    def make(self) -> StopLatch:
        """Return a latch without any data."""
        ...

    def survivor(self, latch: StopLatch) -> StopLatch:
        """Return what the next process would find if the one that owns ``latch`` died now."""
        ...


class LatchConformance:
    """The rules; give it a fixture named ``fixture``."""

    async def test_a_new_latch_holds_nothing(self, fixture: LatchFixture) -> None:
        assert fixture.make().read() == {}

    async def test_a_stop_survives(self, fixture: LatchFixture) -> None:
        latch = fixture.make()
        latch.read()
        await latch.write(OMNI, 3, latched=True)
        assert fixture.survivor(latch).read() == {OMNI: (3, True)}

    async def test_a_resumed_robot_stays_resumed(self, fixture: LatchFixture) -> None:
        latch = fixture.make()
        latch.read()
        await latch.write(OMNI, 3, latched=True)
        await latch.write(OMNI, 3, latched=False)
        assert fixture.survivor(latch).read() == {OMNI: (3, False)}

    async def test_a_generation_never_decreases(self, fixture: LatchFixture) -> None:
        latch = fixture.make()
        latch.read()
        await latch.write(OMNI, 3, latched=True)
        await latch.write(OMNI, 2, latched=False)
        assert fixture.survivor(latch).read() == {OMNI: (3, True)}

    async def test_a_generation_never_decreases_over_a_restart(self, fixture: LatchFixture) -> None:
        latch = fixture.make()
        latch.read()
        await latch.write(OMNI, 3, latched=True)
        second = fixture.survivor(latch)
        await second.write(OMNI, 2, latched=False)
        assert fixture.survivor(second).read() == {OMNI: (3, True)}

    async def test_robots_do_not_mix(self, fixture: LatchFixture) -> None:
        latch = fixture.make()
        latch.read()
        robots = [f"robot{index}" for index in range(50)]
        await asyncio.gather(
            *(
                latch.write(robot, index + 1, latched=bool(index % 2))
                for index, robot in enumerate(robots)
            )
        )
        states = fixture.survivor(latch).read()
        assert states == {r: (i + 1, bool(i % 2)) for i, r in enumerate(robots)}

    async def test_the_last_of_many_writes_counts(self, fixture: LatchFixture) -> None:
        latch = fixture.make()
        latch.read()
        await asyncio.gather(
            *(latch.write(OMNI, index, latched=bool(index % 2)) for index in range(1, 40))
        )
        assert fixture.survivor(latch).read() == {OMNI: (39, True)}


class FaultyLatch:
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


class FaultyLatchFixture:
    """A fixture whose latches all break the same rule."""

    def __init__(self, honest: LatchFixture, faulty: type[FaultyLatch]) -> None:
        self._honest = honest
        self._faulty = faulty
        self._diary: dict[Any, Any] = {}

    def make(self) -> FaultyLatch:
        """Return a faulty latch without data."""
        return self._faulty(self._honest.make(), self._diary)

    def survivor(self, latch: StopLatch) -> FaultyLatch:
        """Return the faulty latch that the next process would find."""
        assert isinstance(latch, FaultyLatch)
        return self._faulty(self._honest.survivor(latch.inner), self._diary)


class InventsStops(FaultyLatch):
    """Holds a robot that nobody stopped."""

    def read(self) -> dict[RobotId, tuple[int, bool]]:
        return self.inner.read() | {"ghost": (1, True)}


class ForgetsStopsOnDisk(FaultyLatch):
    """Lets go as soon as nobody looks."""

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        if not latched:
            await self.inner.write(robot, generation, latched=latched)


class NeverResumes(FaultyLatch):
    """Holds on for ever."""

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        if latched:
            await self.inner.write(robot, generation, latched=latched)


class BelievesTheLast(FaultyLatch):
    """Lets a late word undo a newer stop."""

    def read(self) -> dict[RobotId, tuple[int, bool]]:
        return {robot: state for robot, state in self.diary.items() if isinstance(robot, str)}

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        self.diary[robot] = (generation, latched)


class MixesRobots(FaultyLatch):
    """Has one place for whoever has nearly the same name."""

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        await self.inner.write(robot[:5], generation, latched=latched)


class KeepsTheFirstWord(FaultyLatch):
    """Hears only the first of what is said at the same time."""

    async def write(self, robot: RobotId, generation: int, *, latched: bool) -> None:
        if not self.diary.setdefault(robot, False):
            self.diary[robot] = True
            await asyncio.sleep(0)
            await self.inner.write(robot, generation, latched=latched)
            self.diary[robot] = False


LATCH_FAULTS_BY_RULE: dict[str, type[FaultyLatch]] = {
    "test_a_new_latch_holds_nothing": InventsStops,
    "test_a_stop_survives": ForgetsStopsOnDisk,
    "test_a_resumed_robot_stays_resumed": NeverResumes,
    "test_a_generation_never_decreases": BelievesTheLast,
    "test_a_generation_never_decreases_over_a_restart": BelievesTheLast,
    "test_robots_do_not_mix": MixesRobots,
    "test_the_last_of_many_writes_counts": KeepsTheFirstWord,
}
