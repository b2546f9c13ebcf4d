"""``rosic container show``: how much of what one container holds."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where
from rosic.cli.desk import looked_up
from rosic.features.personal_data.operator_view import ShownContainer, shown

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """How much of what one container holds, and what it may keep. Works with and without a
running gateway."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic container show", description=ABOUT)
    parser.add_argument("name", metavar="NAME", help="a robot, a person, or an id of the list")
    parser.add_argument("--json", action="store_true", help="one object, for programs")
    add_where(parser)
    options = parser.parse_args(arguments)
    [text] = looked_up(options, AdminRequest(AdminVerb.CONTAINER, (options.name,)), robots=True)
    print(text if options.json else shown(msgspec.json.decode(text, type=ShownContainer)))
    return 0
