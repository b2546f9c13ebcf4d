"""The clockwork that all machines share: time, recipes, ends."""

from __future__ import annotations

import abc
from collections.abc import Callable, Generator, Mapping
from math import inf, isfinite
from typing import TYPE_CHECKING, TypeAlias

from rosic.core.i18n import said
from rosic.core.synchronised_start import TOO_LATE_NS
from rosic_sim.robots.machines.activity import (
    Activity,
    ActivityFailed,
    ActivityRefused,
    ActivityState,
)
from rosic_sim.robots.machines.arguments import MachineArguments, Value

if TYPE_CHECKING:
    from rosic_sim.robots.machines.machine import Battery

SUBSTEP_S = 0.01
LONGEST_WAIT_S = 60.0
TOO_LATE_S = TOO_LATE_NS / 1e9

Recipe: TypeAlias = Generator[None, None, str]
"""A skill as it unfolds: resumed before every substep, returns the closing sentence."""

Plan: TypeAlias = Callable[[MachineArguments], Recipe]
"""Checks arguments and present state without moving anything, then returns the recipe."""


class SteppedMachine(abc.ABC):
    """The part of a machine that does not depend on its kind: time, recipes, ends."""

    def __init__(self, robot: str, battery: Battery | None = None) -> None:
        self.id = robot
        self.battery = battery
        self.activity: Activity | None = None
        self.note = ""
        self._now_s: float | None = None
        self._start_s = -inf
        self._recipe: Recipe | None = None
        self._unsettled = False
        self._count = 0
        self._dt_s = SUBSTEP_S

    # ------------------------------------------------------------------ what a kind of machine adds

    @abc.abstractmethod
    def _plan(self, skill: str) -> Plan | None:
        """Return how a skill is planned, or None for a skill this machine has not."""

    @abc.abstractmethod
    def _drive(self, dt_s: float) -> None:
        """Advance the mechanics by one substep."""

    @abc.abstractmethod
    def _brake(self) -> None:
        """From now on `_drive` brings the machine to rest."""

    @abc.abstractmethod
    def _in_motion(self) -> bool:
        """Tell whether the mechanics would change in the next substep without a recipe."""

    @abc.abstractmethod
    def at_rest(self) -> bool:
        """Tell, from measured speeds, whether nothing moves."""

    @abc.abstractmethod
    def telemetry(self) -> Mapping[str, float | str]:
        """Return the newest measurements."""

    def _watch(self) -> None:  # noqa: B027  not every machine has something to watch
        """Look after what the machine must react to by itself; once a substep, while moving."""

    def _idle(self, dt_s: float) -> None:  # noqa: B027  not every machine has a battery
        """Account for time in which nothing moved."""

    def _after_failure(self) -> None:
        """Come to what is safe when a recipe has failed; the recipe may have done so already."""
        self._brake()

    def _settled(self) -> bool:
        """Tell whether the motion that an activity has left behind is over."""
        return self.at_rest()

    def _able(self) -> None:  # noqa: B027  most machines are always able
        """Raise ActivityRefused when no skill at all can begin now."""

    @abc.abstractmethod
    def _mark(self) -> None:
        """Remember where an activity begins, for `_measured`."""

    def _measured(self) -> dict[str, float]:
        """Return facts about the present activity."""
        return {}

    # --------------------------------------------------------------------------------------- skills

    @property
    def start_s(self) -> float:
        """When the newest activity may begin to move, on this machine's clock."""
        return self._start_s

    @property
    def moving(self) -> bool:
        """True while `step` has something to do."""
        return self._recipe is not None or self._unsettled or self._in_motion()

    @property
    def holding(self) -> bool | None:
        """None: a machine on the ground keeps its place at rest."""
        return None

    def begin(
        self,
        skill: str,
        arguments: Mapping[str, Value],
        now_s: float,
        start_s: float | None = None,
    ) -> Activity:
        """Begin a skill; see `Machine.begin`."""
        self.step(now_s)
        if self.activity is not None and self.activity.running:
            raise ActivityRefused(self.id, said("busy with {skill}", skill=self.activity.skill))
        start = self._start(now_s, start_s)
        plan = self._plan(skill)
        if plan is None:
            raise ActivityRefused(self.id, said("has no skill {skill!r}", skill=skill[:40]))
        self._able()
        asked = MachineArguments(self.id, skill, arguments)
        recipe = plan(asked)
        try:
            asked.finish()
        except ActivityRefused:
            recipe.close()
            raise
        self._count += 1
        self._start_s = start
        self.activity = Activity(self._count, skill, start, stage="waiting")
        self.note = ""
        self._recipe = recipe
        self._unsettled = False
        self._mark()
        return self.activity

    def _start(self, now_s: float, start_s: float | None) -> float:
        if start_s is None:
            return now_s
        if not isfinite(start_s) or start_s > now_s + LONGEST_WAIT_S:
            raise ActivityRefused(
                self.id,
                said(
                    "a start may be at most {longest_wait_s:g} s ahead",
                    longest_wait_s=LONGEST_WAIT_S,
                ),
            )
        if start_s < now_s - TOO_LATE_S:
            raise ActivityRefused(self.id, said("heard of the common start too late"))
        return max(start_s, now_s)

    def halt(self, now_s: float) -> None:
        """Come to rest; see `Machine.halt`."""
        self._give_up(now_s, "")  # who asked for it knows why

    def link_lost(self, now_s: float) -> None:
        """Hold; see `Machine.link_lost`."""
        self._give_up(now_s, said("link lost, holding"))

    def cut_link(self, now_s: float) -> None:
        """Lose the link by a fault of its radio; what it says gets out no more."""
        self.link_lost(now_s)

    def mend_link(self, now_s: float) -> None:
        """Have the link again."""
        self.step(now_s)

    def _give_up(self, now_s: float, sentence: str) -> None:
        self.step(now_s)
        self._end(ActivityState.CANCELLED, sentence)
        self._brake()

    # ----------------------------------------------------------------------------------------- time

    def step(self, now_s: float) -> None:
        """Integrate up to ``now_s``; see `Machine.step`.

        Raises:
            ValueError: The time is not a finite number.
        """
        if not isfinite(now_s):
            raise ValueError("the time is not a finite number")
        now = self._now_s if self._now_s is not None else now_s
        while now < now_s:
            if not self.moving:
                self._idle(now_s - now)
                break
            end = min(now_s, now + SUBSTEP_S)
            if now < self._start_s < end:
                end = self._start_s
            self._now_s = now
            self._substep(end - now)
            now = end
        self._now_s = max(now, now_s)

    def _substep(self, dt_s: float) -> None:
        self._dt_s = dt_s
        self._watch()
        if self._recipe is not None and self._time_s >= self._start_s:
            self._resume(self._recipe)
        self._drive(dt_s)
        if self._unsettled and self._settled():
            self._unsettled = False
            self._note_facts()

    @property
    def _time_s(self) -> float:
        return self._now_s or 0.0

    def _resume(self, recipe: Recipe) -> None:
        try:
            next(recipe)
        except StopIteration as stop:
            self._end(ActivityState.DONE, stop.value or "")
        except ActivityFailed as failed:
            self._end(ActivityState.FAILED, failed.args[0])
            self._after_failure()

    def _end(self, state: ActivityState, detail: str) -> None:
        """Reach a final state of the activity, if one is running."""
        if self._recipe is not None:
            recipe, self._recipe = self._recipe, None
            recipe.close()
        activity = self.activity
        if activity is not None and activity.running:
            self._note_facts()
            activity.end(state, detail)
            self._unsettled = state is not ActivityState.DONE

    def _note_facts(self) -> None:
        activity = self.activity
        if activity is not None:
            activity.facts.update(self._measured())
            activity.facts["duration_s"] = max(0.0, self._time_s - activity.begun_s)

    def _stage(self, stage: str) -> None:
        if self.activity is not None:
            self.activity.enter(stage)

    def _advance(self, fraction: float) -> None:
        if self.activity is not None:
            self.activity.advance(fraction)
