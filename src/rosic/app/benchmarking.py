"""Puts benchmarks in their place: where orders live, where rules look, on cards, at the desk."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosic.core.skill import SkillClass
from rosic.pipeline.benchmarks.clerk import BenchmarkClerk
from rosic.pipeline.benchmarks.judging import Both, Judging
from rosic.pipeline.benchmarks.settings import SETTING, Settings

if TYPE_CHECKING:
    from rosic.app.access import Access
    from rosic.contracts.clock import Clock
    from rosic.core.record import Memory
    from rosic.pipeline import Pipeline
    from rosic.pipeline.alerts.alerting import Alerting
    from rosic.pipeline.livecards.glimpses import Glimpses
    from rosic.pipeline.rooms import Rooms
    from rosic.pipeline.times.naming import Naming


class Sides(NamedTuple):
    """Who asks how robots do."""

    alerting: Alerting
    glimpses: Glimpses
    naming: Naming


def furnish_benchmarks(
    rooms: Rooms, access: Access, pipeline: Pipeline, memory: Memory, clock: Clock
) -> Judging:
    """Follow robots that have benchmarks or can be set; else nothing is followed."""
    settings = Settings(access.changes, clock.wall_ns)
    settings.restore(memory.facts.get(SETTING, ()))
    access.changes.keep(SETTING, settings.apply)
    judging = Judging(rooms.linker, rooms.profiles, clock, settings)
    wanted = any(
        skill.benchmark is not None or skill.kind is SkillClass.CONFIG
        for profile in rooms.profiles.values()
        for skill in profile.skills.values()
    )
    if wanted:
        lives = pipeline.lives
        lives.watch = judging if lives.watch is None else Both(lives.watch, judging)
    return judging


def show_benchmarks(judging: Judging, rooms: Rooms, pipeline: Pipeline, sides: Sides) -> None:
    """Let rules, cards and people ask how robots do."""
    if any(profile.benchmarked for profile in rooms.profiles.values()):
        sides.alerting.judged = judging.seen
        sides.glimpses.benchmark = judging.line
    clerk = BenchmarkClerk(judging, rooms, sides.naming, pipeline.face)
    pipeline.reception.office.employ("benchmark", clerk.benchmark)
