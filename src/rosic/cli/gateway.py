"""``rosic run``: the gateway itself."""

from __future__ import annotations

import argparse
import logging
import sys
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.api.settings import LISTEN, ApiSettings, parse_listen
from rosic.app import runtime
from rosic.app.admin.api import ALL, AS_JSON, NOTHING, AdminRequest, AdminVerb
from rosic.app.builder import secrets_of
from rosic.app.config import Config, load_config
from rosic.app.logging import keep_memory_private, log_to_standard_error
from rosic.app.runtime import face_of
from rosic.app.service import GatewayService
from rosic.cli import remote
from rosic.cli.client import CONFIG, add_where, ask, begun_ns, changed, data_of, elsewhere
from rosic.cli.people import show
from rosic.config.plugins import of_locale
from rosic.config.secrets import open_to_others
from rosic.core.i18n import in_language
from rosic.errors import OutOfBounds, RosicError
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from collections.abc import Sequence


# ---- control ----

# What a running gateway is told: ``rosic status``, ``stop``, ``resume``, ``clock``.


def status(arguments: Sequence[str]) -> int:
    """Ask the gateway."""
    parser = argparse.ArgumentParser(
        prog="rosic status", description="How the robots of the running gateway are."
    )
    parser.add_argument("robots", metavar="ROBOT", nargs="*")
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_where(parser)
    remote.add_gateway(parser)
    options = parser.parse_args(arguments)
    if url := elsewhere(options):
        return remote.run_there(
            options, url, lambda there: remote.status(there, options.robots, json=options.json)
        )
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
    remote.add_gateway(parser)
    options = parser.parse_args(arguments)
    if url := elsewhere(options):
        return remote.run_there(options, url, lambda there: remote.stop(there, options.robots))
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
    remote.add_gateway(parser)
    options = parser.parse_args(arguments)
    if options.everything and options.robots:
        raise OutOfBounds(f"Name robots, or say {ALL}.")
    if url := elsewhere(options):
        whom = ["all"] if options.everything else options.robots
        line = " ".join(["resume", *whom])
        return remote.run_there(options, url, lambda there: remote.say(there, line))
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


# ---- gateway ----

RUN_ABOUT = """Start the gateway of a configuration file, and keep it running until SIGTERM or
Ctrl-C. Then robots are brought to rest, what is untold is told, and it ends within 5 seconds."""

BEGIN_ANEW = """take the data folder as it is, though its record was lost, emptied or put back
from an older copy: what was decided meanwhile is forgotten, whoever was revoked or locked since may
come in again, and without a record everybody whom the configuration names is let in anew"""

log = logging.getLogger("rosic.gateway")


def run(arguments: Sequence[str]) -> int:
    """Run the gateway. Return 0 after a signal, 1 when it could not start or go on.

    Raises:
        ConfigurationError: The configuration is wrong; nothing was started.
    """
    keep_memory_private()  # before there is a secret in it
    parser = argparse.ArgumentParser(prog="rosic run", description=RUN_ABOUT)
    parser.add_argument("-c", "--config", metavar="FILE", default=CONFIG)
    parser.add_argument(
        "--console",
        action="store_true",
        help=f"serve the page on {LISTEN}, if nothing else is said",
    )
    parser.add_argument("--begin-anew", action="store_true", help=BEGIN_ANEW)
    options = parser.parse_args(arguments)
    config = replace(load_config(options.config), begin_anew=options.begin_anew)
    if options.console and config.api is None:
        config = replace(config, api=ApiSettings(listen=parse_listen(LISTEN)))
    others = tuple(open_to_others((*config.files, config.data)))
    for found in others:
        if found.everybody:
            raise found.error
    log_to_standard_error(config.log_level.value, face_of(), secrets_of(config))
    for found in others:
        log.warning("%s", found.error)
    try:
        runtime.run(_serve(config))
    except RosicError as error:
        print(f"rosic: {error}", file=sys.stderr)
        return 1
    return 0


async def _serve(config: Config) -> None:
    # A code for the first admin is for whoever sits here: not for a file, not for the journal.
    at_terminal = _show if sys.stdout.isatty() else None
    await GatewayService(
        config, SystemClock(), SystemEntropy(), begun_ns=begun_ns(), show=at_terminal
    ).run()


def _show(sentence: str, payload: str) -> None:
    """Print a sentence in the language of this terminal, and what a camera reads."""
    from rosic.messengers.terminal.messenger import own_locale  # noqa: PLC0415 - not for a start

    show(in_language(sentence, of_locale(own_locale())), payload)
