"""Stops over Telegram: before everything that waits, and with nothing to lean on."""

from __future__ import annotations

import resource
import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING

import pytest

from rosic.stores.stop_latch import FileLatch
from tests.journeys.lab import Lab, lab
from tests.journeys.record import settled
from tests.pace import patience

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

CANNOT = "I cannot write down what is decided, so nothing may move. Stop still works."
STOPPED = "is stopped"


@pytest.mark.limit(400)
async def test_a_stop_overtakes_what_waits(tmp_path: Path, launcher: Launcher) -> None:
    async with lab(tmp_path, launcher) as place:
        await place.start()
        place.counter.work_s = 3.0
        await place.control.backlog(place.bo, place.bo, "bee hop", 60)
        assert await place.counter.wait_for(1, 60)

        stop = await place.say(place.ada, "stop bee")
        [said] = [
            change
            for change in await place.control.call("changes", kinds=["said"])
            if (change["chat_id"], change["message_id"]) == (place.ada, stop)
        ]
        await place.reads(place.ada, "STOP: Bee at rest")

        [stopped] = place.counter.stops("bee")
        assert stopped.at_s - said["time_s"] < 2.0 * patience()
        assert await place.until(lambda: settled(place.data) == 60)
        assert place.counter.events[-1] is stopped, "something acted after the stop"
        assert place.acted("bee") < 5

        await place.ask(place.ada, "bee hop", STOPPED)
        await place.ask(place.ada, "resume bee", "Bee is ready again.")
        before = place.acted("bee")
        await place.say(place.bo, "bee hop")
        assert await place.counter.wait_for(before + 1, 60)


@pytest.mark.limit(400)
async def test_with_the_database_locked_a_stop_works_and_outlives_a_kill(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        gateway = await place.start()
        with closing(sqlite3.connect(place.data / "rosic.db", isolation_level=None)) as other:
            other.execute("begin immediate")
            await _refuses_but_stops(place)
            gateway.kill()

        await _is_still_stopped(place)


@pytest.mark.limit(400)
async def test_with_the_disk_full_a_stop_works_and_outlives_a_kill(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        # No file may grow beyond 4 KiB any more, which is what a full disk is like for SQLite. The
        # file of stops is smaller than that from the beginning, as it is preallocated.
        gateway = await place.start()  # a stop file without its record would be a lost record
        gateway.kill()
        (place.data / "stops").unlink()
        latch = FileLatch(place.data / "stops", robots_max=16)
        latch.read()
        await latch.close()
        gateway = await place.start()
        _, hard = resource.prlimit(gateway.pid, resource.RLIMIT_FSIZE)
        resource.prlimit(gateway.pid, resource.RLIMIT_FSIZE, (4096, hard))
        await _refuses_but_stops(place)

        resource.prlimit(gateway.pid, resource.RLIMIT_FSIZE, (hard, hard))
        await place.ask(place.bo, "cat hop", "done ")

        resource.prlimit(gateway.pid, resource.RLIMIT_FSIZE, (4096, hard))
        await place.say(place.bo, "stop cat")
        await place.reads(place.bo, "STOP: Cat at rest")
        gateway.kill()
        await _is_still_stopped(place)
        await place.ask(place.bo, "cat hop", STOPPED)


async def _refuses_but_stops(place: Lab) -> None:
    await place.ask(place.bo, "ant hop", CANNOT)
    assert place.acted() == 0
    await place.say(place.ada, "stop ant")
    await place.reads(place.ada, "STOP: Ant at rest")
    assert len(place.counter.stops("ant")) == 1


async def _is_still_stopped(place: Lab) -> None:
    acted = place.acted("ant")
    await place.start()
    await place.ask(place.bo, "ant hop", STOPPED)
    assert place.acted("ant") == acted
    await place.ask(place.bo, "bee hop", "done ")
    await place.ask(place.ada, "resume ant", "Ant is ready again.")
    await place.ask(place.bo, "ant hop", "done ")
