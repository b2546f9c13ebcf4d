"""``rosic history``: who asked for what, when, and what came of it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.history import AT_MOST, HistoryParameters
from rosic.cli.client import add_where
from rosic.cli.desk import looked_up, printed
from rosic.cli.spans import joined, seconds

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Who asked for what, when, with which values, and what came of it: from the record, the
newest last. Works with and without a running gateway. It shows what people keep in their own
containers: use it for what has to be found out."""
NEWEST = 50


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic history", description=ABOUT)
    parser.add_argument("--robot", metavar="ROBOT", default="", help="what was asked of one robot")
    parser.add_argument("--person", metavar="NAME", default="", help="what one person asked for")
    parser.add_argument(
        "--since", metavar="TIME", help=f"all of the last 2h, 30min, 3d; else the newest {NEWEST}"
    )
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_where(parser)
    options = parser.parse_args(joined(arguments, ("--since",)))
    asked = HistoryParameters(
        robot=options.robot,
        person=options.person,
        since_s=None if options.since is None else seconds("--since", options.since),
        limit=NEWEST if options.since is None else AT_MOST,
        json=options.json,
    )
    request = AdminRequest(AdminVerb.HISTORY, body=msgspec.Raw(msgspec.json.encode(asked)))
    print(printed(looked_up(options, request, robots=bool(options.robot)), json=options.json))
    return 0
