"""``rosic key list``, ``create``, ``rotate`` and ``revoke``: who holds which key."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AS_JSON, NOTHING, AdminRequest, AdminVerb
from rosic.cli.client import add_where, changed, joined, looked_up, printed, seconds

if TYPE_CHECKING:
    from collections.abc import Sequence


# ---- ``rosic key list`` ----

LIST_ABOUT = (
    "Every authorisation key, or those of one person: whose it is, and how long it is good."
)


def list_keys(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic key list", description=LIST_ABOUT)
    parser.add_argument("name", metavar="NAME", nargs="?", help="one person's only")
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_where(parser)
    options = parser.parse_args(arguments)
    names = () if options.name is None else (options.name,)
    body = AS_JSON if options.json else NOTHING
    print(printed(looked_up(options, AdminRequest(AdminVerb.KEYS, names, body)), json=options.json))
    return 0


# ---- ``rosic key create`` ----

CREATE_ABOUT = """Make a program known, with an authorisation key of its own, and show its secret:
once. It may what its roles give, where you say, and never more; what wants a confirmation, a person
is asked. Works with and without a running gateway."""


def create(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic key create", description=CREATE_ABOUT)
    parser.add_argument("name", metavar="NAME", help="how people read it")
    parser.add_argument("--role", action="append", required=True, metavar="ROLE")
    parser.add_argument(
        "--robot",
        nargs="+",
        action="extend",
        default=[],
        metavar="ROBOT",
        help="only on these robots or groups",
    )
    parser.add_argument(
        "--limit", action="append", default=[], metavar="LIMIT", help="'speed <= 0.2 m/s'"
    )
    parser.add_argument(
        "--for", dest="lasts", metavar="TIME", help="how long the right lasts; left out: for good"
    )
    add_where(parser)
    options = parser.parse_args(joined(arguments, ("--for",)))
    wanted = {
        "name": options.name,
        "roles": options.role,
        "robots": options.robot,
        "limits": options.limit,
        "lasts_s": None if options.lasts is None else seconds("--for", options.lasts),
    }
    body = msgspec.Raw(msgspec.json.encode(wanted))
    ask = AdminRequest(AdminVerb.CREATE_KEY, (), body)
    print("\n".join(changed(options, ask, robots=bool(options.robot or options.limit))))
    return 0


# ---- ``rosic key rotate`` ----

ROTATE_ABOUT = """Give somebody a new authorisation key in place of the old one, with the same
bounds. They notice nothing. Works with and without a running gateway."""


def rotate(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic key rotate", description=ROTATE_ABOUT)
    parser.add_argument("name", metavar="NAME", help="as rosic people shows it, or the id")
    parser.add_argument("--grace", metavar="TIME", default="0s", help="the old one stays good")
    add_where(parser)
    options = parser.parse_args(joined(arguments, ("--grace",)))
    grace_s = seconds("--grace", options.grace, zero=True)
    body = msgspec.Raw(msgspec.json.encode({"grace_s": grace_s}))
    print("\n".join(changed(options, AdminRequest(AdminVerb.ROTATE, (options.name,), body))))
    return 0


# ---- ``rosic key revoke`` ----

REVOKE_ABOUT = """Take back one key by its id, or every key of a person; at once and for ever. Works
with and without a running gateway."""


def revoke(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic key revoke", description=REVOKE_ABOUT)
    parser.add_argument("name", metavar="NAME", help="a person, or the id of a key")
    add_where(parser)
    options = parser.parse_args(arguments)
    print("\n".join(changed(options, AdminRequest(AdminVerb.TAKE_KEY, (options.name,)))))
    return 0
