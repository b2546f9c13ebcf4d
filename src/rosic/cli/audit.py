"""``rosic explain``, ``history`` and ``security report``: what was decided, and why."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.explain import says_no
from rosic.app.admin.history import AT_MOST, HistoryParameters
from rosic.cli.client import add_where, joined, looked_up, printed, seconds

if TYPE_CHECKING:
    from collections.abc import Sequence


# ---- ``rosic explain`` ----

EXPLAIN_ABOUT = """Say what would be decided if somebody wrote this line in a private chat now, with
every rule that was asked; the exit status is 1 if the answer is no. Nothing is done. Without a
running gateway, nobody holds a robot."""


def explain(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs. Return 1 if the answer is no.

    Raises:
        RosicError: Nobody of that name, or the line asks nothing of a robot.
    """
    parser = argparse.ArgumentParser(prog="rosic explain", description=EXPLAIN_ABOUT)
    parser.add_argument("person", metavar="PERSON", help="as rosic people shows it, or the id")
    parser.add_argument("line", metavar="LINE", nargs="+", help='"kuka1 grasp force=30"')
    add_where(parser)
    options = parser.parse_args(arguments)
    ask = AdminRequest(AdminVerb.EXPLAIN, (options.person, " ".join(options.line)))
    texts = looked_up(options, ask, robots=True)
    print("\n\n".join(texts))
    return 1 if any(map(says_no, texts)) else 0


# ---- ``rosic history`` ----

HISTORY_ABOUT = """Who asked for what, when, with which values, and what came of it: from the
record, the newest last. Works with and without a running gateway. It shows what people keep in
their own containers: use it for what has to be found out."""
NEWEST = 50


def history(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic history", description=HISTORY_ABOUT)
    parser.add_argument("--robot", metavar="ROBOT", default="", help="what was asked of one robot")
    parser.add_argument("--person", metavar="NAME", default="", help="what one person asked for")
    parser.add_argument(
        "--since", metavar="TIME", help=f"all of the last 2h, 30min, 3d; else the newest {NEWEST}"
    )
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_where(parser)
    options = parser.parse_args(joined(arguments, ("--since",)))
    asked = HistoryParameters(
        robot=options.robot,
        person=options.person,
        since_s=None if options.since is None else seconds("--since", options.since),
        limit=NEWEST if options.since is None else AT_MOST,
        json=options.json,
    )
    request = AdminRequest(AdminVerb.HISTORY, body=msgspec.Raw(msgspec.json.encode(asked)))
    print(printed(looked_up(options, request, robots=bool(options.robot)), json=options.json))
    return 0


# ---- ``rosic security report`` ----

SECURITY_ABOUT = """How long authentication takes, unauthorised attempts by kind, locks, keys near
their end and open invitations. Times are measured by a running gateway."""


def security_report(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic security report", description=SECURITY_ABOUT)
    parser.add_argument("--json", action="store_true", help="one object, with ids, no names")
    add_where(parser)
    options = parser.parse_args(arguments)
    ask = AdminRequest(AdminVerb.SECURITY, ("json",) if options.json else ())
    print("\n".join(looked_up(options, ask)))
    return 0
