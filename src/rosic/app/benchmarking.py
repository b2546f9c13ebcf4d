"""Puts benchmarks in their place: where orders live, where rules look, on cards, at the desk."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosic.core.robot.skill import SkillClass
from rosic.features.benchmarks.clerk import BenchmarkCommands
from rosic.features.benchmarks.evaluation import BenchmarkEvaluation, follow
from rosic.features.benchmarks.settings import SETTING, BenchmarkSettings

if TYPE_CHECKING:
    from rosic.app.access import AccessFeature
    from rosic.contracts.clock import Clock
    from rosic.core.records import Memory
    from rosic.core.robot.profile import Profile
    from rosic.features.alerts.evaluator import AlertEvaluator
    from rosic.features.booking.robot_argument import RobotArgument
    from rosic.features.dashboard.glimpses import RobotSnapshots
    from rosic.gateway import Pipeline
    from rosic.gateway.components import Components


class BenchmarkContext(NamedTuple):
    """Who asks how robots do."""

    alerting: AlertEvaluator
    glimpses: RobotSnapshots
    naming: RobotArgument


def furnish_benchmarks(
    rooms: Components, access: AccessFeature, pipeline: Pipeline, memory: Memory, clock: Clock
) -> BenchmarkEvaluation:
    """Follow robots that have benchmarks or can be set; else nothing is followed."""
    settings = BenchmarkSettings(access.changes, clock.wall_ns)
    settings.restore(memory.facts.get(SETTING, ()))
    access.changes.keep(SETTING, settings.apply)
    judging = BenchmarkEvaluation(rooms.linker, rooms.profiles, clock, settings)
    for profile in rooms.profiles.values():
        enlist_judged(judging, pipeline, profile)
    return judging


def enlist_judged(judging: BenchmarkEvaluation, pipeline: Pipeline, profile: Profile) -> None:
    """Follow a robot if it has benchmarks or can be set."""
    judging.enlist(profile)
    skills = profile.skills.values()
    if any(s.benchmark is not None or s.kind is SkillClass.CONFIG for s in skills):
        follow(pipeline.lives, judging)


def show_benchmarks(
    judging: BenchmarkEvaluation, rooms: Components, pipeline: Pipeline, sides: BenchmarkContext
) -> None:
    """Let rules, cards and people ask how robots do."""

    def show() -> None:
        sides.alerting.judged = judging.seen
        sides.glimpses.benchmark = judging.line

    judging.show_with(show)
    clerk = BenchmarkCommands(judging, rooms, sides.naming, pipeline.face)
    pipeline.reception.office.employ("benchmark", clerk.benchmark)
