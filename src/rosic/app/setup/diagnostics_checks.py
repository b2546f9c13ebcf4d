"""The machine: how long its disk takes to keep something, how its clocks behave, what is left."""

from __future__ import annotations

import asyncio
import enum
import os
import shutil
import tempfile
import time
from contextlib import closing, suppress
from importlib.util import find_spec
from pathlib import Path
from statistics import quantiles
from typing import TYPE_CHECKING, NamedTuple

from rosic.app.builder import messenger_of
from rosic.contracts.console import AccountProbe
from rosic.core.i18n import joined, said
from rosic.errors import ConfigurationError, RosicError
from rosic.robots.ros2.client.graph import snapshot, wait_for
from rosic.robots.ros2.client.rclpy_import import load_ros
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.errors import NotSent
from rosic.robots.ros2.interfaces.cache import KNOWN
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.robots.ros2.profile import ros2_profile
from rosic.robots.ros2.profile_checks import full_name, named
from rosic.stores import sqlite
from rosic.stores.data_dir import StoreSettings

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterable, Iterator

    from rosic.app.config import Config
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.robot.profile import Profile
    from rosic.robots.ros2.client.graph import GraphSnapshot
    from rosic.robots.ros2.profile import Ros2Profile


# ---- findings ----


class FindingVerdict(enum.Enum):
    """What follows from a finding; the text people read is the value."""

    GOOD = "good"
    LOOK = "look at this"
    NOT_MEASURED = "not measured"


class DiagnosticFinding(NamedTuple):
    """One finding.

    Attributes:
        about: One or two words: ``disk``, ``omni``.
        text: Figures, and what to do about them where something should be done.
    """

    about: str
    verdict: FindingVerdict
    text: str

    def __str__(self) -> str:
        mark = "" if self.verdict is FindingVerdict.GOOD else f"{self.verdict.value}: "
        return f"{self.about:<10} {mark}{self.text}"


WRITES = 200
WRITES_WITHIN_S = 3.0
PAGE = bytes(4096)
SLOW_MS = 50.0
READINGS = 100_000
DRIFT_OVER_S = 0.25
DRIFT_PPM_AT_MOST = 1_000.0
COARSE_NS = 1_000_000
LITTLE_BYTES = 500 * 10**6
FULL = 2


def examine_disk(folder: Path) -> Iterator[DiagnosticFinding]:
    """Look at the disk of a data folder; of its nearest parent while it does not exist."""
    there = _nearest(folder)
    place = ""
    if there != folder:
        place = said(" (measured in {there}: the data folder is not made yet)", there=there)
    try:
        yield _fsync(there, place)
        yield _record(there)
        free = shutil.disk_usage(there).free
    except OSError as error:
        yield DiagnosticFinding(
            "disk",
            FindingVerdict.LOOK,
            said(
                "{there} cannot be written ({error}). Give it to the user who runs ROSIC.",
                there=there,
                error=error.strerror,
            ),
        )
        return
    little = free < LITTLE_BYTES
    verdict = FindingVerdict.LOOK if little else FindingVerdict.GOOD
    left = said("{free:.1f} GB free", free=free / 1e9)
    yield DiagnosticFinding(
        "space", verdict, joined(": ", (left, said("little"))) if little else left
    )


def _nearest(folder: Path) -> Path:
    return next(path for path in (folder, *folder.parents) if path.is_dir())


def _fsync(folder: Path, place: str) -> DiagnosticFinding:
    times_ms = _time_writes(folder)
    p50, p99 = (quantiles(times_ms, n=100, method="inclusive")[i] for i in (49, 98))
    text = said(
        "fsync {p50:.2f} ms p50, {p99:.2f} ms p99 over {count} writes of 4 KiB{place}",
        p50=p50,
        p99=p99,
        count=len(times_ms),
        place=place,
    )
    if p99 > SLOW_MS:
        slow = said("{measured}. Every command waits for this.", measured=text)
        return DiagnosticFinding("disk", FindingVerdict.LOOK, slow)
    return DiagnosticFinding("disk", FindingVerdict.GOOD, text)


