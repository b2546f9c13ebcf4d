"""How robots do against what is expected of them, and how they are set: Algorithm 2."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.features.benchmarks.commands import BenchmarkCommands
from rosic.features.benchmarks.evaluation import SETTING, BenchmarkEvaluation, BenchmarkSettings
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile
    from rosic.gateway.feature import Kernel
    from rosic.gateway.robot_registry import AddedRobot

__all__ = ["BenchmarkFeature", "setup"]


class BenchmarkFeature(Feature):
    """Follows robots that have benchmarks or can be set; else nothing is followed.

    Attributes:
        evaluation: Follows them.
    """

    def __init__(self, kernel: Kernel, evaluation: BenchmarkEvaluation) -> None:
        self.evaluation = evaluation
        self._executor = kernel.pipeline.executor
        for profile in kernel.rooms.profiles.values():
            self._follow(profile)

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Hold one more robot against its benchmarks."""
        self._follow(newcomer.profile)

    async def close(self) -> None:
        """Wait until everything is written, or noted for later."""
        await self.evaluation.settings.written()

    def _follow(self, profile: Profile) -> None:
        if self.evaluation.add_robot(profile):
            self._executor.watching.watch_orders(self.evaluation)


def setup(kernel: Kernel) -> BenchmarkFeature:
    """Hold robots against their benchmarks, and let rules, dashboards and people ask."""
    settings = BenchmarkSettings(kernel.changes, kernel.clock.wall_ns)
    kernel.keep(SETTING, settings.restore, settings.apply)
    rooms, pipeline = kernel.rooms, kernel.pipeline
    evaluation = BenchmarkEvaluation(rooms.linker, rooms.profiles, kernel.clock, settings)
    kernel.assessment.presence.bind(evaluation.seen)
    kernel.assessment.line.bind(evaluation.line)
    handler = BenchmarkCommands(evaluation, rooms, kernel.naming, pipeline.face)
    pipeline.hooks.commands.register("benchmark", handler.benchmark)
    return BenchmarkFeature(kernel, evaluation)
