"""SIGKILL while admins change things: each act is wholly there after a restart, or not at all."""

from __future__ import annotations

import multiprocessing
import time
from collections import Counter, defaultdict
from random import Random
from typing import TYPE_CHECKING, NamedTuple

import pytest

from rosic.stores.database import DatabaseStore
from rosic.system import SystemClock
from tests.pace import slowness
from tests.real.changes.process import TIMES, a_gateway, main

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.app.gateway import Gateway

# A process that has everything imported and nothing open is copied: a kill takes no second.
FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(["tests.real.changes.process"])
SEED = 20261121
LONGEST_S = 0.4
RECORD_LASTS = 30  # kills; a calendar is bounded
NEWEST = 100_000


class Found(NamedTuple):
    """What stands in the record.

    Attributes:
        wrong: A sentence for each act of which only a part is there.
        done: What was done to whom, by number, as it is said on standard output.
    """

    wrong: list[str]
    done: set[tuple[str, int]]


def killed_after(
    seconds: float, folder: Path, first: int, *, piecemeal: bool = False
) -> set[tuple[str, int]]:
    """Let a gateway run, kill it that long after it is open; return what it acknowledged."""
    ours, theirs = FORKS.Pipe(duplex=False)
    process = FORKS.Process(target=main, args=(folder, first, theirs, piecemeal), daemon=True)
    process.start()
    theirs.close()  # so that the pipe ends with the process
    with open(ours.fileno(), encoding="ascii", closefd=False) as out, ours:
        try:
            assert out.readline() == "open\n"
            time.sleep(seconds)  # the moment that chance chose
        finally:
            process.kill()
            process.join()
        said = [line.split() for line in out if line.endswith("\n")]
    assert process.exitcode == -9
    process.close()
    return {(what, int(number)) for what, number in said}


async def what_is_there(folder: Path) -> Found:
    """Start a gateway over the record, as a restart does, and look at what it knows."""
    store = DatabaseStore(folder, clock=SystemClock())
    gateway = a_gateway(store)
    await gateway.open()
    try:
        acts = Counter((act.act, act.about) for act in await store.decisions(NEWEST))
        return look(gateway, acts)
    finally:
        await gateway.close()


def look(gateway: Gateway, acts: Counter[tuple[str, str]]) -> Found:
    """Judge person by person."""
    wrong: list[str] = []
    done: set[tuple[str, int]] = set()
    access, calendar = gateway.access, gateway.rooms.organiser.calendar
    newcomers = [p for p in gateway.rooms.authoriser.directory.people() if p.name != "Ada"]
    for person in newcomers:
        number, who = int(person.name.split()[1]), person.id
        keys = access.keys.of(who)
        good = [key for key in keys if key.revoked_ns is None]
        revoked = bool(keys) and not good
        grants = gateway.authority.grants_book.grants_of(who)
        slots = calendar.of(who)
        facts = {
            "their key": len(good) == (0 if revoked else 1),
            "their two rights": len(grants) == (0 if revoked else 2),
            "one set of times": len(slots) in (0, TIMES),
            "what they gave back": not (revoked and slots),
            "their series": len({slot.series for slot in slots}) <= 1,
            "the series itself": all(calendar.series(slot.series) for slot in slots),
            "who let them in": acts["enrol", who] == 1,
            "who gave the rights": acts["grant", who] == 2,
            "who replaced the key": acts["rotate-key", keys[-1].id if keys else ""]
            == (len(keys) == 2),
            "who locked them": acts["lock", who] == access.locks.locked(who),
            "who revoked them": sum(acts["revoke-key", key.id] for key in keys) == revoked,
            "what revoking took": acts["ungrant", who] == revoked,
        }
        wrong += [f"Person {number}: {what}" for what, whole in facts.items() if not whole]
        steps = {
            "joined": True,
            "booked": bool(slots) or revoked,
            "rotated": len(keys) == 2,
            "locked": access.locks.locked(who),
            "revoked": revoked,
        }
        done |= {(step, number) for step, is_so in steps.items() if is_so}
    return Found(wrong, done)


@pytest.mark.parametrize(
    "kills",
    [
        pytest.param(10, marks=pytest.mark.limit(300)),
        pytest.param(1_000, marks=[pytest.mark.campaign, pytest.mark.limit(7_200)]),
    ],
)
async def test_no_change_is_half_applied(tmp_path: Path, kills: int) -> None:
    chance = Random(SEED)  # noqa: S311 - a seed makes it repeatable
    people = 0
    before: set[tuple[str, int]] = set()
    for number in range(kills):
        if number % RECORD_LASTS == 0:
            before = set()
        folder = tmp_path / str(number // RECORD_LASTS)
        first = max((one for _, one in before), default=-1) + 1
        said = killed_after(chance.uniform(0.0, LONGEST_S) * slowness(), folder, first)
        found = await what_is_there(folder)
        assert found.wrong == []
        assert not said - found.done, "acknowledged, and gone"
        assert not before - found.done, "it was there after the last kill"
        people += sum(what == "joined" for what, _ in found.done - before)
        before = found.done
    assert people > 2 * kills


async def test_the_kills_find_a_gateway_that_writes_piecemeal(tmp_path: Path) -> None:
    wrong: dict[str, int] = defaultdict(int)
    for number in range(40):
        folder = tmp_path / str(number)
        killed_after((0.1 + 0.02 * (number % 10)) * slowness(), folder, 0, piecemeal=True)
        for sentence in (await what_is_there(folder)).wrong:
            wrong[sentence.partition(": ")[2]] += 1
        if sum(wrong.values()) >= 2:
            return
    pytest.fail(f"forty gateways that write piecemeal were not found out: {dict(wrong)}")
