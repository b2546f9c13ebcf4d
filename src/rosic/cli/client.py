"""What commands to a running gateway share: where its data is, and how its answers are shown."""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.app.admin.control_client import ask_gateway
from rosic.app.admin.offline import OfflineAdmin, OfflineSeeding
from rosic.app.config import load_config
from rosic.config.toml_source import read_toml
from rosic.errors import ConfigurationError, Refusal
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    import argparse

    from rosic.app.admin.api import AdminRequest

CONFIG = "rosic.toml"
DATA = "rosic-data"


def add_where(parser: argparse.ArgumentParser) -> None:
    """Let a command be told which gateway is meant."""
    parser.add_argument(
        "-c", "--config", metavar="FILE", default=CONFIG, help=f"the gateway's file ({CONFIG})"
    )
    parser.add_argument("--data", metavar="FOLDER", help="its data folder, instead of the file")


def data_of(options: argparse.Namespace) -> Path:
    """Return the data folder. Nothing else of the file has to be right: a stop must get through.

    Raises:
        ConfigurationError: The file cannot be read, or its data folder is no text.
    """
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


# ---- when no gateway runs ----

LOOKS = OfflineSeeding.IMAGINED
CHANGES = OfflineSeeding.WRITTEN


def people(options: argparse.Namespace, *, json: bool) -> tuple[str, ...]:
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
    config = None if options.data is not None else load_config(options.config)
    return OfflineAdmin(data_of(options), config, SystemClock(), SystemEntropy())
