"""What commands share that ask a running gateway, or its data when none runs."""

from __future__ import annotations

import asyncio
import os
import re
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.control_client import NotRunning, ask_gateway
from rosic.cli import remote
from rosic.config.toml_source import read_toml
from rosic.core.language.time_tokens import TimeTokens, UnclearTime
from rosic.errors import ConfigurationError, OutOfBounds, Refusal
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterable, Sequence

    from rosic.app.admin.api import AdminRequest
    from rosic.app.admin.offline import OfflineAdmin, OfflineSeeding


CONFIG = "rosic.toml"
DATA = "rosic-data"


class AssumedFile(str):
    """The name of a file that nobody has named."""

    __slots__ = ()


def add_where(parser: argparse.ArgumentParser) -> None:
    """Let a command be told which gateway is meant."""
    parser.add_argument(
        "-c",
        "--config",
        metavar="FILE",
        default=AssumedFile(CONFIG),
        help=f"the gateway's file ({CONFIG})",
    )
    parser.add_argument("--data", metavar="FOLDER", help="its data folder, instead of the file")


def elsewhere(options: argparse.Namespace) -> str:
    """Return where the gateway is that is meant; empty: on this machine.

    Raises:
        OutOfBounds: One here and one elsewhere are named.
    """
    return remote.url_of(options, here=_is_named(options))


def _is_named(options: argparse.Namespace) -> bool:
    """Whether a gateway of this machine is named."""
    return options.data is not None or not isinstance(options.config, AssumedFile)


def data_of(options: argparse.Namespace) -> Path:
    """Return the data folder. Nothing else of the file has to be right: a stop must get through.

    Raises:
        ConfigurationError: The file cannot be read, or its data folder is no text; or a gateway
            elsewhere is meant, by ROSIC_URL, that the command does not ask.
    """
    if not _is_named(options) and "url" not in options and os.environ.get(remote.URL):
        raise ConfigurationError(
            f"{remote.URL} names a gateway elsewhere, and this command asks none: it looks at a "
            "gateway of this machine, or at its files. Nothing was done.",
            hint=f"Name the one of this machine with -c {CONFIG} or --data, or unset {remote.URL}.",
        )
    if options.data is not None:
        return Path(options.data).absolute()
    path = Path(options.config)
    gateway = read_toml(path).data.get("gateway", {})
    named = gateway.get("data", DATA) if isinstance(gateway, dict) else DATA
    if not isinstance(named, str):
        raise ConfigurationError("[gateway] data is not a text.", where=str(path))
    return (path.parent / Path(named).expanduser()).absolute()


def ask(data: Path, request: AdminRequest) -> int:
    """Ask the gateway and print its answers as they come. Return the exit status.

    Raises:
        NotRunning: There is none; nothing was done.
    """
    return asyncio.run(_ask(data, request))


async def _ask(data: Path, request: AdminRequest) -> int:
    good = True
    async for answer in ask_gateway(data, request, _warn):
        good = good and answer.good
        print(answer.text, file=sys.stdout if answer.good else sys.stderr, flush=True)
    return 0 if good else 1


def answers(data: Path, request: AdminRequest) -> tuple[str, ...]:
    """Ask the gateway and return its answers.

    Raises:
        NotRunning: There is none; nothing was done.
        Refusal: It said why not.
    """
    return asyncio.run(_answers(data, request))


async def _answers(data: Path, request: AdminRequest) -> tuple[str, ...]:
    texts: list[str] = []
    async for answer in ask_gateway(data, request, _warn):
        if not answer.good:
            raise Refusal(answer.text)
        texts.append(answer.text)
    return tuple(texts)


