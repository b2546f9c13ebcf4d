"""SIGKILL at random moments: what was acknowledged is there, whole, and in order."""

from __future__ import annotations

import random
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.core.records import Letter
from rosic.stores.database import DatabaseStore
from rosic.stores.stop_latch import FileLatch
from rosic.testing.clock import ManualClock
from rosic.testing.factories import ADA, OMNI, a_fact, an_id, told

if TYPE_CHECKING:
    from collections.abc import Iterator

PROCESS = Path(__file__).with_name("process.py")
SEED = 20261105


@contextmanager
def a_process(*arguments: object) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(  # noqa: S603 - the program stands beside the test
        [sys.executable, str(PROCESS), *map(str, arguments)], stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def killed_after(lines: int, *arguments: object) -> list[list[str]]:
    """Let a process write, kill it after so many lines, and return all that it had said."""
    with a_process(*arguments) as process:
        assert process.stdout is not None
        said = []
        for line in process.stdout:
            said.append(line)
            if len(said) == lines:
                process.kill()
    assert process.returncode == -9
    # The last line may be cut: then it was not said.
    return [line.split() for line in said if line.endswith("\n")]


async def what_is_there(folder: Path) -> tuple[list[int], set[int]]:
    """Return the numbers of claims in the order of writing, and those that lack their half."""
    store = DatabaseStore(folder, clock=ManualClock())
    memory = await store.open()
    claimed = {an_id(number): number for number in range(memory.numbers.get(OMNI, (0, 0))[0] + 1)}
    numbers = [claimed[carried.cid] for carried in memory.unfinished]
    half = {claimed[carried.cid] for carried in memory.unfinished if carried.placed != b"shown"}
    facts = {int(fact.key): fact for fact in memory.facts.get("slot", ())}
    half |= {n for n, fact in facts.items() if fact.letter != Letter(ADA, b"%d" % n)}
    acts = [int(act.about) for act in await store.decisions(len(numbers))]
    half |= set(numbers) ^ set(facts)
    half |= set(numbers) ^ set(acts)
    assert list(facts) == acts[::-1] == numbers, "in the order of the calls"
    await store.write(*(told(number) for number in numbers))
    await store.write(*(a_fact(str(number), b"") for number in numbers))
    await store.close()
    return numbers, half


def numbers_said(said: list[list[str]], word: str) -> list[int]:
    return [int(words[1]) for words in said if words[0] == word]


@pytest.mark.parametrize(
    "kills",
    [
        pytest.param(20, marks=pytest.mark.limit(300)),
        pytest.param(1000, marks=[pytest.mark.campaign, pytest.mark.limit(7200)]),
    ],
)
async def test_what_was_acknowledged_survives_a_kill(tmp_path: Path, kills: int) -> None:
    chance = random.Random(SEED)  # noqa: S311 - repeatable kills, not a secret
    first, total = 1, 0
    for _ in range(kills):
        said = killed_after(chance.randint(1, 800), tmp_path, first)
        acknowledged = numbers_said(said, "written")
        numbers, half = await what_is_there(tmp_path)
        assert not set(acknowledged) - set(numbers)
        assert not half
        assert numbers == list(range(first, first + len(numbers))), "in the order of the calls"
        stops = numbers_said(said, "stopped")
        generation, latched = FileLatch(tmp_path / "latch").read().get(OMNI, (0, False))
        assert generation >= max(stops, default=0)
        assert latched or not generation
        first += max(len(numbers), len(stops)) + 1
        first = max(first, generation + 1)
        total += len(acknowledged)
    assert total > 50 * kills


@pytest.mark.limit(120)
async def test_a_kill_while_opening_leaves_a_record(tmp_path: Path) -> None:
    """Killed anywhere between its start and its first write, the next one opens."""
    chance = random.Random(SEED)  # noqa: S311 - repeatable kills, not a secret
    for index in range(6):
        with (
            # Numbers of its own: one that was killed late has written some already.
            a_process(tmp_path / str(index % 2), 1 + index * 100_000) as process,
            pytest.raises(subprocess.TimeoutExpired),
        ):
            process.wait(chance.uniform(0.1, 0.6))
        numbers, half = await what_is_there(tmp_path / str(index % 2))
        assert not half
        assert sorted(numbers) == numbers


async def test_the_kill_finds_whoever_acknowledges_early(tmp_path: Path) -> None:
    for index in range(5):
        folder = tmp_path / str(index)
        acknowledged = numbers_said(killed_after(300, folder, 1, "early"), "written")
        numbers, _ = await what_is_there(folder)
        if set(acknowledged) - set(numbers):
            return
    pytest.fail("five processes that acknowledge early were not found out")
