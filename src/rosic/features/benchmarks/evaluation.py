"""Follows robots against their benchmarks: what is late now, and what the last task was like."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from rosic.core.order import Ending, Order
from rosic.core.robot.benchmark import (
    DEVIATION,
    FINE,
    Benchmark,
    BenchmarkKind,
    BenchmarkMeasurement,
    Deviation,
    judge,
)
from rosic.core.robot.skill import SkillClass
from rosic.features.benchmarks import commands as words

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.core.order import Outcome
    from rosic.core.robot.profile import Presence, Profile, RobotId
    from rosic.features.benchmarks.settings import BenchmarkSettings
    from rosic.gateway.order_execution import OrderExecutor, OrderWatcher
    from rosic.linker.linker import Linker

log = logging.getLogger("rosic.benchmarks")
_NS = 1_000_000_000


class BenchmarkedAttempt(msgspec.Struct, frozen=True):
    """A task under way that has a benchmark; the moment is on the monotonic clock."""

    order: Order
    benchmark: Benchmark
    begun_ns: int
    charge: float | None


class BenchmarkVerdict(msgspec.Struct, frozen=True):
    """How a task was that came to its end.

    Attributes:
        skill: As people read it.
        expected_s: None if nothing is expected.
    """

    skill: str
    took_s: float
    expected_s: float | None
    used: float | None
    deviations: tuple[Deviation, ...]


class BenchmarkEvaluation:
    """Hears of orders as `OrderExecutor` lets them live; one without a benchmark costs one look.

    Attributes:
        verdicts: The last of each robot and skill that was done.
        settings: Remembers how robots are set.
    """

    def __init__(
        self,
        linker: Linker,
        profiles: Mapping[RobotId, Profile],
        clock: Clock,
        settings: BenchmarkSettings,
    ) -> None:
        self.verdicts: dict[RobotId, dict[str, BenchmarkVerdict]] = {}
        self.settings = settings
        self._linker = linker
        self._profiles = profiles
        self._clock = clock
        self._attempts: dict[RobotId, BenchmarkedAttempt] = {}
        self._last: dict[RobotId, BenchmarkVerdict] = {}
        self._benched: set[RobotId] = set()
        self._show: Callable[[], None] = _nowhere

    def enlist(self, profile: Profile) -> None:
        """Hold a robot against its benchmarks, if it has any."""
        if profile.benchmarked:
            self._benched.add(profile.id)
            self._show()

    def show_with(self, show: Callable[[], None]) -> None:
        """Say what lets verdicts be seen, as soon as there can be any; it may be called again."""
        self._show = show
        if self._benched:
            show()

    # ---- what Lives tells ----

    def began(self, order: Order) -> None:
        """Begin to measure."""
        benchmark = order.skill.benchmark
        if benchmark is None:
            return
        begun_ns = max(self._clock.monotonic_ns(), order.start_ns or 0)
        presence = self._presence(order.robot)
        charge = None if presence is None else _number(presence, benchmark.battery)
        self._attempts[order.robot] = BenchmarkedAttempt(order, benchmark, begun_ns, charge)

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Judge what was done; what was cut short or failed says nothing of a benchmark."""
        attempt = self._attempts.pop(order.robot, None)
        if outcome.ending is not Ending.DONE:
            return
        if order.skill.kind is SkillClass.CONFIG:
            # Set anew, or calibrated: what it did before says nothing of what it will do.
            self._last.pop(order.robot, None)
            self.settings.done(order)
        if attempt is not None and attempt.order.cid == order.cid:
            self._judge(attempt, outcome)

    def _judge(self, attempt: BenchmarkedAttempt, outcome: Outcome) -> None:
        order, benchmark = attempt.order, attempt.benchmark
        presence = self._presence(order.robot)
        charge = None if presence is None else _number(presence, benchmark.battery)
        both = attempt.charge is not None and charge is not None
        measured = BenchmarkMeasurement(
            took_s=max(0, self._clock.monotonic_ns() - attempt.begun_ns) / _NS,
            used=max(0.0, attempt.charge - charge) if both else None,  # type: ignore[operator]
            facts=outcome.facts,
            pose=None if presence is None else presence.pose,
        )
        telemetry = self._profiles[order.robot].telemetry.get(benchmark.battery)
        unit = "" if telemetry is None else telemetry.unit
        found = judge(benchmark, order.arguments, measured, _wanted(order), unit)
        skill = order.skill
        verdict = BenchmarkVerdict(
            skill.shown, measured.took_s,
            benchmark.expected_s(order.arguments), measured.used, found,
        )  # fmt: skip
        self._last[order.robot] = verdict
        self.verdicts.setdefault(order.robot, {})[skill.id] = verdict

    # ---- what others ask ----

    def seen(self, robot: RobotId, presence: Presence) -> Presence:
        """Return what a robot reports, and how it does: ``none``, ``late``, ``energy``, ``error``.

        A robot without benchmarks reports as it did.
        """
        if robot not in self._benched:
            return presence
        kinds = [one.kind.value for one in self.deviations(robot)]
        values = presence.values | {DEVIATION: kinds[0] if kinds else FINE}
        return replace(presence, values=values)

    def deviations(self, robot: RobotId) -> tuple[Deviation, ...]:
        """Return what is not as expected: a task that is late now, else the last that was done."""
        attempt = self._attempts.get(robot)
        if attempt is not None:
            expected_s = attempt.benchmark.expected_s(attempt.order.arguments)
            gone_s = (self._clock.monotonic_ns() - attempt.begun_ns) / _NS
            if expected_s is not None and gone_s > expected_s * attempt.benchmark.late:
                bound_s = expected_s * attempt.benchmark.late
                return (Deviation(BenchmarkKind.LATE, gone_s, bound_s, "s"),)
        last = self._last.get(robot)
        return () if last is None else last.deviations

    def line(self, robot: RobotId) -> str:
        """Return what a card says of it: what is expected, or what is not as expected."""
        attempt, last = self._attempts.get(robot), self._last.get(robot)
        found = self.deviations(robot)
        if attempt is not None:
            expected_s = attempt.benchmark.expected_s(attempt.order.arguments)
            late = any(one.kind is BenchmarkKind.LATE for one in found) and expected_s is not None
            return words.late(expected_s or 0.0) if late else words.expected(expected_s)
        if last is None or not found:
            return ""
        return words.off(last.skill, found)

    def _presence(self, robot: RobotId) -> Presence | None:
        try:
            return self._linker.presence(robot)
        except Exception:
            log.exception("%s could not be measured", robot)
            return None


