"""``rosic robot check``, ``add`` and ``discover``: profiles of robots."""

from __future__ import annotations

import argparse
import asyncio
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rosic.app.added_robots import AddRobotRequest
from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.control_client import NotRunning
from rosic.app.setup.discovery import LOOK_S, discover
from rosic.app.setup.neighbours import MIXED
from rosic.app.setup.profile_draft import GUESSED, NO_REST, UNJUDGED, UNSAID
from rosic.cli.client import add_where, ask, data_of
from rosic.config.plugins import check_robot, check_robot_kind, robot_factory
from rosic.config.profiles import (
    SUFFIXES,
    check_profile,
    find_profile,
    known_units,
    reached_in,
    read_profile,
)
from rosic.config.source_map import read_text
from rosic.config.yaml_source import parse_yaml, read_yaml
from rosic.errors import ConfigurationError, Fault
from rosic.gateway.robot_registry import ProfileDraft
from rosic.system import SystemClock

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic.core.robot.profile import Profile


# ---- ``rosic robot check`` ----

CHECK_ABOUT = "Say everything that is wrong with robots' profiles, with file, line and a hint."


def check(arguments: Sequence[str]) -> int:
    """Check. Return 0 if all are good, else 2."""
    parser = argparse.ArgumentParser(prog="rosic robot check", description=CHECK_ABOUT)
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


# ---- ``rosic robot add`` ----

ADD_ABOUT = """Add a robot to the running gateway, by its profile or by the name of a profile that
ships. It is there at once, for everybody whose rights reach it, and after every restart; nothing
that runs is disturbed. A profile with something wrong changes nothing."""


def add(arguments: Sequence[str]) -> int:
    """Add. Return 0 if the robot is there, 1 if the gateway refused, 2 if its profile is wrong.

    Raises:
        ConfigurationError: There is no such profile.
        Fault: No gateway runs; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic robot add", description=ADD_ABOUT)
    parser.add_argument("profile", metavar="PROFILE")
    parser.add_argument("--link", metavar="KIND", default="", help="reach it by this instead")
    parser.add_argument(
        "--role", default="", help="let it speak with the other robots, with the rights of a role"
    )
    add_where(parser)
    options = parser.parse_args(arguments)
    data, path = data_of(options), find_profile(options.profile, Path())
    errors = read_profile(path, known_units(), link=options.link).errors
    if errors:
        for error in errors:
            print(error, file=sys.stderr)
        return 2
    draft = ProfileDraft(text=read_text(path), name=path.name, link=options.link)
    body = msgspec.Raw(msgspec.json.encode(AddRobotRequest(draft, options.role)))
    try:
        return ask(data, AdminRequest(AdminVerb.ADD_ROBOT, body=body))
    except NotRunning as alone:
        sentence = f"{alone} Without one, name the robot in the configuration: [[robot]]"
        raise Fault(f'{sentence} profile = "{options.profile}".') from alone


# ---- ``rosic robot discover`` ----

DISCOVER_ABOUT = """Look at the live ROS 2 graph and write a draft profile for every robot seen
there: its stop, how rest is measured, telemetry, and its actions, services and velocity topic as
skills with careful bounds. Existing files are left alone, and robots that they reach."""


def discover_robots(arguments: Sequence[str]) -> int:
    """Discover. Return 1 if a file was in the way.

    Raises:
        ConfigurationError: ROS 2 is not here, or nobody is on the graph.
    """
    parser = argparse.ArgumentParser(prog="rosic robot discover", description=DISCOVER_ABOUT)
    parser.add_argument("-o", "--output", metavar="FOLDER", help="write files instead of printing")
    parser.add_argument(
        "--seconds", type=float, default=LOOK_S, help=f"how long to look ({LOOK_S:g})"
    )
    options = parser.parse_args(arguments)
    seconds = min(max(options.seconds, 0.1), 60.0)
    drafts = asyncio.run(discover(SystemClock(), seconds=seconds, skip=_skipped))
    if options.output is None:
        print("\n---\n".join(drafts.values()), end="")
        return 0
    return write_drafts(Path(options.output), drafts)


def write_drafts(folder: Path, drafts: Mapping[str, str]) -> int:
    """Write drafts, by robot, of robots that no profile in a folder reaches; 1 if one was not."""
    here = _reached_from(folder)
    return max([_write(folder / f"{name}.yaml", text, here) for name, text in drafts.items()])


def _skipped(name: str) -> None:
    print(
        f"Left out: {name}, where nothing takes velocities or goals, or shows odometry.",
        file=sys.stderr,
    )


def _reached_from(folder: Path) -> dict[str, Path]:
    """Return what robots answer to that a folder has profiles of, and which profile that is."""
    here: dict[str, Path] = {}
    for path in sorted(path for suffix in SUFFIXES for path in folder.glob(f"*{suffix}")):
        try:
            here |= dict.fromkeys(reached_in(read_yaml(path)), path)
        except ConfigurationError:
            continue  # `rosic robot check` says why
    return here


def _write(path: Path, text: str, here: Mapping[str, Path]) -> int:
    shared = sorted(reached_in(parse_yaml(text, path.name)) & here.keys())
    if shared and not path.exists():
        print(
            f"Not drafted again: {here[shared[0]]} reaches the robot {path.stem} already, "
            f"by {shared[0]}.",
            file=sys.stderr,
        )
        return 1
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        print(f"{path} exists already; it was left alone.", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"{path} cannot be written ({error.strerror}).", file=sys.stderr)
        return 1
    print(f"Written: {path}")
    told = (MIXED, NO_REST, UNJUDGED, GUESSED, UNSAID)
    notes = (line.removeprefix("# ") for line in text.splitlines() if line.startswith(told))
    for wrong in (*notes, *check_profile(path)):
        print(f"  look at: {wrong}")
    return 0
