"""``rosic verify``: compare emoji with somebody, at the machine itself."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.control_client import NotRunning
from rosic.app.admin.verification import ShownEmoji
from rosic.cli.client import add_where, answers, data_of
from rosic.core.i18n import plain
from rosic.errors import ConfigurationError, Expired

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

VERIFY_ABOUT = """Compare emoji with somebody on Matrix, so that what they write from their own
devices counts. Nobody can put others in between you and this machine, so the first admin is
verified so. Needs a running gateway."""
WAITS_S: Final = 600.0
ASKS_EACH_S: Final = 0.5


def verify(arguments: Sequence[str]) -> int:
    """Ask somebody's client, or wait until one begins; show emoji, and take the answer.

    Raises:
        RosicError: Why not; nobody is verified.
    """
    parser = argparse.ArgumentParser(prog="rosic verify", description=VERIFY_ABOUT)
    parser.add_argument(
        "name",
        metavar="NAME",
        nargs="?",
        default="",
        help="as rosic people shows it, or the id; left out: whoever begins in their client",
    )
    add_where(parser)
    options = parser.parse_args(arguments)
    data = data_of(options)
    try:
        return _compare(data, options.name)
    except NotRunning as error:
        raise ConfigurationError(
            "No gateway runs here, and only a running one can ask somebody's client.",
            hint="Start it first: rosic run",
        ) from error


def _compare(data: Path, name: str) -> int:
    number = _asked(data, "begin", name)[0].number if name else 0
    who = name or "whoever begins to verify ROSIC in their client"
    print(f"Waiting for {who}: they have to accept it in their client.", flush=True)
    shown = _awaited(data, number, ended=False)
    if shown.outcome:
        print(shown.outcome)
        return 1
    print(f"\n{shown.name}: {shown.account}, device {shown.device}\n\n    {shown.text}\n")
    print("Their client shows seven as well. Have them read to you, in person or by telephone.")
    same = input("Are they the same, all of them, in this order? [y/N] ").strip().casefold()
    verb = "match" if same in {"y", "yes", "j", "ja"} else "differ"
    print(_said(data, verb, str(shown.number)), flush=True)
    ended = _awaited(data, shown.number, ended=True)
    print(ended.outcome)
    return 0 if verb == "match" and ended.verified else 1


def _awaited(data: Path, number: int, *, ended: bool) -> ShownEmoji:
    """Return it once its emoji are there, or once it has ended.

    Raises:
        Expired: Neither in ten minutes.
    """
    give_up_s = time.monotonic() + WAITS_S
    while time.monotonic() < give_up_s:
        asked = ("show", str(number)) if number else ("list", "")
        for shown in _asked(data, *asked):
            if shown.outcome or (shown.text and not ended):
                return shown
        time.sleep(ASKS_EACH_S)
    raise Expired("Nobody answered. Nobody is verified.")


def _asked(data: Path, verb: str, about: str) -> list[ShownEmoji]:
    request = AdminRequest(AdminVerb.VERIFY, (verb, about))
    return [msgspec.json.decode(text, type=ShownEmoji) for text in answers(data, request)]


def _said(data: Path, verb: str, about: str) -> str:
    return "\n".join(map(plain, answers(data, AdminRequest(AdminVerb.VERIFY, (verb, about)))))
