"""``rosic check`` and ``doctor``: what is wrong, without starting anything."""

from __future__ import annotations

import argparse
import asyncio
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.explain import says_no
from rosic.app.admin.history import AT_MOST, HistoryParameters
from rosic.app.config import Config, load_config
from rosic.app.setup import DiagnosticFinding, FindingVerdict, examine
from rosic.app.setup.check import check_all
from rosic.cli import remote
from rosic.cli.client import CONFIG, add_where, elsewhere, joined, looked_up, printed, seconds
from rosic.errors import ConfigurationError, OutOfBounds
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from collections.abc import Sequence


# ---- audit ----

# ``rosic explain``, ``history`` and ``security report``: what was decided, and why.

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
    shape = parser.add_mutually_exclusive_group()
    shape.add_argument("--json", action="store_true", help="one list, for programs")
    shape.add_argument("--csv", action="store_true", help="a table; of a gateway elsewhere")
    add_where(parser)
    remote.add_gateway(parser)
    options = parser.parse_args(joined(arguments, ("--since",)))
    since_s = None if options.since is None else seconds("--since", options.since)
    if url := elsewhere(options):
        return _history_there(options, url, since_s)
    if options.csv:
        raise OutOfBounds("--csv is for a gateway elsewhere (--url). For programs here: --json")
    asked = HistoryParameters(
        robot=options.robot,
        person=options.person,
        since_s=since_s,
        limit=NEWEST if options.since is None else AT_MOST,
        json=options.json,
    )
    request = AdminRequest(AdminVerb.HISTORY, body=msgspec.Raw(msgspec.json.encode(asked)))
    print(printed(looked_up(options, request, robots=bool(options.robot)), json=options.json))
    return 0


def _history_there(options: argparse.Namespace, url: str, since_s: float | None) -> int:
    if options.person:
        raise OutOfBounds(
            "A gateway elsewhere shows what you asked, and all of a robot (--robot) to whoever may "
            "read it; nobody else's by name."
        )
    robot, json = options.robot, options.json
    if options.csv:
        return remote.run_there(options, url, lambda to: remote.history_table(to, robot, since_s))
    return remote.run_there(options, url, lambda to: remote.history(to, robot, since_s, json=json))


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


# ---- diagnostics ----

# ---- ``rosic check`` ----

CHECK_ABOUT = "Say everything that is wrong with a configuration file and the profiles it names."


def check(arguments: Sequence[str]) -> int:
    """Check. Return 0 if a gateway could be started with it, else 2."""
    parser = argparse.ArgumentParser(prog="rosic check", description=CHECK_ABOUT)
    parser.add_argument("-c", "--config", metavar="FILE", default=CONFIG)
    options = parser.parse_args(arguments)
    found = check_all(options.config, SystemClock())
    for advice in found.advice:
        print(f"{advice}")
    for error in found.errors:
        print(f"{error}", file=sys.stderr)
    if found.errors:
        count = len(found.errors)
        print(f"{count} {'thing is' if count == 1 else 'things are'} wrong.", file=sys.stderr)
        return 2
    print(f"{options.config} is good: {found.summary}.")
    return 0


# ---- ``rosic doctor`` ----

DOCTOR_ABOUT = """Measure this machine: its disk, record and clocks; look for ROS 2; check the
accounts of the messengers. With --try, one robot moves slowly for a moment, and its stop and its
watchdog are measured: have free space around it."""

LEFT = """Broken off. Whatever was under way was ended. Where {robot} had been stopped, it stays
stopped, also after a start: see rosic status, and say: resume {robot}"""


def doctor(arguments: Sequence[str]) -> int:
    """Examine. Return 0 if all is good, 1 if something should be looked at.

    Raises:
        ConfigurationError: The configuration is wrong.
    """
    parser = argparse.ArgumentParser(prog="rosic doctor", description=DOCTOR_ABOUT)
    parser.add_argument(
        "-c",
        "--config",
        metavar="FILE",
        help=f"also look at what it names ({CONFIG}, if it is here)",
    )
    parser.add_argument("--try", dest="tried", metavar="ROBOT", default="", help="it moves")
    options = parser.parse_args(arguments)
    found = options.config or (CONFIG if Path(CONFIG).exists() else None)
    if options.tried and found is None:
        raise ConfigurationError(
            f"To try a robot, its configuration is needed, and there is no {CONFIG} here.",
            hint=f"For example: rosic doctor -c lab/{CONFIG} --try {options.tried}",
        )
    config = load_config(found) if found is not None else None
    if config is not None and options.config is None:
        found_here = "found here; what it names is looked at, too"
        print(DiagnosticFinding(CONFIG, FindingVerdict.GOOD, found_here))
    try:
        return asyncio.run(_examine(config, options.tried))
    except KeyboardInterrupt:
        if options.tried:
            print(LEFT.format(robot=options.tried), flush=True)
        raise


async def _examine(config: Config | None, tried: str) -> int:
    looked = False
    async for finding in examine(config, tried=tried, clock=SystemClock(), entropy=SystemEntropy()):
        print(finding, flush=True)
        looked = looked or finding.verdict is FindingVerdict.LOOK
    return 1 if looked else 0
