"""``rosic status``: how the robots of the running gateway are."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.admin.api import AS_JSON, NOTHING, AdminRequest, AdminVerb
from rosic.cli.client import add_where, ask, data_of

if TYPE_CHECKING:
    from collections.abc import Sequence


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway."""
    parser = argparse.ArgumentParser(
        prog="rosic status", description="How the robots of the running gateway are."
    )
    parser.add_argument("robots", metavar="ROBOT", nargs="*")
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_where(parser)
    options = parser.parse_args(arguments)
    body = AS_JSON if options.json else NOTHING
    return ask(data_of(options), AdminRequest(AdminVerb.STATUS, tuple(options.robots), body))
