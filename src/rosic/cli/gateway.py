"""``rosic run``: the gateway itself."""

from __future__ import annotations

import argparse
import logging
import sys
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.app import runtime
from rosic.app.builder import secrets_of
from rosic.app.config import Config, load_config
from rosic.app.logging import log_to_standard_error
from rosic.app.private_memory import keep_memory_private
from rosic.app.runtime import face_of
from rosic.app.service import GatewayService
from rosic.cli.client import CONFIG, begun_ns
from rosic.cli.people import show
from rosic.config.file_permissions import open_to_others
from rosic.config.translations import of_locale
from rosic.core.i18n import in_language
from rosic.errors import RosicError
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from collections.abc import Sequence

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
    parser.add_argument("--begin-anew", action="store_true", help=BEGIN_ANEW)
    options = parser.parse_args(arguments)
    config = replace(load_config(options.config), begin_anew=options.begin_anew)
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
