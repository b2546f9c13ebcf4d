"""``rosic resume``: let stopped robots of the running gateway go on."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.dispatch import ALL
from rosic.cli.client import add_where, ask, data_of
from rosic.errors import OutOfBounds

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Let stopped robots of the running gateway go on; without a name, the one that is stopped.
Nothing moves by this alone. Look first: whoever stopped it had a reason."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway. Return 1 if there is none to ask, or if it says why not.

    Raises:
        OutOfBounds: All are meant, and some are named.
    """
    parser = argparse.ArgumentParser(prog="rosic resume", description=ABOUT)
    parser.add_argument("robots", metavar="ROBOT", nargs="*", help="a robot, or a group")
    parser.add_argument(ALL, action="store_true", dest="everything", help="every stopped one")
    add_where(parser)
    options = parser.parse_args(arguments)
    if options.everything and options.robots:
        raise OutOfBounds(f"Name robots, or say {ALL}.")
    names = (ALL,) if options.everything else tuple(options.robots)
    return ask(data_of(options), AdminRequest(AdminVerb.RESUME, names))
