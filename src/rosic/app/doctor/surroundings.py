"""What is around: ROS 2, and the messengers of the configuration."""

from __future__ import annotations

import asyncio
import os
from typing import TYPE_CHECKING

from rosic.app.doctor.findings import Finding, Verdict
from rosic.app.start import Checking, messenger_of
from rosic.errors import ConfigurationError, RosicError
from rosic.robots.ros2.ros import load_ros

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.app.config import Config
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger

CHECK_WITHIN_S = 15.0
LOCAL = "local"


def examine_ros(*, needed: bool) -> Finding:
    """Look for ROS 2.

    Args:
        needed: A robot of the configuration is reached over it.
    """
    try:
        load_ros()
    except ConfigurationError as missing:
        verdict = Verdict.LOOK if needed else Verdict.NOT_MEASURED
        without = "" if needed else " No robot here needs it."
        return Finding("ROS 2", verdict, f"{missing}{without}")
    distribution = os.environ.get("ROS_DISTRO", "")
    domain = os.environ.get("ROS_DOMAIN_ID", "0")
    named = f", {distribution}" if distribution else ""
    return Finding("ROS 2", Verdict.GOOD, f"found{named}, domain {domain}")


def _unchecked(messenger: Messenger) -> Finding:
    if messenger.assurance == LOCAL:
        return Finding(messenger.name, Verdict.GOOD, "local: there is no account to check")
    text = "this kind of messenger cannot check its account without listening"
    return Finding(messenger.name, Verdict.NOT_MEASURED, text)


async def examine_messengers(config: Config, clock: Clock) -> AsyncIterator[Finding]:
    """Let every messenger check its account."""
    for table in config.messengers:
        try:
            messenger = messenger_of(table, clock)
            if not isinstance(messenger, Checking):
                yield _unchecked(messenger)
                continue
            async with asyncio.timeout(CHECK_WITHIN_S):
                yield Finding(table.name, Verdict.GOOD, await messenger.check())
        except TimeoutError:
            yield Finding(table.name, Verdict.LOOK, "no answer within 15 s")
        except RosicError as error:
            yield Finding(table.name, Verdict.LOOK, str(error))
