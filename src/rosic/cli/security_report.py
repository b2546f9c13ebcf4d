"""``rosic security report``: who was turned away, who is locked, what ends soon."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where
from rosic.cli.desk import looked_up

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """How long authentication takes, unauthorised attempts by kind, locks, keys near their end
and open invitations. Times are measured by a running gateway."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic security report", description=ABOUT)
    parser.add_argument("--json", action="store_true", help="one object, with ids, no names")
    add_where(parser)
    options = parser.parse_args(arguments)
    ask = AdminRequest(AdminVerb.SECURITY, ("json",) if options.json else ())
    print("\n".join(looked_up(options, ask)))
    return 0
