"""The ``rosic`` command: finds the sub-command, and imports that one alone."""

from __future__ import annotations

import os
import sys
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

from rosic import __version__
from rosic.errors import ConfigurationError, RosicError

if TYPE_CHECKING:
    from collections.abc import Sequence

FAILED = 1
WRONG = 2
INTERRUPTED = 130
UNREAD = 141
"""What a shell says of whatever died of a closed pipe: 128 + SIGPIPE."""


class Command(NamedTuple):
    """A sub-command.

    Attributes:
        module: Has ``run(arguments) -> exit status``.
        summary: One line for the overview.
    """

    module: str
    summary: str


COMMANDS: dict[str, Command] = {
    "init": Command("rosic.cli.init", "a few questions, then a configuration that works"),
    "demo": Command("rosic.cli.demo", "simulated robots in this terminal, or a play: demo fleet"),
    "run": Command("rosic.cli.run", "start the gateway of a configuration file"),
    "check": Command("rosic.cli.check", "say everything that is wrong with a configuration file"),
    "robot check": Command("rosic.cli.robot_check", "say everything that is wrong with a profile"),
    "robot add": Command("rosic.cli.robot_add", "add a robot to the running gateway"),
    "robot discover": Command("rosic.cli.robots", "draft a profile from the ROS 2 graph"),
    "status": Command("rosic.cli.status", "how the robots of the running gateway are"),
    "stop": Command("rosic.cli.stop", "stop robots of the running gateway; all, if none is named"),
    "resume": Command("rosic.cli.resume", "let stopped robots of the running gateway go on"),
    "people": Command("rosic.cli.people", "who is known, with which roles"),
    "invite": Command("rosic.cli.invite", "a code that lets one person in, once"),
    "lock": Command("rosic.cli.lock", "keep somebody out for now; what they move stops"),
    "unlock": Command("rosic.cli.unlock", "give a locked person their access back"),
    "revoke": Command("rosic.cli.revoke", "take somebody's access back, for ever"),
    "key list": Command("rosic.cli.key_list", "every authorisation key, and how long it is good"),
    "key rotate": Command("rosic.cli.keys", "a new key in place of somebody's old one"),
    "key revoke": Command("rosic.cli.key_revoke", "take one key back, or all of a person's"),
    "explain": Command("rosic.cli.explain", "what somebody may, and every rule that made it so"),
    "history": Command("rosic.cli.history", "who asked for what, when, and what came of it"),
    "security report": Command(
        "rosic.cli.security_report", "who was turned away, who is locked, what ends soon"
    ),
    "container list": Command("rosic.cli.container_list", "every container of what is kept"),
    "container show": Command("rosic.cli.container_show", "how much of what one container holds"),
    "container export": Command("rosic.cli.containers", "what a container holds, as a file"),
    "container limit": Command("rosic.cli.container_limit", "what one container may keep"),
    "container erase": Command("rosic.cli.container_erase", "erase a container, for good"),
    "schedule plan": Command("rosic.cli.gateway", "who could have which robot when"),
    "clock": Command("rosic.cli.clock", "whether the clock was set back, and that it is right"),
    "doctor": Command("rosic.cli.doctor", "measure this machine; with --try, a robot"),
    "sim": Command("rosic.cli.sim", "the simulated robots as ROS 2 nodes"),
    "bench": Command("rosic.cli.bench", "measure how fast ROSIC is here"),
    "completion": Command("rosic.cli.completion", "what makes a shell complete these commands"),
}

USAGE = """usage: rosic COMMAND ...

Chat messages move ROS 2 robots, safely.

{commands}

rosic COMMAND --help says more about one of them. Try first: rosic demo"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command. Return the exit status: 0 good, 1 it did not work, 2 wrong input."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        status = _run(words)
        sys.stdout.flush()
    except ConfigurationError as wrong:
        return _complain(str(wrong), WRONG)
    except RosicError as fault:
        if isinstance(fault.__cause__, BrokenPipeError):
            return _unread()
        return _complain(str(fault), FAILED)
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        return _unread()
    return status


def _unread() -> int:
    """Say nothing more: whoever read our output has gone (``rosic status | head``)."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return UNREAD


def _run(words: list[str]) -> int:
    for count in (2, 1):
        name = " ".join(words[:count])
        if len(words) >= count and name in COMMANDS:
            run = import_module(COMMANDS[name].module).run
            return int(run(words[count:]))
    return _overview(words)


def _overview(words: list[str]) -> int:
    asked = words[0] if words else "--help"
    if asked in {"-h", "--help", "help"}:
        print(_usage(""))
        return 0
    if asked in {"-V", "--version", "version"}:
        print(f"rosic {__version__}")
        return 0
    within = f"{asked} "
    if any(name.startswith(within) for name in COMMANDS):
        helps = len(words) > 1 and words[1] in {"-h", "--help"}
        print(_usage(within), file=sys.stdout if helps else sys.stderr)
        return 0 if helps else WRONG
    return _complain(f"There is no command {asked!r}.{_meant(asked)}", WRONG)


def _usage(prefix: str) -> str:
    shown = {name: what for name, what in COMMANDS.items() if name.startswith(prefix)}
    width = max(map(len, shown))
    lines = [f"  {name:<{width}}  {command.summary}" for name, command in shown.items()]
    return USAGE.format(commands="\n".join(lines))


def _meant(asked: str) -> str:
    # Seldom needed, so not imported at the top: `rosic --help` has to be quick.
    near: list[str] = import_module("difflib").get_close_matches(asked, COMMANDS, n=1)
    return f" Did you mean {near[0]}?" if near else " See: rosic --help"


def _complain(sentence: str, status: int) -> int:
    print(f"rosic: {sentence}", file=sys.stderr)
    return status
