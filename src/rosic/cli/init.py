"""``rosic init``: a few questions, then a configuration that works."""

from __future__ import annotations

import argparse
import asyncio
import os
import sys
from getpass import getpass
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.app.setup.init import (
    SetupAnswers,
    can_be_simulated,
    check_absent,
    check_account,
    check_robots,
    check_token,
    check_zone,
    found,
    is_file,
    zone_here,
)
from rosic.cli.client import CONFIG
from rosic.config.profiles import shipped_profiles
from rosic.config.secrets import NAME as VARIABLE
from rosic.core.identity import Address
from rosic.errors import ConfigurationError, RosicError
from rosic.system import SystemClock

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


# ---- questions ----

HIDDEN = "Nothing is shown while you type or paste the next answer; Enter ends it."
_YES = {"y": True, "yes": True, "n": False, "no": False}


class Questions:
    """Asks somebody, or nobody.

    Args:
        silent: Ask nothing: every answer is empty.
    """

    def __init__(self, *, silent: bool) -> None:
        self._silent = silent

    def say(self, sentence: str) -> None:
        """Tell something between two questions."""
        print(sentence)

    def fit(
        self, question: str, default: str, check: Callable[[str], object], *, secret: bool = False
    ) -> str:
        """Ask for a text, again until it fits: one slip of a finger costs no other answer.

        Args:
            question: What is asked.
            default: For an empty answer.
            check: Raises a ConfigurationError about an answer that does not fit.
            secret: Do not show what is typed.

        Raises:
            ConfigurationError: The answers ended before the questions; or nothing is asked, and
                the default does not fit.
        """
        while True:
            answer = self.text(question, default, secret=secret)
            try:
                check(answer)
            except ConfigurationError as wrong:
                if self._silent:
                    raise
                self.say(str(wrong))
            else:
                return answer

    def text(self, question: str, default: str, *, secret: bool = False) -> str:
        """Ask for a text.

        Args:
            question: What is asked.
            default: For an empty answer.
            secret: Do not show what is typed.

        Raises:
            ConfigurationError: The answers ended before the questions.
        """
        if self._silent:
            return default
        shown = f"{question} [{default}] " if default else f"{question} "
        try:
            hidden = secret and sys.stdin.isatty()
            if hidden:
                self.say(HIDDEN)
            return (getpass(shown) if hidden else input(shown)).strip() or default
        except EOFError:
            print()
            raise ConfigurationError(
                "The questions were not answered to the end. Nothing was written.",
                hint="rosic init --yes asks nothing.",
            ) from None

    def yes(self, question: str, *, default: bool) -> bool:
        """Ask for yes or no, again until it is one of them."""
        while True:
            said = self.text(f"{question} {'[Y/n]' if default else '[y/N]'}", "")
            answer = default if not said else _YES.get(said.casefold())
            if answer is not None:
                return answer
            self.say("Please say yes or no.")


# ---- ``rosic init`` ----

ABOUT = """Ask a few questions and write rosic.toml, and profiles of robots that were found on the
ROS 2 graph. Nothing that exists is overwritten. With --yes nothing is asked: what no option says is
as if the question had been left empty."""
NAME = "lab"
ROBOTS = ("omni", "kuka1")
KINDS = {
    "cf1": "drone",
    "cf2": "drone",
    "cf3": "drone",
    "kuka1": "arm",
    "omni": "mobile manipulator",
    "picker": "arm with gripper",
    "rover": "mobile robot with Nav2",
    "talker": "text only",
    "yumi": "two arms",
}
LINKS = ("simulated", "ros2")
CODE = "code"


def run(arguments: Sequence[str]) -> int:
    """Ask, write, check.

    Raises:
        ConfigurationError: What is wrong; nothing was written.
    """
    options = _parser().parse_args(arguments)
    path = Path(options.config)
    check_absent(path)
    answers = _answers(options, Questions(silent=options.yes))
    made = found(path, answers, SystemClock())
    for advice in made.advice:
        print(f"look at: {advice}")
    named = "" if str(path) == CONFIG else f" -c {path}"
    print(f"Written: {', '.join(made.written)}. Start with: rosic run{named}")
    if answers.admin is None:
        print("The first start shows a code at the terminal. Whoever sends it first is the admin.")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="rosic init", description=ABOUT)
    add = parser.add_argument
    add("-c", "--config", metavar="FILE", default=CONFIG, help=f"what to write ({CONFIG})")
    add("--name", metavar="NAME", help=f"of this place ({NAME})")
    add("--zone", metavar="ZONE", help="its time zone, as Europe/Vienna (this machine's)")
    token = parser.add_mutually_exclusive_group()
    token.add_argument(
        "--token-env",
        metavar="VARIABLE",
        default="",
        help="of the environment, which holds the Telegram token",
    )
    token.add_argument(
        "--token-file", metavar="FILE", default="", help="which holds the Telegram token"
    )
    token.add_argument("--no-telegram", action="store_true", help="talk at this terminal")
    add(
        "--robot",
        nargs="+",
        action="extend",
        metavar="PROFILE",
        help="profiles that ship, or files: ./rover.yaml",
    )
    add("--link", choices=LINKS, help="how those are reached (simulated)")
    add("--discover", action="store_true", help="look for robots on the ROS 2 graph")
    add("--admin", metavar="ID", help=f"a Telegram id, or {CODE}: the first start shows one")
    add("--yes", action="store_true", help="ask nothing")
    return parser


