"""What is around: ROS 2, and the messengers of the configuration."""

from __future__ import annotations

import asyncio
import os
from typing import TYPE_CHECKING

from rosic.app.builder import ConfigurationCheck, messenger_of
from rosic.app.setup.findings import DiagnosticFinding, FindingVerdict
from rosic.errors import ConfigurationError, RosicError
from rosic.robots.ros2.client.rclpy_import import load_ros

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.app.config import Config
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger

CHECK_WITHIN_S = 15.0
LOCAL = "local"


def examine_ros(*, needed: bool) -> DiagnosticFinding:
    """Look for ROS 2.

    Args:
        needed: A robot of the configuration is reached over it.
    """
    try:
        load_ros()
    except ConfigurationError as missing:
        verdict = FindingVerdict.LOOK if needed else FindingVerdict.NOT_MEASURED
        without = "" if needed else " No robot here needs it."
        return DiagnosticFinding("ROS 2", verdict, f"{missing}{without}")
    distribution = os.environ.get("ROS_DISTRO", "")
    domain = os.environ.get("ROS_DOMAIN_ID", "0")
    named = f", {distribution}" if distribution else ""
    return DiagnosticFinding("ROS 2", FindingVerdict.GOOD, f"found{named}, domain {domain}")


def _unchecked(messenger: Messenger) -> DiagnosticFinding:
    if messenger.assurance == LOCAL:
        return DiagnosticFinding(
            messenger.name, FindingVerdict.GOOD, "local: there is no account to check"
        )
    text = "this kind of messenger cannot check its account without listening"
    return DiagnosticFinding(messenger.name, FindingVerdict.NOT_MEASURED, text)


async def examine_messengers(config: Config, clock: Clock) -> AsyncIterator[DiagnosticFinding]:
    """Let every messenger check its account."""
    for table in config.messengers:
        try:
            messenger = messenger_of(table, clock)
            if not isinstance(messenger, ConfigurationCheck):
                yield _unchecked(messenger)
                continue
            async with asyncio.timeout(CHECK_WITHIN_S):
                yield DiagnosticFinding(table.name, FindingVerdict.GOOD, await messenger.check())
        except TimeoutError:
            yield DiagnosticFinding(table.name, FindingVerdict.LOOK, "no answer within 15 s")
        except RosicError as error:
            yield DiagnosticFinding(table.name, FindingVerdict.LOOK, str(error))
