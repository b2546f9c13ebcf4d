"""``rosic key revoke``: take one key back, or all of a person's."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where
from rosic.cli.desk import changed

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Take back one key by its id, or every key of a person; at once and for ever. Works with
and without a running gateway."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic key revoke", description=ABOUT)
    parser.add_argument("name", metavar="NAME", help="a person, or the id of a key")
    add_where(parser)
    options = parser.parse_args(arguments)
    print("\n".join(changed(options, AdminRequest(AdminVerb.TAKE_KEY, (options.name,)))))
    return 0
