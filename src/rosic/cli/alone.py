"""What commands do by themselves when no gateway runs."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.app.admin.offline import OfflineAdmin, OfflineSeeding
from rosic.app.config import load_config
from rosic.cli.client import data_of
from rosic.errors import ConfigurationError
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    import argparse

    from rosic.app.admin.asked import Ask

LOOKS = OfflineSeeding.IMAGINED
CHANGES = OfflineSeeding.WRITTEN


def people(options: argparse.Namespace, *, json: bool) -> tuple[str, ...]:
    """Return a line for everybody; or one list, for programs.

    Raises:
        ConfigurationError: The data or the configuration cannot be used.
    """
    return asyncio.run(_alone(options).people(json=json))


def do(
    options: argparse.Namespace, ask: Ask, seeding: OfflineSeeding, *, robots: bool = False
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