def _warn(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


# ---- when no gateway runs: its data is opened, for which a database is imported only then ----


def people_offline(options: argparse.Namespace, *, json: bool) -> tuple[str, ...]:
    """Return a line for everybody; or one list, for programs.

    Raises:
        ConfigurationError: The data or the configuration cannot be used.
    """
    return asyncio.run(_alone(options).people(json=json))


def do(
    options: argparse.Namespace, ask: AdminRequest, seeding: OfflineSeeding, *, robots: bool = False
) -> tuple[str, ...]:
    """Do what is asked and return the answers.

    People of the configuration file are taken over first, on the record if something changes:
    once they are there, the file has no say in it again.

    Args:
        options: Where the data and the configuration are.
        ask: What.
        seeding: Whether anything changes.
        robots: It cannot be answered without the robots of the configuration.

    Raises:
        RosicError: Nothing was changed; the sentence says why.
    """
    if robots and options.data is not None:
        raise ConfigurationError(
            "No gateway is running, and a data folder alone does not say which robots there are.",
            hint="Name the configuration file with -c instead of --data.",
        )
    return asyncio.run(_alone(options).do(ask, seeding))


def _alone(options: argparse.Namespace) -> OfflineAdmin:
    from rosic.app.admin.offline import OfflineAdmin  # noqa: PLC0415 - imports a database
    from rosic.app.config import load_config  # noqa: PLC0415 - and what a configuration may hold

    config = None if options.data is not None else load_config(options.config, secrets=False)
    return OfflineAdmin(data_of(options), config, SystemClock(), SystemEntropy())


def looked_up(
    options: argparse.Namespace, ask: AdminRequest, *, robots: bool = False
) -> tuple[str, ...]:
    """Return the answers to what changes nothing.

    Args:
        options: Where the gateway or its data is.
        ask: What.
        robots: It cannot be answered without the robots of the configuration.

    Raises:
        RosicError: Why not.
    """
    return _answered(options, ask, changes=False, robots=robots)


def changed(
    options: argparse.Namespace, ask: AdminRequest, *, robots: bool = False
) -> tuple[str, ...]:
    """Return the answers to what changes something.

    Args:
        options: Where the gateway or its data is.
        ask: What.
        robots: It cannot be done without the robots of the configuration.

    Raises:
        RosicError: Why not; nothing was changed.
    """
    return _answered(options, ask, changes=True, robots=robots)


def printed(answers: Sequence[str], *, json: bool) -> str:
    """Return answers as they are shown: lines, or one list of what each of them lists."""
    if not json:
        return "\n".join(answers)
    raw = [one for text in answers for one in msgspec.json.decode(text, type=list[msgspec.Raw])]
    return msgspec.json.encode(raw).decode()


def _answered(
    options: argparse.Namespace, ask: AdminRequest, *, changes: bool, robots: bool
) -> tuple[str, ...]:
    try:
        return answers(data_of(options), ask)
    except NotRunning:
        from rosic.app.admin.offline import OfflineSeeding  # noqa: PLC0415 - imports a database

        seeding = OfflineSeeding.WRITTEN if changes else OfflineSeeding.IMAGINED
        return do(options, ask, seeding, robots=robots)


# ---- lengths of time, as people write them after an option: ``2h``, ``90 min``, ``3 days`` ----

_NEGATIVE = re.compile(r"-\.?\d")


def seconds(option: str, text: str, *, zero: bool = False) -> float:
    """Return how many seconds a text says.

    Args:
        option: For the sentence.
        text: As typed.
        zero: Whether no time at all is a length here.

    Raises:
        OutOfBounds: It is no length of time, or none at all, or less.
    """
    if _NEGATIVE.match(text.strip()):
        raise OutOfBounds(f"{option} {text} is less than no time. Nothing was done.")
    try:
        said = TimeTokens(text)
    except UnclearTime:
        said = None
    length_s = None if said is None or not _is_length(said) else said.length_s
    if length_s is None:
        raise OutOfBounds(
            f"I cannot read {option} {text!r} as a length of time. Write {option} 2h, "
            f"{option} 30min or {option} 3d."
        )
    if length_s <= 0 and not zero:
        raise OutOfBounds(f"{option} {text} is no time at all. Nothing was done.")
    return length_s


def _is_length(said: TimeTokens) -> bool:
    """Whether a length is all that was said."""
    other = (said.start, said.end, said.day, said.date, said.delay_s, said.count, said.until)
    return not said.weekdays and all(part is None for part in other)


def joined(arguments: Iterable[str], options: Iterable[str]) -> list[str]:
    """Return arguments in which a negative length belongs to its option.

    Otherwise ``--for -1h`` reads as two options, and the sentence would be about that.
    """
    spans, found = set(options), list[str]()
    for word in arguments:
        if found and found[-1] in spans and _NEGATIVE.match(word):
            found[-1] = f"{found[-1]}={word}"
        else:
            found.append(word)
    return found


# ---- when this process began: what a person waits for includes importing Python ----

_STARTED_FIELD = 19  # of /proc/self/stat, counted behind the name


def begun_ns() -> int:
    """Return the monotonic clock at the start of this process; now, where it cannot be known.

    The kernel's word, within 10 ms: starting the interpreter counts, and so does starting it anew
    in the same process, which the ROS wheels do.
    """
    now_ns = SystemClock.monotonic_ns()
    try:
        fields = Path("/proc/self/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        ticks = int(fields[_STARTED_FIELD])
        age_ns = time.clock_gettime_ns(time.CLOCK_BOOTTIME) - ticks * 10**9 // os.sysconf(
            "SC_CLK_TCK"
        )
    except (OSError, ValueError, IndexError, AttributeError):
        return now_ns
    return now_ns - max(0, age_ns)
