"""``rosic people``, ``invite``, ``lock``, ``unlock``, ``revoke``: who is known here."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AS_JSON, NOTHING, AdminRequest, AdminVerb
from rosic.app.admin.control_client import NotRunning
from rosic.cli.client import (
    add_where,
    answers,
    changed,
    data_of,
    joined,
    people_offline,
    printed,
    seconds,
)

if TYPE_CHECKING:
    from collections.abc import Sequence


# ---- ``rosic people`` ----

PEOPLE_ABOUT = """Who is known, what they may until when, their addresses and id; and who waits to
come in. Works with and without a gateway."""


def people(arguments: Sequence[str]) -> int:
    """Ask the gateway, or read its data when none runs.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic people", description=PEOPLE_ABOUT)
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_where(parser)
    options = parser.parse_args(arguments)
    try:
        request = AdminRequest(AdminVerb.PEOPLE, body=AS_JSON if options.json else NOTHING)
        found = answers(data_of(options), request)
    except NotRunning:
        found = people_offline(options, json=options.json)
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


# ---- ``rosic invite`` ----

INVITE_ABOUT = """Make a code that lets one person in, once, from a private chat with the bot. Shown
here and kept nowhere. Works with and without a running gateway."""
EPILOG = "rosic invite --role operator --robot kuka1 --for 2h --limit 'speed <= 0.2 m/s'"
CODE_TTL = "10m"


def invite(arguments: Sequence[str]) -> int:
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
    parser = argparse.ArgumentParser(prog="rosic invite", description=INVITE_ABOUT, epilog=EPILOG)
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


# ---- ``rosic lock`` ----

LOCK_ABOUT = """Lock somebody out at once: what they move stops, and nothing they send is carried
out until somebody unlocks them. Works with and without a running gateway."""


def lock(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic lock", description=LOCK_ABOUT)
    parser.add_argument("name", metavar="NAME", help="as rosic people shows it, or the id")
    add_where(parser)
    options = parser.parse_args(arguments)
    print("\n".join(changed(options, AdminRequest(AdminVerb.LOCK, (options.name,)))))
    return 0


# ---- ``rosic unlock`` ----

UNLOCK_ABOUT = (
    """Give a locked person their access back. Works with and without a running gateway."""
)


def unlock(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic unlock", description=UNLOCK_ABOUT)
    parser.add_argument("name", metavar="NAME", help="as rosic people shows it, or the id")
    add_where(parser)
    options = parser.parse_args(arguments)
    print("\n".join(changed(options, AdminRequest(AdminVerb.UNLOCK, (options.name,)))))
    return 0


# ---- ``rosic revoke`` ----

REVOKE_ABOUT = """Take somebody's access back, for ever: the configuration file does not revive
them. Robots they hold come to rest. Works with and without a running gateway."""


def revoke(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic revoke", description=REVOKE_ABOUT)
    parser.add_argument("name", metavar="NAME", help="as rosic people shows it, or the id")
    add_where(parser)
    options = parser.parse_args(arguments)
    print("\n".join(changed(options, AdminRequest(AdminVerb.REVOKE, (options.name,)))))
    return 0
