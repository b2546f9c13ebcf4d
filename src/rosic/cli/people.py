"""``rosic people``: who is known."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.admin.asked import AS_JSON, NOTHING, Ask, Verb
from rosic.app.admin.control_client import NotRunning
from rosic.cli.client import add_where, answers, data_of
from rosic.cli.desk import printed

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Who is known, what they may until when, their addresses and id; and who waits to come in.
Works with and without a gateway."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic people", description=ABOUT)
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_where(parser)
    options = parser.parse_args(arguments)
    try:
        request = Ask(Verb.PEOPLE, body=AS_JSON if options.json else NOTHING)
        found = answers(data_of(options), request)
    except NotRunning:
        from rosic.cli import alone  # noqa: PLC0415 - a database, which a running gateway has open

        found = alone.people(options, json=options.json)
    print(printed(found, json=options.json))
    return 0
