"""What a running gateway is told: ``rosic status``, ``stop``, ``resume``, ``clock``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosic.app.admin.api import ALL, AS_JSON, NOTHING, AdminRequest, AdminVerb
from rosic.cli.client import add_where, ask, changed, data_of
from rosic.errors import OutOfBounds

if TYPE_CHECKING:
    from collections.abc import Sequence


def status(arguments: Sequence[str]) -> int:
    """Ask the gateway."""
    parser = argparse.ArgumentParser(
        prog="rosic status", description="How the robots of the running gateway are."
    )
    parser.add_argument("robots", metavar="ROBOT", nargs="*")
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_where(parser)
    options = parser.parse_args(arguments)
    body = AS_JSON if options.json else NOTHING
    return ask(data_of(options), AdminRequest(AdminVerb.STATUS, tuple(options.robots), body))


# ---- ``rosic stop`` ----

STOP_ABOUT = """Stop robots of the running gateway, at once; all of them if none is named, or if a
name is not known. They stay stopped until somebody who may resumes them in a chat, or: rosic
resume."""


def stop(arguments: Sequence[str]) -> int:
    """Ask the gateway to stop. Return 1 if there is none to ask."""
    parser = argparse.ArgumentParser(prog="rosic stop", description=STOP_ABOUT)
    parser.add_argument("robots", metavar="ROBOT", nargs="*")
    add_where(parser)
    options = parser.parse_args(arguments)
    return ask(data_of(options), AdminRequest(AdminVerb.STOP, tuple(options.robots)))


# ---- ``rosic resume`` ----

RESUME_ABOUT = """Let stopped robots of the running gateway go on; without a name, the one that is
stopped. Nothing moves by this alone. Look first: whoever stopped it had a reason."""


def resume(arguments: Sequence[str]) -> int:
    """Ask the gateway. Return 1 if there is none to ask, or if it says why not.

    Raises:
        OutOfBounds: All are meant, and some are named.
    """
    parser = argparse.ArgumentParser(prog="rosic resume", description=RESUME_ABOUT)
    parser.add_argument("robots", metavar="ROBOT", nargs="*", help="a robot, or a group")
    parser.add_argument(ALL, action="store_true", dest="everything", help="every stopped one")
    add_where(parser)
    options = parser.parse_args(arguments)
    if options.everything and options.robots:
        raise OutOfBounds(f"Name robots, or say {ALL}.")
    names = (ALL,) if options.everything else tuple(options.robots)
    return ask(data_of(options), AdminRequest(AdminVerb.RESUME, names))


# ---- ``rosic clock`` ----

CLOCK_ABOUT = """Say whether the clock of this machine is behind the latest time that was seen here.
A clock that was set back revives nothing: no key, no right, no code, no time with a robot. Works
with and without a running gateway."""


def clock(arguments: Sequence[str]) -> int:
    """Ask the gateway, or write it into its data when none runs.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    parser = argparse.ArgumentParser(prog="rosic clock", description=CLOCK_ABOUT)
    parser.add_argument(
        "--accept", action="store_true", help="the clock was wrong before and is right now"
    )
    add_where(parser)
    options = parser.parse_args(arguments)
    names = ("accept",) if options.accept else ()
    print("\n".join(changed(options, AdminRequest(AdminVerb.CLOCK, names))))
    return 0
