"""``rosic people``: who is known."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.desk.asked import Ask, Verb
from rosic.app.desk.control import NotRunning
from rosic.cli.asking import add_where, ask, data_of

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Who is known, what they may until when, their addresses and id; and who waits to come in.
Works with and without a gateway."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs."""
    parser = argparse.ArgumentParser(prog="rosic people", description=ABOUT)
    add_where(parser)
    options = parser.parse_args(arguments)
    try:
        return ask(data_of(options), Ask(Verb.PEOPLE))
    except NotRunning:
        from rosic.cli import alone  # noqa: PLC0415 - a database, which a running gateway has open

        print("\n".join(alone.people(options)))
        return 0
