"""``rosic revoke``: take somebody's access back."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.control import Ask, NotRunning, Verb
from rosic.cli.asking import add_where, ask, data_of

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Take somebody's access back, for ever: the configuration file does not revive them.
Robots they hold come to rest. Works with and without a running gateway."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs."""
    parser = argparse.ArgumentParser(prog="rosic revoke", description=ABOUT)
    parser.add_argument("name", metavar="NAME", help="as rosic people shows it, or the id")
    add_where(parser)
    options = parser.parse_args(arguments)
    try:
        return ask(data_of(options), Ask(Verb.REVOKE, (options.name,)))
    except NotRunning:
        from rosic.cli import alone  # noqa: PLC0415 - a database, which a running gateway has open

        print(alone.revoke(options))
        return 0
