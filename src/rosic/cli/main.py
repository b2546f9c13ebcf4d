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


class Subcommand(NamedTuple):
    """A sub-command.

    Attributes:
        function: ``module:name`` of what takes the arguments and returns the exit status.
        summary: One line for the overview.
    """

    function: str
    summary: str

    def run(self, arguments: Sequence[str]) -> int:
        """Import it, with what it needs, and run it."""
        module, _, name = self.function.partition(":")
        return int(getattr(import_module(module), name)(arguments))


COMMANDS: dict[str, Subcommand] = {
    "init": Subcommand("rosic.cli.init:run", "a few questions, then a configuration that works"),
    "demo": Subcommand(
        "rosic.cli.demo:run", "simulated robots in this terminal, or a play: demo fleet"
    ),
    "run": Subcommand("rosic.cli.gateway:run", "start the gateway of a configuration file"),
    "check": Subcommand(
        "rosic.cli.diagnostics:check", "say everything that is wrong with a configuration file"
    ),
    "robot check": Subcommand(
        "rosic.cli.robots:check", "say everything that is wrong with a profile"
    ),
    "robot add": Subcommand("rosic.cli.robots:add", "add a robot to the running gateway"),
    "robot discover": Subcommand(
        "rosic.cli.robots:discover_robots", "draft a profile from the ROS 2 graph"
    ),
    "status": Subcommand("rosic.cli.gateway:status", "how the robots of the running gateway are"),
    "stop": Subcommand(
        "rosic.cli.gateway:stop", "stop robots of the running gateway; all, if none is named"
    ),
    "resume": Subcommand(
        "rosic.cli.gateway:resume", "let stopped robots of the running gateway go on"
    ),
    "order": Subcommand("rosic.cli.remote:order", "give an order to a gateway elsewhere"),
    "orders": Subcommand("rosic.cli.remote:orders", "the orders of a gateway elsewhere"),
    "picture": Subcommand(
        "rosic.cli.remote_files:picture", "save what a robot of a gateway elsewhere sees"
    ),
    "file list": Subcommand(
        "rosic.cli.remote_files:list_files", "your files at a gateway elsewhere"
    ),
    "file send": Subcommand(
        "rosic.cli.remote_files:send_file", "keep files at a gateway elsewhere"
    ),
    "file get": Subcommand("rosic.cli.remote_files:get_file", "save one of your files there"),
    "file delete": Subcommand(
        "rosic.cli.remote_files:delete_file", "delete one of your files there"
    ),
    "people": Subcommand("rosic.cli.people:people", "who is known, with which roles"),
    "invite": Subcommand("rosic.cli.people:invite", "a code that lets one person in, once"),
    "lock": Subcommand("rosic.cli.people:lock", "keep somebody out for now; what they move stops"),
    "unlock": Subcommand("rosic.cli.people:unlock", "give a locked person their access back"),
    "revoke": Subcommand("rosic.cli.people:revoke", "take somebody's access back, for ever"),
    "verify": Subcommand(
        "rosic.cli.verification:verify", "compare emoji with somebody on Matrix, at this machine"
    ),
    "key list": Subcommand(
        "rosic.cli.keys:list_keys", "every authorisation key, and how long it is good"
    ),
    "key create": Subcommand(
        "rosic.cli.keys:create", "a key for a program, with a secret that is shown once"
    ),
    "key rotate": Subcommand("rosic.cli.keys:rotate", "a new key in place of somebody's old one"),
    "key revoke": Subcommand("rosic.cli.keys:revoke", "take one key back, or all of a person's"),
    "explain": Subcommand(
        "rosic.cli.diagnostics:explain", "what somebody may, and every rule that made it so"
    ),
    "history": Subcommand(
        "rosic.cli.diagnostics:history", "who asked for what, when, and what came of it"
    ),
    "record": Subcommand(
        "rosic.cli.record:run", "what is asked of robots beside what moves, as a file for Foxglove"
    ),
    "security report": Subcommand(
        "rosic.cli.diagnostics:security_report",
        "who was turned away, who is locked, what ends soon",
    ),
    "container list": Subcommand(
        "rosic.cli.containers:list_containers", "every container of what is kept"
    ),
    "container show": Subcommand(
        "rosic.cli.containers:show", "how much of what one container holds"
    ),
    "container export": Subcommand(
        "rosic.cli.containers:export_container", "what a container holds, as a file"
    ),
    "container limit": Subcommand("rosic.cli.containers:limit", "what one container may keep"),
    "container erase": Subcommand("rosic.cli.containers:erase", "erase a container, for good"),
    "schedule plan": Subcommand("rosic.cli.schedule:plan", "who could have which robot when"),
    "clock": Subcommand(
        "rosic.cli.gateway:clock", "whether the clock was set back, and that it is right"
    ),
    "doctor": Subcommand(
        "rosic.cli.diagnostics:doctor", "measure this machine; with --try, a robot"
    ),
    "mcp": Subcommand(
        "rosic.cli.mcp:run", "let a program of this machine ask over MCP: standard input and output"
    ),
    "sim": Subcommand("rosic.cli.sim:run", "the simulated robots as ROS 2 nodes"),
    "bench": Subcommand("rosic.bench:main", "measure how fast ROSIC is here"),
    "webhook test": Subcommand("rosic.cli.webhook:test", "post one signed event, as a webhook is"),
    "completion": Subcommand(
        "rosic.cli.completion:run", "what makes a shell complete these commands"
    ),
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
            return COMMANDS[name].run(words[count:])
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
