"""Follows robots against their benchmarks: what is late now, and what the last task was like."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import msgspec
from msgspec.structs import replace

from rosic.core.identity import PrincipalId
from rosic.core.order import Order, OrderEnding
from rosic.core.records import Fact
from rosic.core.robot.benchmark import (
    DEVIATION,
    FINE,
    Benchmark,
    BenchmarkKind,
    BenchmarkMeasurement,
    BenchmarkVerdict,
    Deviation,
    judge,
)
from rosic.core.robot.skill import SkillClass
from rosic.core.time_units import SECOND_NS
from rosic.features.benchmarks import messages as words
from rosic.gateway.transactions import WriteBehind

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.core.order import Outcome
    from rosic.core.robot.profile import Presence, Profile, RobotId
    from rosic.gateway.transactions import Transactions
    from rosic.linker.linker import Linker

log = logging.getLogger("rosic.benchmarks")


class BenchmarkedAttempt(msgspec.Struct, frozen=True):
    """A task under way that has a benchmark; the moment is on the monotonic clock."""

    order: Order
    benchmark: Benchmark
    begun_ns: int
    charge: float | None


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

    def add_robot(self, profile: Profile) -> bool:
        """Know one more robot. Return whether its orders are to be followed.

        They are if it has benchmarks or can be set.
        """
        if profile.benchmarked:
            self._benched.add(profile.id)
        skills = profile.skills.values()
        return any(s.benchmark is not None or s.kind is SkillClass.CONFIG for s in skills)

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
        if outcome.ending is not OrderEnding.DONE:
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
            took_s=max(0, self._clock.monotonic_ns() - attempt.begun_ns) / SECOND_NS,
            used=max(0.0, attempt.charge - charge) if both else None,  # type: ignore[operator]
            facts=outcome.facts,
            pose=None if presence is None else presence.pose,
        )
        telemetry = self._profiles[order.robot].telemetry.get(benchmark.battery)
        unit = "" if telemetry is None else telemetry.unit
        found = judge(benchmark, order.arguments, measured, _wanted(order), unit)
        skill = order.skill
        verdict = BenchmarkVerdict(
            skill.shown,
            measured.took_s,
            benchmark.expected_s(order.arguments),
            measured.used,
            found,
        )
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
            gone_s = (self._clock.monotonic_ns() - attempt.begun_ns) / SECOND_NS
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


# ---- robots' settings ----

SETTING: Final = "robot-setting"
MOST_OF_ONE: Final = 256


class BenchmarkSetting(msgspec.Struct, frozen=True, array_like=True):
    """One parameter as a robot's node last confirmed it.

    Attributes:
        by: Who had it set.
        at_ns: Wall clock.
    """

    value: float | int | str | bool
    by: PrincipalId
    at_ns: int


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(dict[str, BenchmarkSetting]).decode


class BenchmarkSettings:
    """The configuration of each robot, as far as it was set from here: the paper's ``config``.

    A setting counts once the robot's node has taken it and it was read back.

    Attributes:
        of: Robot to parameter to its setting.
    """

    def __init__(self, changes: Transactions, wall_ns: Callable[[], int]) -> None:
        self.of: dict[RobotId, dict[str, BenchmarkSetting]] = {}
        self._wall_ns = wall_ns
        self._behind = WriteBehind(changes)

    def done(self, order: Order) -> None:
        """A skill that sets a robot was done: merge what it set into what is known."""
        given = order.skill.sets(order.arguments)
        at_ns, by = self._wall_ns(), order.permit.principal
        merged = self.of.get(order.robot, {}) | {
            name: BenchmarkSetting(value, by, at_ns) for name, value in given.items()
        }
        kept = dict(list(merged.items())[-MOST_OF_ONE:])
        self.write(Fact(kind=SETTING, key=order.robot, body=_encode(kept)))

    def write(self, fact: Fact) -> None:
        """Let it be so, and write it down: the robot is set already."""
        self.apply(fact)
        self._behind.write((fact,))

    async def written(self) -> None:
        """Wait until everything is written, or noted for later."""
        await self._behind.written()

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. One that cannot be read is left out, so that others count."""
        if not fact.body:
            self.of.pop(fact.key, None)
            return
        try:
            self.of[fact.key] = _decode(fact.body)
        except msgspec.MsgspecError:
            log.warning("how %s is set cannot be read", fact.key)
