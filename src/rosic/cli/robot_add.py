"""``rosic robot add``: one more robot for the gateway that runs, without a restart."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rosic.app.added_robots import AddRobotRequest, ProfileDraft
from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.control_client import NotRunning
from rosic.cli.client import add_where, ask, data_of
from rosic.config.profiles import find_profile, known_units, read_profile
from rosic.config.source_map import read_text
from rosic.errors import Fault

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Add a robot to the running gateway, by its profile or by the name of a profile that
ships. It is there at once, for everybody whose rights reach it, and after every restart; nothing
that runs is disturbed. A profile with something wrong changes nothing."""


def run(arguments: Sequence[str]) -> int:
    """Add. Return 0 if the robot is there, 1 if the gateway refused, 2 if its profile is wrong.

    Raises:
        ConfigurationError: There is no such profile.
        Fault: No gateway runs; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic robot add", description=ABOUT)
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
