"""Commands that a running gateway answers, or the data when none runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.control_client import NotRunning
from rosic.cli.client import answers, data_of

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    from rosic.app.admin.api import AdminRequest


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
        from rosic.cli import client  # noqa: PLC0415 - a database, which a running gateway has open

        seeding = client.CHANGES if changes else client.LOOKS
        return client.do(options, ask, seeding, robots=robots)
