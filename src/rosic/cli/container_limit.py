"""``rosic container limit``: what one container may keep."""

from __future__ import annotations

import argparse
import re
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.cli.client import add_where
from rosic.cli.desk import changed
from rosic.errors import OutOfBounds

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Say how much shared data one container may keep, from now on; no other is touched. Works
with and without a running gateway."""
_SIZE = re.compile(r"(\d{1,12})\s*(bytes|b|kib|k|mib|m)?", re.IGNORECASE)
_UNITS = {"": 1, "b": 1, "bytes": 1, "k": 1024, "kib": 1024, "m": 1024**2, "mib": 1024**2}


def run(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic container limit", description=ABOUT)
    parser.add_argument("name", metavar="NAME", help="a robot, a person, or an id of the list")
    parser.add_argument("--names", metavar="N", help="different names at most")
    parser.add_argument("--size", metavar="SIZE", help="of everything at most: 64KiB, 1MiB")
    add_where(parser)
    options = parser.parse_args(arguments)
    if options.names is None and options.size is None:
        raise OutOfBounds("Say what the limit is, with --names 64 or --size 64KiB.")
    asked = {
        "names": None if options.names is None else _count("--names", options.names),
        "most_bytes": None if options.size is None else _count("--size", options.size),
    }
    body = msgspec.Raw(msgspec.json.encode(asked))
    print(
        "\n".join(
            changed(options, AdminRequest(AdminVerb.LIMIT, (options.name,), body), robots=True)
        )
    )
    return 0


def _count(option: str, text: str) -> int:
    found = _SIZE.fullmatch(text.strip())
    unit = "" if found is None or found[2] is None else found[2].casefold()
    if found is None or (unit and option == "--names"):
        like = "64" if option == "--names" else "64KiB"
        raise OutOfBounds(f"I cannot read {option} {text!r}. Write {option} {like}.")
    return int(found[1]) * _UNITS[unit]
