"""``rosic key rotate``: a new key in place of somebody's old one."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where
from rosic.cli.desk import changed
from rosic.cli.spans import joined, seconds

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Give somebody a new authorisation key in place of the old one, with the same bounds. They
notice nothing. Works with and without a running gateway."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic key rotate", description=ABOUT)
    parser.add_argument("name", metavar="NAME", help="as rosic people shows it, or the id")
    parser.add_argument("--grace", metavar="TIME", default="0s", help="the old one stays good")
    add_where(parser)
    options = parser.parse_args(joined(arguments, ("--grace",)))
    grace_s = seconds("--grace", options.grace, zero=True)
    body = msgspec.Raw(msgspec.json.encode({"grace_s": grace_s}))
    print("\n".join(changed(options, AdminRequest(AdminVerb.ROTATE, (options.name,), body))))
    return 0
