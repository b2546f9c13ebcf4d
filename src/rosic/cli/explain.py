"""``rosic explain``: what somebody may, and every rule that made it so."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.explain import says_no
from rosic.cli.client import add_where
from rosic.cli.desk import looked_up

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Say what would be decided if somebody wrote this line in a private chat now, with every
rule that was asked; the exit status is 1 if the answer is no. Nothing is done. Without a running
gateway, nobody holds a robot."""


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs. Return 1 if the answer is no.

    Raises:
        RosicError: Nobody of that name, or the line asks nothing of a robot.
    """
    parser = argparse.ArgumentParser(prog="rosic explain", description=ABOUT)
    parser.add_argument("person", metavar="PERSON", help="as rosic people shows it, or the id")
    parser.add_argument("line", metavar="LINE", nargs="+", help='"kuka1 grasp force=30"')
    add_where(parser)
    options = parser.parse_args(arguments)
    ask = AdminRequest(AdminVerb.EXPLAIN, (options.person, " ".join(options.line)))
    texts = looked_up(options, ask, robots=True)
    print("\n\n".join(texts))
    return 1 if any(map(says_no, texts)) else 0
