"""What commands do by themselves when no gateway runs."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.app.config import load_config
from rosic.app.offline import list_people, revoke_person
from rosic.cli.asking import data_of
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    import argparse

    from rosic.app.people import Seed


def people(options: argparse.Namespace) -> tuple[str, ...]:
    """Return a line for everybody.

    Raises:
        ConfigurationError: The data or the configuration cannot be used.
    """
    data, seeds = data_of(options), _seeds(options)
    return asyncio.run(list_people(data, seeds, SystemClock(), SystemEntropy()))


def revoke(options: argparse.Namespace) -> str:
    """Revoke ``options.name``. Return what was done.

    Raises:
        RosicError: They still have access; the sentence says why.
    """
    data, seeds = data_of(options), _seeds(options)
    return asyncio.run(revoke_person(data, options.name, seeds, SystemClock(), SystemEntropy()))


def _seeds(options: argparse.Namespace) -> tuple[Seed, ...]:
    """Return the people of the file; none when a data folder was named instead of it."""
    return () if options.data is not None else load_config(options.config).people
