"""``rosic invite``: a code for one person, once."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where
from rosic.cli.desk import changed
from rosic.cli.people import show
from rosic.cli.spans import joined, seconds

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Make a code that lets one person in, once, from a private chat with the bot. Shown here
and kept nowhere. Works with and without a running gateway."""
EPILOG = "rosic invite --role operator --robot kuka1 --for 2h --limit 'speed <= 0.2 m/s'"
CODE_TTL = "10m"


def run(arguments: Sequence[str]) -> int:
    """Make an invitation.

    Raises:
        RosicError: What is wrong with it; nothing was done.
    """
    options = _parser().parse_args(joined(arguments, ("--for", "--code-ttl")))
    body = {
        "roles": options.role,
        "robots": options.robot,
        "limits": options.limit,
        "lasts_s": None if options.lasts is None else seconds("--for", options.lasts),
        "code_ttl_s": seconds("--code-ttl", options.code_ttl),
        "name": options.name,
        "confirm": options.confirm,
    }
    ask = AdminRequest(AdminVerb.INVITE, body=msgspec.Raw(msgspec.json.encode(body)))
    sentence, payload = changed(options, ask, robots=bool(options.robot or options.limit))
    show(sentence, payload, picture=not options.plain)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="rosic invite", description=ABOUT, epilog=EPILOG)
    add = parser.add_argument
    add("--role", action="append", default=[], metavar="ROLE", help="once or several times")
    add(
        "--robot",
        nargs="+",
        action="extend",
        default=[],
        metavar="ROBOT",
        help="only on these robots or groups",
    )
    add("--for", dest="lasts", metavar="TIME", help="how long the right lasts; left out: for good")
    add("--code-ttl", default=CODE_TTL, metavar="TIME", help=f"how long the code does ({CODE_TTL})")
    add("--limit", action="append", default=[], metavar="LIMIT", help="'speed <= 0.2 m/s'")
    add("--as", dest="name", default="", metavar="NAME", help="how they are shown")
    add("--confirm", action="store_true", help="an admin has to let them in by a tap")
    add("--plain", action="store_true", help="without the picture")
    add_where(parser)
    return parser
