"""Rules about alarms in a profile: the good ones are read, the others are said, by line."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.app.config import read_config
from rosic.app.features import command_table
from rosic.config.json_schema import robot_schema
from rosic.config.profiles import check_profile, known_units, load_profile
from rosic.config.yaml_source import read_yaml
from rosic.core.alerts.rule import compile_rule, read_run, rules_of
from rosic.core.language import Vocabulary
from rosic.core.robot.alert_config import RecipientCircle, Severity
from tests.config.profile_text import GOOD, MARK, SHIPPED_KINDS, marked_line, spoil, write
from tests.config.test_schema import validator

if TYPE_CHECKING:
    from pathlib import Path

ALERTS = (
    GOOD
    + """\
alerts:
  - name: battery_low
    when: "battery < 20 %"
    for: 10 s
    clear: "battery > 25 %"
    say: Battery is low
    severity: critical
    tell: holder
    escalate_after: 2 min
    run: move back 0.5 m
    as: Ada
    run_every: 1 h
  - { name: gone, when: offline }
"""
)


def test_a_good_rule_is_read(tmp_path: Path) -> None:
    profile = load_profile(write(tmp_path, ALERTS))
    low, gone = profile.alerts
    assert (low.severity, low.tell, low.author) == (
        Severity.CRITICAL,
        RecipientCircle.HOLDER,
        "Ada",
    )
    assert (gone.severity, gone.tell, gone.run) == (Severity.WARNING, RecipientCircle.OPERATORS, "")
    rule = compile_rule(profile, low, known_units())
    assert (rule.key, rule.run_every_ns) == ("rover/battery_low", 3600 * 10**9)
    assert (rule.pace.lasting_ns, rule.pace.escalate_ns) == (10 * 10**9, 120 * 10**9)
    line = read_run(rule, Vocabulary.build([profile], known_units(), command_table()))
    assert line is not None
    assert line.skills[0].id == "move"


def test_alert_below_is_a_rule_unless_another_is_about_the_same_value(tmp_path: Path) -> None:
    [low] = rules_of(load_profile(write(tmp_path, GOOD)), known_units())
    assert (low.alert.name, low.alert.when) == ("battery_low", "battery < 20 %")
    stated = rules_of(load_profile(write(tmp_path, ALERTS)), known_units())
    assert [rule.alert.name for rule in stated] == ["battery_low", "gone"]
    zero = spoil("alert_below: 20", "alert_below: 0", GOOD)
    [at_zero] = rules_of(load_profile(write(tmp_path, zero)), known_units())
    assert at_zero.condition.clear.low == 0


def test_the_schema_knows_it(tmp_path: Path) -> None:
    fits = validator(robot_schema(SHIPPED_KINDS))
    assert list(fits.iter_errors(read_yaml(write(tmp_path, ALERTS)).data)) == []
    for old, new in (("for: 10 s", "for: long"), ("critical", "dire"), ("gone", "Gone Away")):
        data = read_yaml(write(tmp_path, spoil(old, new, ALERTS))).data
        assert list(fits.iter_errors(data)), new


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('when: "battery < 20 %"', 'when: "batery < 20 %" #!', "'batery' is not a value this rob"),
        ('when: "battery < 20 %"', 'when: "battery < 20 m" #!', "'m' is no unit of battery"),
        ('clear: "battery > 25 %"', 'clear: "battery > 5 %" #!', "Clear must lie on the good s"),
        ("for: 10 s", "for: 10 m #!", "'10 m' is not a length of time"),
        ("for: 10 s", "for: a while #!", "'a while' is not a length of time."),
        ("escalate_after: 2 min", "escalate_after: 1 s #!", "Escalate_after must be between 10"),
        ("run: move back 0.5 m", "run: jump #!", "'jump' is not one thing that rover can do"),
        ("run: move back 0.5 m", "run: move back 50 m #!", ""),
        ("run: move back 0.5 m", "run: move back #!", ""),
        ("run: move back 0.5 m", "run: /grant Bo admin #!", "'/grant Bo admin' is not one thing"),
        ("    as: Ada\n", "", "Run and as belong together"),
        ("tell: holder", "tell: everyone #!", "'tell' must be one of holder, operators, admins."),
        ("name: gone,", "name: battery_low, #!\n     ", "Two rules are called 'battery_low'."),
        ("  battery:\n    topic", "  offline:\n    topic", "A value may not be called offline"),
    ],
)
def test_a_rule_that_cannot_be_followed_is_said(
    old: str, new: str, sentence: str, tmp_path: Path
) -> None:
    text = spoil(old, new, ALERTS)
    path = write(tmp_path, text)
    errors = check_profile(path)
    assert errors
    assert any(sentence in str(error) for error in errors), errors
    if MARK in text:
        assert {error.where for error in errors} == {f"{path}:{marked_line(text)}"}


def test_a_stop_may_be_run(tmp_path: Path) -> None:
    text = spoil("run: move back 0.5 m", "run: stop", ALERTS)
    assert check_profile(write(tmp_path, text)) == []


def test_a_rule_runs_only_as_somebody_whom_the_configuration_names(tmp_path: Path) -> None:
    write(tmp_path, ALERTS)
    for name, wrong in (("Ada", False), ("Bo", True)):
        config = tmp_path / "rosic.toml"
        config.write_text(
            '[[messenger]]\nkind = "terminal"\n'
            '[[robot]]\nprofile = "rover.yaml"\nlink = "simulated"\n'
            f'[[principal]]\nname = "{name}"\naddress = "terminal:me"\nrole = "admin"\n'
        )
        said = " ".join(map(str, read_config(config).errors))
        assert ("The rule 'battery_low' of rover runs as Ada, and nobody" in said) is wrong, said
        assert bool(said) is wrong
