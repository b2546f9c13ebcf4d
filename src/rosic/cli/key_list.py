"""``rosic key list``: every key, and how long it is good."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.admin.api import AS_JSON, NOTHING, AdminRequest, AdminVerb
from rosic.cli.client import add_where
from rosic.cli.desk import looked_up, printed

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = "Every authorisation key, or those of one person: whose it is, and how long it is good."


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic key list", description=ABOUT)
    parser.add_argument("name", metavar="NAME", nargs="?", help="one person's only")
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_where(parser)
    options = parser.parse_args(arguments)
    names = () if options.name is None else (options.name,)
    body = AS_JSON if options.json else NOTHING
    print(printed(looked_up(options, AdminRequest(AdminVerb.KEYS, names, body)), json=options.json))
    return 0
