"""``rosic robot check``: everything that is wrong with profiles."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.config.plugins import check_robot, check_robot_kind, robot_factory
from rosic.config.profiles import known_units, read_profile
from rosic.config.yaml_source import read_yaml
from rosic.errors import ConfigurationError
from rosic.system import SystemClock

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.robot.profile import Profile

ABOUT = "Say everything that is wrong with robots' profiles, with file, line and a hint."


def run(arguments: Sequence[str]) -> int:
    """Check. Return 0 if all are good, else 2."""
    parser = argparse.ArgumentParser(prog="rosic robot check", description=ABOUT)
    parser.add_argument("files", metavar="FILE", nargs="+")
    options = parser.parse_args(arguments)
    units = known_units()
    wrong = 0
    for file in options.files:
        read = read_profile(file, units)
        errors = read.errors or _refused(file, read.profile)
        wrong += len(errors)
        for advice in read.advice:
            print(advice)
        for error in errors:
            print(error, file=sys.stderr)
        if read.profile is not None and not errors:
            skills = len(read.profile.skills)
            count = "1 skill" if skills == 1 else f"{skills} skills"
            print(f"{file} is good: {read.profile.shown}, {count}.")
    return 2 if wrong else 0


def _refused(file: str, profile: Profile | None) -> list[ConfigurationError]:
    """Say what a start would refuse of a profile that is good by itself."""
    if profile is None:
        return []
    where = read_yaml(Path(file)).where
    try:
        check_robot_kind(profile.link.kind)
    except ConfigurationError as wrong:
        return [ConfigurationError(str(wrong), where=where(("link", "kind")))]
    try:
        factory = robot_factory(profile.link.kind)
    except ConfigurationError:
        return []  # what it needs is not on this machine, and need not be
    return [
        ConfigurationError(fault.sentence, where=where(fault.place), hint=fault.hint)
        for fault in check_robot(profile, factory, SystemClock())
    ]
