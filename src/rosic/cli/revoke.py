"""``rosic revoke``: take somebody's access back."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where
from rosic.cli.desk import changed

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Take somebody's access back, for ever: the configuration file does not revive them.
Robots they hold come to rest. Works with and without a running gateway."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic revoke", description=ABOUT)
    parser.add_argument("name", metavar="NAME", help="as rosic people shows it, or the id")
    add_where(parser)
    options = parser.parse_args(arguments)
    print("\n".join(changed(options, AdminRequest(AdminVerb.REVOKE, (options.name,)))))
    return 0
