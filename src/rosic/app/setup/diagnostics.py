"""Everything that is looked at, in the order in which it is told."""

from __future__ import annotations

import logging
import re
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.app.admin.asked import Ask, Verb
from rosic.app.admin.control_client import NotRunning, ask_gateway
from rosic.app.setup.diagnostics_checks import examine_clock, examine_disk
from rosic.app.setup.diagnostics_record import examine_record
from rosic.app.setup.diagnostics_secrecy import examine_memory, examine_openness
from rosic.app.setup.findings import DiagnosticFinding, FindingVerdict
from rosic.app.setup.stop_test import try_robot
from rosic.app.setup.surroundings import examine_messengers, examine_ros
from rosic.config.plugins import shared_spaces
from rosic.errors import RosicError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.app.admin.control_socket import Answer
    from rosic.app.config import Config
    from rosic.contracts.clock import Clock
    from rosic.contracts.entropy import Entropy

ROS_LINK = "ros2"
SENT = "STOP sent to "
AT_REST = re.compile(r"\ASTOP: .* \(\d+\.\d\d s\)\.\Z", re.DOTALL)
"""One robot, confirmed, of whose own stop nothing has to be said."""

log = logging.getLogger("rosic.doctor")


async def examine(
    config: Config | None,
    *,
    tried: str = "",
    clock: Clock,
    entropy: Entropy,
) -> AsyncIterator[DiagnosticFinding]:
    """Look at everything, and yield findings as they come.

    Args:
        config: None looks at the machine alone, and at the disk of the present folder.
        tried: A robot of the configuration to try; it moves. Empty tries none.
        clock: The machine's.
        entropy: For the ids of what a trial does.
    """
    for finding in examine_disk(config.data if config else Path.cwd()):
        yield finding
    for finding in await _of_its_data(config):
        yield finding
    yield examine_memory()
    yield await examine_clock(clock)
    kinds = {profile.link.kind for profile in config.robots} if config else set()
    yield examine_ros(needed=ROS_LINK in kinds)
    if config is None:
        return
    for text in shared_spaces(config.robots):
        yield DiagnosticFinding("robots", FindingVerdict.LOOK, text)
    async for finding in examine_messengers(config, clock):
        yield finding
    if tried:
        async for finding in _tried(config, tried, clock, entropy):
            yield finding


async def _of_its_data(config: Config | None) -> tuple[DiagnosticFinding, ...]:
    return () if config is None else (await examine_record(config.data), *examine_openness(config))


async def _tried(
    config: Config, name: str, clock: Clock, entropy: Entropy
) -> AsyncIterator[DiagnosticFinding]:
    try:
        async for finding in _asked(config, name):
            yield finding
    except NotRunning:
        try:
            async for finding in try_robot(config, name, clock, entropy):
                yield finding
        except RosicError as error:
            yield DiagnosticFinding(name, FindingVerdict.LOOK, str(error))
    except RosicError as error:
        yield DiagnosticFinding(name, FindingVerdict.LOOK, str(error))


async def _asked(config: Config, name: str) -> AsyncIterator[DiagnosticFinding]:
    """Let the running gateway stop it; a robot that somebody may be using is not moved.

    Raises:
        NotRunning: No gateway runs; nothing was done.
    """
    if all(profile.id != name for profile in config.robots):
        known = ", ".join(profile.id for profile in config.robots)
        yield DiagnosticFinding(
            name, FindingVerdict.LOOK, f"there is no such robot; there are: {known}"
        )
        return
    async for answer in ask_gateway(config.data, Ask(Verb.STOP, (name,)), log.warning):
        yield DiagnosticFinding(name, verdict_of(answer), answer.text)
    text = f"by the running gateway; it stays stopped until somebody says: resume {name}"
    yield DiagnosticFinding(name, FindingVerdict.GOOD, text)
    text = "watchdog: the gateway has the robot; end it first, then try again"
    yield DiagnosticFinding(name, FindingVerdict.NOT_MEASURED, text)


def verdict_of(answer: Answer) -> FindingVerdict:
    """Judge what a gateway says of the stop of one robot."""
    well = answer.text.startswith(SENT) or AT_REST.search(answer.text) is not None
    return FindingVerdict.GOOD if answer.good and well else FindingVerdict.LOOK
