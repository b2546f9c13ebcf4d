"""``rosic container list``: every container."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where
from rosic.cli.desk import looked_up
from rosic.features.personal_data.operator_view import ListedContainer, table

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Every container: robots', people's, and those of chats whose messages are kept. Works
with and without a running gateway."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic container list", description=ABOUT)
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_where(parser)
    options = parser.parse_args(arguments)
    answers = looked_up(options, AdminRequest(AdminVerb.CONTAINERS), robots=True)
    found = [
        one for text in answers for one in msgspec.json.decode(text, type=list[ListedContainer])
    ]
    print(msgspec.json.encode(found).decode() if options.json else table(found))
    return 0
