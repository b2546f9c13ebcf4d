"""Everything that is looked at, in the order in which it is told."""

from __future__ import annotations

import logging
import re
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.app.adapters import shared_spaces
from rosic.app.desk.asked import Ask, Verb
from rosic.app.desk.control_client import NotRunning, ask_gateway
from rosic.app.doctor.findings import Finding, Verdict
from rosic.app.doctor.machine import examine_clock, examine_disk
from rosic.app.doctor.record import examine_record
from rosic.app.doctor.secrecy import examine_memory, examine_openness
from rosic.app.doctor.surroundings import examine_messengers, examine_ros
from rosic.app.doctor.trying import try_robot
from rosic.errors import RosicError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.app.config import Config
    from rosic.app.desk.control import Answer
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
) -> AsyncIterator[Finding]:
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
        yield Finding("robots", Verdict.LOOK, text)
    async for finding in examine_messengers(config, clock):
        yield finding
    if tried:
        async for finding in _tried(config, tried, clock, entropy):
            yield finding


async def _of_its_data(config: Config | None) -> tuple[Finding, ...]:
    return () if config is None else (await examine_record(config.data), *examine_openness(config))


async def _tried(
    config: Config, name: str, clock: Clock, entropy: Entropy
) -> AsyncIterator[Finding]:
    try:
        async for finding in _asked(config, name):
            yield finding
    except NotRunning:
        try:
            async for finding in try_robot(config, name, clock, entropy):
                yield finding
        except RosicError as error:
            yield Finding(name, Verdict.LOOK, str(error))
    except RosicError as error:
        yield Finding(name, Verdict.LOOK, str(error))


async def _asked(config: Config, name: str) -> AsyncIterator[Finding]:
    """Let the running gateway stop it; a robot that somebody may be using is not moved.

    Raises:
        NotRunning: No gateway runs; nothing was done.
    """
    if all(profile.id != name for profile in config.robots):
        known = ", ".join(profile.id for profile in config.robots)
        yield Finding(name, Verdict.LOOK, f"there is no such robot; there are: {known}")
        return
    async for answer in ask_gateway(config.data, Ask(Verb.STOP, (name,)), log.warning):
        yield Finding(name, verdict_of(answer), answer.text)
    text = f"by the running gateway; it stays stopped until somebody says: resume {name}"
    yield Finding(name, Verdict.GOOD, text)
    text = "watchdog: the gateway has the robot; end it first, then try again"
    yield Finding(name, Verdict.NOT_MEASURED, text)


def verdict_of(answer: Answer) -> Verdict:
    """Judge what a gateway says of the stop of one robot."""
    well = answer.text.startswith(SENT) or AT_REST.search(answer.text) is not None
    return Verdict.GOOD if answer.good and well else Verdict.LOOK
