"""``rosic people``: who is known."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from rosic.app.admin.api import AS_JSON, NOTHING, AdminRequest, AdminVerb
from rosic.app.admin.control_client import NotRunning
from rosic.cli.client import add_where, answers, data_of
from rosic.cli.desk import printed

if TYPE_CHECKING:
    from collections.abc import Sequence


# ---- ``rosic people`` ----

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
        request = AdminRequest(AdminVerb.PEOPLE, body=AS_JSON if options.json else NOTHING)
        found = answers(data_of(options), request)
    except NotRunning:
        from rosic.cli import client  # noqa: PLC0415 - a database, which a running gateway has open

        found = client.people(options, json=options.json)
    print(printed(found, json=options.json))
    return 0


# ---- showing a code ----


def show(sentence: str, payload: str, *, picture: bool = True) -> None:
    """Print a sentence, and what a camera reads.

    Args:
        sentence: Holds the code.
        payload: What the picture shows; empty: there is none.
        picture: False for a terminal that cannot draw, or a reader that is none.
    """
    print(sentence, flush=True)
    if payload and picture and _draws():
        from rosic.authoriser.invite_codes import qr_text  # noqa: PLC0415 - only for whoever wants a picture

        print(qr_text(payload), flush=True)


def _draws() -> bool:
    """Whether the terminal's letters include blocks."""
    try:
        "\u2588\u2580\u2584".encode(sys.stdout.encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    return True
