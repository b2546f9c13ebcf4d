"""Everything that is looked at, in the order in which it is told."""

from __future__ import annotations

import logging
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.control_client import NotRunning, ask_gateway
from rosic.app.logging import keep_memory_private
from rosic.app.maintenance import lost
from rosic.app.setup.diagnostics_checks import (
    DiagnosticFinding,
    FindingVerdict,
    examine_clock,
    examine_disk,
    examine_graph,
    examine_messengers,
    examine_ros,
)
from rosic.app.setup.stop_test import try_robot
from rosic.app.setup.webhook_checks import examine_webhooks
from rosic.config.plugins import shared_spaces
from rosic.config.secrets import open_to_others
from rosic.core.i18n import said
from rosic.errors import RosicError
from rosic.stores.record_mark import RecordMark, was_begun

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

    from rosic.app.admin.control_socket import AdminAnswer
    from rosic.app.config import Config
    from rosic.contracts.clock import Clock, Entropy

log = logging.getLogger("rosic.doctor")

ABOUT = "data"
_LOST = str(lost(""))


async def examine_record(data: Path) -> DiagnosticFinding:
    """Ask the gateway that runs on a data folder, or look at the folder."""
    try:
        asked = ask_gateway(data, AdminRequest(AdminVerb.STATUS), log.warning)
        answers = [answer.text async for answer in asked]
    except NotRunning:
        return _of_nobody(data)
    except RosicError as silent:
        return DiagnosticFinding(ABOUT, FindingVerdict.LOOK, str(silent))
    else:
        found = next((line for text in answers for line in text.splitlines() if _LOST in line), "")
        if found:
            return DiagnosticFinding(ABOUT, FindingVerdict.LOOK, found)
        return DiagnosticFinding(
            ABOUT, FindingVerdict.GOOD, "in use by a gateway, and all of its files are there"
        )


def _of_nobody(data: Path) -> DiagnosticFinding:
    if not was_begun(data):
        return DiagnosticFinding(ABOUT, FindingVerdict.GOOD, "none yet: the first start makes it")
    try:
        RecordMark(data, begin_anew=False).look()
    except (RosicError, OSError) as wrong:
        return DiagnosticFinding(ABOUT, FindingVerdict.LOOK, str(wrong))
    return DiagnosticFinding(ABOUT, FindingVerdict.GOOD, "there, beside what goes with it")


# ---- access by others on this machine ----


def examine_memory() -> DiagnosticFinding:
    """Do here what a start does, and read it back: tokens and keys are in its memory."""
    if keep_memory_private():
        return DiagnosticFinding(
            "memory", FindingVerdict.GOOD, said("a gateway leaves no core dump, and no debugger in")
        )
    if sys.platform != "linux":
        text = said("core dumps can be kept out on Linux alone; they would hold tokens and keys")
        return DiagnosticFinding("memory", FindingVerdict.NOT_MEASURED, text)
    return DiagnosticFinding(
        "memory",
        FindingVerdict.LOOK,
        said("core dumps are not kept out; they hold tokens and keys"),
    )


def examine_openness(config: Config) -> Iterator[DiagnosticFinding]:
    """Look who may write the configuration, the profiles and the data."""
    found = tuple(open_to_others((*config.files, config.data)))
    for one in found:
        yield DiagnosticFinding("files", FindingVerdict.LOOK, str(one.error))
    if not found:
        yield DiagnosticFinding(
            "files", FindingVerdict.GOOD, "nobody else may write what it is started with"
        )


# ---- all checks ----

ROS_LINK = "ros2"
SENT = "STOP sent to "
AT_REST = re.compile(r"\ASTOP: .* \(\d+\.\d\d s\)\.\Z", re.DOTALL)
"""One robot, confirmed, of whose own stop nothing has to be said."""


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
    ros = examine_ros(needed=ROS_LINK in kinds)
    yield ros
    if config is None:
        return
    async for finding in _of_its_robots(config, here=ros.verdict is FindingVerdict.GOOD):
        yield finding
    async for finding in _of_others(config, clock):
        yield finding
    if tried:
        async for finding in _tried(config, tried, clock, entropy):
            yield finding


async def _of_its_data(config: Config | None) -> tuple[DiagnosticFinding, ...]:
    return () if config is None else (await examine_record(config.data), *examine_openness(config))


async def _of_others(config: Config, clock: Clock) -> AsyncIterator[DiagnosticFinding]:
    """Look at those elsewhere that are spoken with: messengers and webhooks."""
    async for finding in examine_messengers(config, clock):
        yield finding
    async for finding in examine_webhooks(config.webhooks):
        yield finding


async def _of_its_robots(config: Config, *, here: bool) -> AsyncIterator[DiagnosticFinding]:
    """Look at the robots.

    Args:
        config: Names them.
        here: There is ROS 2 on this machine.
    """
    if here:
        async for finding in examine_graph(r for r in config.robots if r.link.kind == ROS_LINK):
            yield finding
    for text in shared_spaces(config.robots):
        yield DiagnosticFinding("robots", FindingVerdict.LOOK, text)


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
    async for answer in ask_gateway(
        config.data, AdminRequest(AdminVerb.STOP, (name,)), log.warning
    ):
        yield DiagnosticFinding(name, verdict_of(answer), answer.text)
    text = f"by the running gateway; it stays stopped until somebody says: resume {name}"
    yield DiagnosticFinding(name, FindingVerdict.GOOD, text)
    text = "watchdog: the gateway has the robot; end it first, then try again"
    yield DiagnosticFinding(name, FindingVerdict.NOT_MEASURED, text)


def verdict_of(answer: AdminAnswer) -> FindingVerdict:
    """Judge what a gateway says of the stop of one robot."""
    well = answer.text.startswith(SENT) or AT_REST.search(answer.text) is not None
    return FindingVerdict.GOOD if answer.good and well else FindingVerdict.LOOK