def _answers(options: argparse.Namespace, ask: Questions) -> SetupAnswers:
    name = options.name or ask.text("Name of this place?", NAME)
    zone = options.zone or ask.fit("Its time zone?", zone_here(), check_zone)
    if options.token_env and not VARIABLE.fullmatch(options.token_env):
        raise ConfigurationError(
            "--token-env takes the NAME of a variable of the environment, and this is none.",
            hint="Set a variable to the token, and write its name.",
        )
    token = _token(options, ask)
    has_telegram = bool(token or options.token_env or options.token_file)
    drafts = _drafts(options, ask)
    robots = _robots(options, ask, drafts)
    shipped = tuple(robot for robot in robots if not is_file(robot))
    link, not_simulated = _link(options, ask, shipped)
    return SetupAnswers(
        name=name,
        zone=zone,
        token=token,
        token_env=options.token_env,
        token_file=str(Path(options.token_file).absolute()) if options.token_file else "",
        robots=shipped,
        link=link,
        not_simulated=not_simulated,
        files=tuple(str(Path(robot).absolute()) for robot in robots if is_file(robot)),
        files_link=options.link or "",
        drafts=drafts,
        admin=_admin(options, ask, has_telegram=has_telegram),
    )


def _token(options: argparse.Namespace, ask: Questions) -> str:
    if options.no_telegram or options.token_env or options.token_file:
        return ""
    question = "Telegram bot token, from BotFather (leave empty to try without):"
    return ask.fit(question, "", check_token, secret=True)


def _drafts(options: argparse.Namespace, ask: Questions) -> dict[str, str]:
    """Look at the ROS 2 graph if that is wanted. Only who asked for it by an option has to have it.

    Raises:
        RosicError: ROS 2 is not here, or nobody is on its graph.
    """
    if not options.discover and (options.robot or not _wants_ros(ask)):
        return {}
    from rosic.app.setup.discovery import LOOK_S, discover  # noqa: PLC0415 - ROS 2, only for who has it

    try:
        seen = asyncio.run(discover(SystemClock(), seconds=LOOK_S))
    except RosicError as none:
        if options.discover:
            raise
        ask.say(f"{none} I go on without.")
        return {}
    ask.say(f"Seen: {', '.join(seen)}.")
    return seen


def _wants_ros(ask: Questions) -> bool:
    return ask.yes("Look for robots on the ROS 2 graph?", default=False)


def _robots(options: argparse.Namespace, ask: Questions, drafts: dict[str, str]) -> tuple[str, ...]:
    if options.robot:
        robots = (
            _named(" ".join(options.robot))
            if len(options.robot) == 1
            else tuple(dict.fromkeys(options.robot))
        )
        _check(options, robots)
        return robots
    if drafts:
        return ()
    shipped = ", ".join(f"{name} ({KINDS[name]})" for name in shipped_profiles())
    question = f"Which robots? There are {shipped}."
    return _named(ask.fit(question, " ".join(ROBOTS), lambda said: _check(options, _named(said))))


def _check(options: argparse.Namespace, robots: tuple[str, ...]) -> None:
    check_robots(robots, SystemClock(), options.link or "")


def _named(said: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(said.replace(",", " ").split()))


def _link(
    options: argparse.Namespace, ask: Questions, robots: tuple[str, ...]
) -> tuple[str, tuple[str, ...]]:
    """Return how robots are reached, and which of them cannot be reached so."""
    if options.link is not None:
        return str(options.link), ()
    real = tuple(robot for robot in robots if not can_be_simulated(robot, SystemClock()))
    for robot in real:
        ask.say(f"{robot} cannot be simulated here: it is looked for on ROS 2.")
    if robots and len(real) == len(robots):
        return LINKS[1], ()
    which = " and ".join(robot for robot in robots if robot not in real) if real else "them"
    question = f"Simulate {which} here? Otherwise they are looked for on ROS 2."
    if not robots or ask.yes(question, default=True):
        return LINKS[0], real
    return LINKS[1], ()


def _admin(options: argparse.Namespace, ask: Questions, *, has_telegram: bool) -> Address | None:
    if options.admin == CODE:
        return None
    if options.admin:
        if not has_telegram:
            raise ConfigurationError(
                "--admin names a Telegram account, and there is no Telegram here.",
                hint="Leave it out: whoever runs this is the admin.",
            )
        return check_account(options.admin)
    if not has_telegram:
        return Address("terminal", str(os.getuid()))
    question = "Your Telegram id, a number? (leave empty to get a code at the start)"
    said = ask.fit(question, "", lambda said: said and check_account(said))
    return check_account(said) if said else None
