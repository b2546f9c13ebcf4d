"""``rosic container erase``: what was kept becomes unreadable, for good."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where
from rosic.cli.desk import changed
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Erase a container for good, by its key. With a person's goes every right of theirs: what
they move comes to rest first. Ids and numbers stay in the record of decisions. Needs a running
gateway."""


def run(arguments: Sequence[str]) -> int:
    """Ask once, then ask the gateway.

    Raises:
        RosicError: Why not; nothing was erased, unless the sentence says so.
    """
    parser = argparse.ArgumentParser(prog="rosic container erase", description=ABOUT)
    parser.add_argument("name", metavar="NAME", help="a robot, a person, or an id of the list")
    parser.add_argument("--yes", action="store_true", help="do not ask whether it is meant")
    add_where(parser)
    options = parser.parse_args(arguments)
    if not options.yes and not _meant(options.name):
        raise ConfigurationError(
            "Nothing was erased.", hint=f"rosic container erase {options.name} --yes does not ask."
        )
    print("\n".join(changed(options, AdminRequest(AdminVerb.ERASE, (options.name,)), robots=True)))
    return 0


def _meant(name: str) -> bool:
    """Ask somebody at a terminal to write the name once more."""
    if not sys.stdin.isatty():
        return False
    try:
        return input(f"Erase everything of {name}, for good? Write the name again: ") == name
    except EOFError:
        print()
        return False