def _time_writes(folder: Path) -> list[float]:
    """Overwrite one page again and again, each time until the disk has it; milliseconds each."""
    with tempfile.TemporaryFile(dir=folder, prefix="doctor-") as file:
        descriptor = file.fileno()
        os.pwrite(descriptor, PAGE, 0)
        os.fsync(descriptor)
        times_ms: list[float] = []
        end_ns = time.monotonic_ns() + int(WRITES_WITHIN_S * 1e9)
        while len(times_ms) < WRITES and (len(times_ms) < 2 or time.monotonic_ns() < end_ns):  # noqa: PLR2004 - quantiles need two
            begun_ns = time.perf_counter_ns()
            os.pwrite(descriptor, PAGE, 0)
            os.fsync(descriptor)
            times_ms.append((time.perf_counter_ns() - begun_ns) / 1e6)
    return times_ms


def _record(folder: Path) -> DiagnosticFinding:
    """Set a scratch record up on this disk as a real one is, and read back what holds."""
    with tempfile.TemporaryDirectory(dir=folder, prefix="doctor-") as scratch:
        path, settings = Path(scratch) / "record.db", StoreSettings()
        sqlite.make_file(path)
        with closing(sqlite.engine_for(path, settings).connect()) as connection:
            try:
                sqlite.make_durable(connection, settings)
            except RosicError as error:
                return DiagnosticFinding("record", FindingVerdict.LOOK, str(error))
            journal = sqlite.pragma(connection, "journal_mode")
            synchronous = sqlite.pragma(connection, "synchronous")
    text = said(
        "journal mode {journal}, synchronous {synchronous} (2 is FULL), as read back",
        journal=journal,
        synchronous=synchronous,
    )
    good = journal == "wal" and isinstance(synchronous, int) and synchronous >= FULL
    return DiagnosticFinding("record", FindingVerdict.GOOD if good else FindingVerdict.LOOK, text)


async def examine_clock(clock: Clock) -> DiagnosticFinding:
    """Look at the clocks: how fine, whether they go back, whether they agree."""
    resolution_ns = time.get_clock_info("monotonic").resolution * 1e9
    backwards = _backwards(clock)
    wall_ns, monotonic_ns = clock.wall_ns(), clock.monotonic_ns()
    await clock.sleep(DRIFT_OVER_S)
    monotonic_past_ns = clock.monotonic_ns() - monotonic_ns
    ppm = abs((clock.wall_ns() - wall_ns) / monotonic_past_ns - 1) * 1e6
    text = (
        f"resolution {resolution_ns:.0f} ns, monotonic went back {backwards} times in "
        f"{READINGS:,} readings, wall clock {ppm:.0f} ppm off it over {DRIFT_OVER_S:g} s"
    )
    if backwards or resolution_ns > COARSE_NS or ppm > DRIFT_PPM_AT_MOST:
        return DiagnosticFinding(
            "clock", FindingVerdict.LOOK, f"{text}. ROSIC counts lifetimes with these."
        )
    return DiagnosticFinding("clock", FindingVerdict.GOOD, text)


def _backwards(clock: Clock) -> int:
    count, last_ns = 0, clock.monotonic_ns()
    for _ in range(READINGS):
        now_ns = clock.monotonic_ns()
        count += now_ns < last_ns
        last_ns = now_ns
    return count


# ---- ROS 2 and messengers ----

CHECK_WITHIN_S = 15.0
LOOKED_S = 4.0
"""Discovery takes up to two seconds, and services longer than topics."""
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


