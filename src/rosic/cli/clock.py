"""``rosic clock``: whether the machine's clock was set back, and that it is right now."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where
from rosic.cli.desk import changed

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Say whether the clock of this machine is behind the latest time that was seen here. A
clock that was set back revives nothing: no key, no right, no code, no time with a robot. Works with
and without a running gateway."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic clock", description=ABOUT)
    parser.add_argument(
        "--accept", action="store_true", help="the clock was wrong before and is right now"
    )
    add_where(parser)
    options = parser.parse_args(arguments)
    names = ("accept",) if options.accept else ()
    print("\n".join(changed(options, AdminRequest(AdminVerb.CLOCK, names))))
    return 0
