"""``rosic demo``: six simulated robots in this terminal, or a play about some of them."""

from __future__ import annotations

import argparse
import asyncio
from importlib import import_module
from typing import TYPE_CHECKING

from rosic.app.demo import demonstrate
from rosic.app.logging import log_to_standard_error
from rosic.app.runtime import face_of
from rosic.cli.client import begun_ns
from rosic.errors import ConfigurationError
from rosic.system import SystemClock, SystemEntropy
from rosic_sim.scenarios.registry import NAMES, play_named

if TYPE_CHECKING:
    from collections.abc import Sequence

ABOUT = """Six simulated robots in this terminal: no account, no ROS, nothing is kept. With standard
input piped, its lines run one after another, each to its end.

With a name, a play of half a minute, which ends by itself and says what happened:
  one-to-one  a forest ranger and one robot that watches for fire
  class       twenty students, their teacher and one arm
  fleet       a warehouse manager and three carriers, one of which fails
  shift       two managers with overlapping groups, and a hand-over to the night shift
  swarm       a search with drones in the air and rovers on the ground"""


def run(arguments: Sequence[str]) -> int:
    """Run the demonstration, or a play.

    Raises:
        ConfigurationError: Nobody of that name takes part.
    """
    parser = argparse.ArgumentParser(
        prog="rosic demo", description=ABOUT, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("play", nargs="?", choices=tuple(NAMES), metavar="NAME")
    parser.add_argument("--plain", action="store_true", help="no colours, no prompt that redraws")
    parser.add_argument("--console", action="store_true", help="also a page for your browser")
    parser.add_argument("--fast", action="store_true", help="a play, four times as fast")
    parser.add_argument(
        "--interactive", action="store_true", help="a play without its script: you act in it"
    )
    parser.add_argument("--stay", action="store_true", help="go on when the play has ended")
    parser.add_argument(
        "--as",
        dest="role",
        default="",
        metavar="WHO",
        help='who you are with --interactive or --stay: "Night manager"',
    )  # the first of the play, if nothing is said
    options = parser.parse_args(arguments)
    log_to_standard_error("error" if options.play else "warning", face_of())
    if options.play is None:
        if options.fast or options.interactive or options.stay or options.role:
            parser.error(f"say which play: {', '.join(NAMES)}")
        return asyncio.run(
            demonstrate(
                SystemClock(),
                SystemEntropy(),
                plain=options.plain,
                begun_ns=begun_ns(),
                console=options.console,
            )
        )
    if options.console:
        parser.error("a play has no page: rosic demo --console")
    return _play(options)


def _play(options: argparse.Namespace) -> int:
    told = play_named(options.play)
    names = {person.name.casefold(): person.name for person in told.people}
    role = names.get(options.role.casefold(), "")
    if options.role and not role:
        raise ConfigurationError(
            f"Nobody in this play is called {options.role!r}.",
            hint=f"There are: {', '.join(names.values())}.",
        )
    if options.role and not (options.interactive or options.stay):
        raise ConfigurationError(
            "--as says who you are in a play, and in this one you only watch.",
            hint=f'Try: rosic demo {options.play} --interactive --as "{options.role}"',
        )
    # Only here: a plain demonstration is ready sooner without it.
    playing = import_module("rosic_sim.scenarios.runner")
    wish = playing.ScenarioOptions(
        plain=options.plain,
        fast=options.fast,
        scripted=not options.interactive,
        stay=options.stay,
        role=role,
    )
    status: int = asyncio.run(playing.play(told, wish, SystemClock(), SystemEntropy()))
    return status
