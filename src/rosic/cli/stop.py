"""``rosic stop``: stop robots of the running gateway."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where, ask, data_of

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Stop robots of the running gateway, at once; all of them if none is named, or if a name
is not known. They stay stopped until somebody who may resumes them in a chat, or: rosic resume."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway to stop. Return 1 if there is none to ask."""
    parser = argparse.ArgumentParser(prog="rosic stop", description=ABOUT)
    parser.add_argument("robots", metavar="ROBOT", nargs="*")
    add_where(parser)
    options = parser.parse_args(arguments)
    return ask(data_of(options), AdminRequest(AdminVerb.STOP, tuple(options.robots)))
