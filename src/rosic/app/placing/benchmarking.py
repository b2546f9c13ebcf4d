"""Puts benchmarks in their place: where orders live, where rules look, on cards, at the desk."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosic.core.skill import SkillClass
from rosic.pipeline.benchmarks.clerk import BenchmarkClerk
from rosic.pipeline.benchmarks.judging import Judging, follow
from rosic.pipeline.benchmarks.settings import SETTING, Settings

if TYPE_CHECKING:
    from rosic.app.placing.access import Access
    from rosic.contracts.clock import Clock
    from rosic.core.record import Memory
    from rosic.core.robot import Profile
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
    for profile in rooms.profiles.values():
        enlist_judged(judging, pipeline, profile)
    return judging


def enlist_judged(judging: Judging, pipeline: Pipeline, profile: Profile) -> None:
    """Follow a robot if it has benchmarks or can be set."""
    judging.enlist(profile)
    skills = profile.skills.values()
    if any(s.benchmark is not None or s.kind is SkillClass.CONFIG for s in skills):
        follow(pipeline.lives, judging)


def show_benchmarks(judging: Judging, rooms: Rooms, pipeline: Pipeline, sides: Sides) -> None:
    """Let rules, cards and people ask how robots do."""

    def show() -> None:
        sides.alerting.judged = judging.seen
        sides.glimpses.benchmark = judging.line

    judging.show_with(show)
    clerk = BenchmarkClerk(judging, rooms, sides.naming, pipeline.face)
    pipeline.reception.office.employ("benchmark", clerk.benchmark)