async def examine_graph(profiles: Iterable[Profile]) -> AsyncIterator[DiagnosticFinding]:
    """Look whether what the profiles name is on the graph now; takes a moment, and moves nothing.

    Args:
        profiles: Of robots over ROS 2; there is ROS 2 here.
    """
    wanted = {profile.id: tuple(_ends(ros2_profile(profile))) for profile in profiles}
    if not wanted:
        return
    runtime = await RosRuntime.open(TypeRegistry(()), node_name="rosic_doctor")
    async with runtime:
        with suppress(NotSent):
            await wait_for(
                runtime,
                lambda seen: not any(_missing(seen, ends) for ends in wanted.values()),
                timeout_s=LOOKED_S,
            )
        seen = await snapshot(runtime)
    for robot, ends in wanted.items():
        for package in _uninstalled(ends):
            text = (
                f"the ROS package {package} is not installed here, and its profile names types of "
                "it. Install it for your distribution, or source the workspace it is in."
            )
            yield DiagnosticFinding(robot, FindingVerdict.LOOK, text)
        missing = _missing(seen, ends)
        if not missing:
            text = f"all {len(ends)} topics, services and actions of its profile are there"
            yield DiagnosticFinding(robot, FindingVerdict.GOOD, text)
        elif len(missing) == len(ends):
            domain = os.environ.get("ROS_DOMAIN_ID", "0")
            middleware = os.environ.get("RMW_IMPLEMENTATION", "the default one")
            yield DiagnosticFinding(
                robot,
                FindingVerdict.LOOK,
                f"nothing of it is seen. Start it; if it runs, compare ROS_DOMAIN_ID ({domain} "
                f"here) and RMW_IMPLEMENTATION ({middleware} here) with what it was started with.",
            )
        else:
            for text in missing:
                yield DiagnosticFinding(robot, FindingVerdict.LOOK, text)


class _End(NamedTuple):
    """What a profile expects of others on the graph."""

    sort: str
    name: str
    type: str
    verb: str = "offers"


def _ends(profile: Ros2Profile) -> Iterator[_End]:
    """Yield what has to be there, each once."""
    found = [
        _End(sort, full_name(profile, name), kind, "takes" if sort == "topic" else "offers")
        for _, sort, name, kind in named(profile)
    ]
    if profile.at_rest is not None:
        found.append(_End("topic", profile.at_rest.topic, profile.at_rest.type, "sends"))
    found += [
        _End("topic", t.topic, t.type, "sends") for t in profile.telemetry.values() if t.topic
    ]
    yield from dict.fromkeys(found)


def _uninstalled(ends: Iterable[_End]) -> list[str]:
    """Return the packages of types that this Python does not find, and ROSIC cannot build."""
    packages = dict.fromkeys(end.type.partition("/")[0] for end in ends)
    return [name for name in packages if name not in KNOWN and find_spec(name) is None]


def _missing(seen: GraphSnapshot, ends: Iterable[_End]) -> list[str]:
    """Return what is wrong with each end that is not there as the profile says."""
    topics = {topic.name: topic for topic in seen.topics}
    offered = {"service": seen.services, "action": seen.actions}
    found: list[str] = []
    for end in ends:
        topic = topics.get(end.name)
        if end.sort == "topic":
            there = topic is not None and (
                topic.subscribers if end.verb == "takes" else topic.publishers
            )
            types = topic.types if topic is not None else ()
        else:
            [types, *_] = [*(o.types for o in offered[end.sort] if o.name == end.name), ()]
            there = bool(types)
        if not there:
            found.append(
                f"nobody {end.verb} the {end.sort} {end.name} now. Start what does, or correct "
                "the name in the profile."
            )
        elif end.type not in types:
            found.append(
                f"the {end.sort} {end.name} has the type {', '.join(types)} there, and {end.type} "
                "in the profile. Correct the profile."
            )
    return found


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
            if not isinstance(messenger, AccountProbe):
                yield _unchecked(messenger)
                continue
            async with asyncio.timeout(CHECK_WITHIN_S):
                yield DiagnosticFinding(table.name, FindingVerdict.GOOD, await messenger.check())
        except TimeoutError:
            yield DiagnosticFinding(table.name, FindingVerdict.LOOK, "no answer within 15 s")
        except RosicError as error:
            yield DiagnosticFinding(table.name, FindingVerdict.LOOK, str(error))