class BothWatchers:
    """Lets two follow what robots do."""

    def __init__(self, one: OrderWatcher, other: OrderWatcher) -> None:
        self.both = (one, other)

    def began(self, order: Order) -> None:
        """Tell both."""
        for watcher in self.both:
            watcher.began(order)

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Tell both."""
        for watcher in self.both:
            watcher.ended(order, outcome)


def _nowhere() -> None:
    return None


def follow(lives: OrderExecutor, watcher: OrderWatcher) -> None:
    """Let somebody follow what robots do; whoever does so already is not told twice."""
    there = lives.watch
    if there is watcher or (isinstance(there, BothWatchers) and watcher in there.both):
        return
    lives.watch = watcher if there is None else BothWatchers(there, watcher)


def _number(presence: Presence, name: str) -> float | None:
    found = presence.values.get(name)
    return float(found) if isinstance(found, (int, float)) else None


def _wanted(order: Order) -> dict[str, float]:
    """Return what was asked for, by the name of the error bound."""
    benchmark = order.skill.benchmark
    found: dict[str, float] = {}
    for name, bound in (benchmark.errors if benchmark is not None else {}).items():
        value: object = bound.wanted
        if isinstance(value, str):
            parameter, dot, part = value[1:].partition(".")
            value = order.arguments.get(parameter)
            if dot:
                value = order.skill.parameters[parameter].means.get(str(value), {}).get(part)
        if isinstance(value, (int, float)):
            found[name] = float(value)
    return found
