"""A rule about alarms as it is followed: read once, with the units and the words of its robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.core.alerts.condition import (
    DEVIATES,
    OWN,
    Condition,
    ConditionNames,
    compile_condition,
    seconds,
)
from rosic.core.alerts.state import AlertTimes
from rosic.core.language import Do, LineContext, Vocabulary, bind, understand
from rosic.core.robot.alert_config import AlertConfig, RecipientCircle
from rosic.core.robot.benchmark import DEVIATION
from rosic.core.robot.profile import RobotId
from rosic.core.time_units import DAY_S
from rosic.errors import Refusal

if TYPE_CHECKING:
    from rosic.core.language import UnitTable
    from rosic.core.robot.profile import Profile

STOP, PAUSE, REALLOCATE = "stop", "pause", "reallocate"
# What a rule may do that is no skill of its robot.
ACTS = frozenset({STOP, PAUSE, REALLOCATE})
LONGEST_S = float(DAY_S)
ESCALATES_AFTER_S = 10.0
RUNS_EVERY_S = 10.0


OFF_BENCHMARK = AlertConfig(
    name="off_benchmark",
    when=DEVIATES,
    lasting="1 s",
    say="Off its benchmark",
    tell=RecipientCircle.HOLDER,
)


class AlertRule(msgspec.Struct, frozen=True, kw_only=True):
    """One rule of one robot.

    Attributes:
        alert: As the profile says it.
        run_every_ns: At least so long lies between two runs.
    """

    robot: RobotId
    alert: AlertConfig
    condition: Condition
    pace: AlertTimes
    run_every_ns: int

    @property
    def act(self) -> str:
        """What it does that is no skill of its robot: ``stop``, ``pause``, ``reallocate``."""
        said = self.alert.run.strip().casefold()
        return said if said in ACTS else ""

    @property
    def key(self) -> str:
        """What it is known by in the record."""
        return f"{self.robot}/{self.alert.name}"


class InvalidAlertRule(ValueError):
    """A rule that cannot be followed.

    Attributes:
        key: Of the profile, which is to blame.
    """

    def __init__(self, key: str, sentence: str) -> None:
        super().__init__(sentence)
        self.key = key


def compile_rule(profile: Profile, alert: AlertConfig, units: UnitTable) -> AlertRule:
    """Read a rule.

    Raises:
        InvalidAlertRule: What is wrong with it, as a sentence without its stop.
    """
    values = {name: described.unit for name, described in profile.telemetry.items()}
    if clashing := OWN & set(values):
        raise InvalidAlertRule(
            "when", f"a value may not be called {min(clashing)}, which rules know already"
        )
    if profile.benchmarked:
        values[DEVIATION] = ""
    try:
        condition = compile_condition(alert.when, alert.clear, ConditionNames(values, units))
    except ValueError as fault:
        key = "clear" if str(fault).startswith("clear") else "when"
        raise InvalidAlertRule(key, str(fault)) from fault
    escalate_s = _time("escalate_after", alert.escalate_after, units, ESCALATES_AFTER_S)
    return AlertRule(
        robot=profile.id,
        alert=alert,
        condition=condition,
        pace=AlertTimes(int(_time("for", alert.lasting, units, 0.0) * 1e9), int(escalate_s * 1e9)),
        run_every_ns=int(_time("run_every", alert.run_every, units, RUNS_EVERY_S) * 1e9),
    )


def rules_of(profile: Profile, units: UnitTable) -> list[AlertRule]:
    """Read every rule of a robot: those it states, and one for each ``alert_below``.

    A value that a rule of the profile is about already needs no other.

    Raises:
        InvalidAlertRule: The first thing that is wrong.
    """
    stated = [compile_rule(profile, alert, units) for alert in profile.alerts]
    about = {rule.condition.name for rule in stated if rule.condition.kind == "bounds"}
    names = {rule.alert.name for rule in stated}
    low = [
        compile_rule(profile, _low(name, described.alert_below, described.unit), units)
        for name, described in profile.telemetry.items()
        if described.alert_below is not None and name not in about and f"{name}_low" not in names
    ]
    if profile.benchmarked and not about_deviations(stated):
        low.append(compile_rule(profile, OFF_BENCHMARK, units))
    return stated + low


def about_deviations(rules: list[AlertRule]) -> bool:
    """Whether one of them is about benchmarks already, or has taken the name."""
    return any(
        rule.condition.name == DEVIATION or rule.alert.name == OFF_BENCHMARK.name for rule in rules
    )


def _low(name: str, limit: float, unit: str) -> AlertConfig:
    amount = f"{limit:.9f}".rstrip("0").rstrip(".")
    return AlertConfig(
        name=f"{name}_low",
        when=f"{name} < {amount} {unit}".strip(),
        lasting="10 s",
        clear="" if limit else f"{name} >= {amount} {unit}".strip(),
    )


def _time(key: str, said: str, units: UnitTable, least_s: float) -> float:
    """Read a length of time; nothing said is 0.

    Raises:
        InvalidAlertRule: It is none, or too short or too long to mean anything.
    """
    if not said:
        return 0.0
    try:
        found = seconds(said, units)
    except ValueError as fault:
        raise InvalidAlertRule(key, str(fault)) from fault
    if not least_s <= found <= LONGEST_S:
        raise InvalidAlertRule(key, f"{key} must be between {least_s:g} s and {LONGEST_S:g} s")
    return found


def read_run(rule: AlertRule, vocabulary: Vocabulary) -> Do | None:
    """Return what a rule runs, understood as if typed; None for what every robot can do.

    Raises:
        InvalidAlertRule: It is no single command of this robot, or a value is missing or out of
            bounds.
    """
    said = rule.alert.run
    if rule.act:
        return None
    context = LineContext(rule.robot, frozenset({rule.robot}))
    lines = understand(f"{rule.robot} {said}", vocabulary, context)
    if len(lines) != 1 or not isinstance(lines[0], Do) or lines[0].robots != (rule.robot,):
        raise InvalidAlertRule("run", f"{said!r} is not one thing that {rule.robot} can do")
    line = lines[0]
    try:
        bind(vocabulary, rule.robot, line.skills[0], line.spoken)
    except Refusal as refusal:
        raise InvalidAlertRule("run", str(refusal).rstrip(".")) from refusal
    return line
