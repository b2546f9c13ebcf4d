"""A run over many modules: what is tried, what was found before, the table, and the verdict."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import time
import tomllib
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from tests.mutants.modules import Module
from tests.mutants.mutation import mutants
from tests.mutants.running import (
    KILLED,
    ORDER,
    PROFILE,
    SAME,
    SURVIVED,
    TIMED_OUT,
    UNREACHED,
    Order,
    Result,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "rosic"
PATH = os.pathsep.join((str(ROOT), str(SOURCE.parent)))  # of this source, wherever it is installed
SURVIVORS = Path(__file__).with_name("survivors.toml")
COLLECTING_S = 600.0  # a run may take so much longer than its mutants, before the first of them


class Wanted(msgspec.Struct, frozen=True, kw_only=True):
    """How much is tried.

    Attributes:
        seed: Which mutants, when not all.
        at_most: Mutants per module; 0: all.
        each_s: Tests go on for so long per mutant, of processor time.
        until_s: By the wall clock; none is begun after it.
        folder: Where results are kept, so that a run that was cut off goes on.
        keep_kills: Take for killed what other tests killed in the same source: while tests are
            written that kill the rest.
        slack_s: Tests may take so much longer than without a change before they are ended.
        again: Try once more what survived before: as on a machine that was too busy to notice.
    """

    seed: int
    at_most: int
    each_s: float
    until_s: float
    folder: Path
    keep_kills: bool = False
    slack_s: float = 10.0
    again: bool = False


class Known(msgspec.Struct, frozen=True):
    """A survivor that is listed, and why it may live."""

    file: str
    mutant: str
    why: str


class Found(msgspec.Struct):
    """What became of one module's mutants."""

    module: Module
    chosen: tuple[str, ...]
    results: dict[str, Result]
    failing: list[str]

    def count(self, *ends: str) -> int:
        """Return how many ended so."""
        return sum(result.end in ends for result in self.results.values())

    @property
    def real(self) -> int:
        """How many were tried and change the compiled code."""
        return len(self.results) - self.count(SAME)

    @property
    def killed(self) -> int:
        """How many were noticed."""
        return self.count(KILLED, TIMED_OUT)

    def survivors(self) -> list[Result]:
        """Return those that nothing noticed, in the order of the source."""
        alive = (r for r in self.results.values() if r.end in {SURVIVED, UNREACHED})
        return sorted(alive, key=lambda result: (result.line, result.id))


def tried(module: Module, wanted: Wanted, source: Path = SOURCE, root: Path = ROOT) -> Found:
    """Try the mutants of one module that were not tried before on this source by these tests."""
    file = source / module.file
    text = file.read_text(encoding="utf-8")
    chosen = _chosen(module, text, wanted)
    name = f"{module.file.replace('/', '.')}.{blake2b(text.encode(), digest_size=6).hexdigest()}"
    results = wanted.folder / f"{name}.{_digest(module, root)}.jsonl"
    earlier = sorted(wanted.folder.glob(f"{name}.*.jsonl")) if wanted.keep_kills else []
    found = _read(module, chosen, results, earlier)
    old = {result.id for result in found.survivors()} if wanted.again else set()
    left = tuple(name for name in chosen if name not in found.results or name in old)
    if left and wanted.until_s > time.time():
        seconds = max(0.0, wanted.until_s - time.time())
        order = Order(
            source=str(file),
            ids=left,
            results=str(results),
            seconds=wanted.each_s,
            slack_s=wanted.slack_s,
            until_s=wanted.until_s,
        )
        _run(module, order, results, root, seconds + COLLECTING_S)
        found = _read(module, chosen, results, earlier)
    return found


def _chosen(module: Module, text: str, wanted: Wanted) -> tuple[str, ...]:
    names = list(mutants(text))
    if not wanted.at_most or len(names) <= wanted.at_most:
        return tuple(names)
    chance = random.Random(f"{wanted.seed} {module.file}")  # noqa: S311 - a seed makes it repeatable
    return tuple(chance.sample(names, wanted.at_most))


def _digest(module: Module, root: Path) -> str:
    """Return what changes when the tests of a module change."""
    digest = blake2b(digest_size=6)
    for path in module.tests:
        place = root / path
        for file in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            digest.update(file.read_bytes())
    digest.update(Path(__file__).with_name("running.py").read_bytes())
    return digest.hexdigest()


def _read(
    module: Module, chosen: tuple[str, ...], results: Path, earlier: Iterable[Path] = ()
) -> Found:
    found = Found(module, chosen, {}, [])
    for file in earlier:
        _, before = _lines(file)
        found.results |= {r.id: r for r in before if r.end in {KILLED, TIMED_OUT, SAME}}
    if results.exists():
        found.failing, now = _lines(results)
        found.results |= {result.id: result for result in now}
    found.results = {name: r for name, r in found.results.items() if name in set(chosen)}
    return found


def _lines(file: Path) -> tuple[list[str], list[Result]]:
    """Return the tests that fail without a change, and the results."""
    first, *others = file.read_bytes().splitlines() or [b'{"failing":[]}']
    results = [line for line in others if not line.startswith(b'{"failing"')]
    return msgspec.json.decode(first)["failing"], [
        msgspec.json.decode(line, type=Result) for line in results
    ]


def _run(module: Module, order: Order, results: Path, root: Path, within_s: float) -> None:
    results.parent.mkdir(parents=True, exist_ok=True)
    request = results.with_suffix(".order")
    request.write_bytes(msgspec.json.encode(order))
    with results.with_suffix(".log").open("wb") as log:
        run = subprocess.Popen(  # noqa: S603 - the tests of this repository
            [
                sys.executable,
                "-m",
                "pytest",
                "-q",
                "--tb=no",
                "-p",
                "tests.mutants.running",
                "-pno:faker",
                "-pno:schemathesis",
                f"--hypothesis-profile={PROFILE}",
                "-o",
                "faulthandler_timeout=0",
                "-m",
                "not campaign",
                *module.tests,
            ],
            cwd=root,
            env=os.environ | {ORDER: str(request), "PYTHONPATH": PATH},
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            start_new_session=True,
        )
        try:
            run.wait(within_s)
        finally:
            if run.poll() is None:
                run.kill()
                run.wait()


# ---- the verdict ----


def listed(path: Path = SURVIVORS) -> tuple[Known, ...]:
    """Return the survivors that may live."""
    text = tomllib.loads(path.read_text(encoding="utf-8"))
    return msgspec.convert(text.get("survivor", []), tuple[Known, ...])


def unlisted(found: Iterable[Found], known: Iterable[Known]) -> list[str]:
    """Return the survivors that nobody has given a reason for, each with its place."""
    names = {(each.file, each.mutant) for each in known}
    return [
        f"src/rosic/{each.module.file}:{result.line}  {result.id}  [{result.end}]"
        for each in found
        for result in each.survivors()
        if (each.module.file, result.id) not in names
    ]


def share(found: Iterable[Found]) -> float:
    """Return how many of a hundred were noticed."""
    each = list(found)
    real = sum(one.real for one in each)
    return 100.0 * sum(one.killed for one in each) / real if real else 100.0


def table(found: list[Found]) -> str:
    """Return what became of all, a line each."""
    head = ("module", "mutants", "killed", "timed out", "survived", "not tried", "noticed")
    rows: list[tuple[str, ...]] = [
        (
            one.module.file,
            str(one.real),
            str(one.count(KILLED)),
            str(one.count(TIMED_OUT)),
            str(len(one.survivors())),
            str(len(one.chosen) - len(one.results)),
            f"{share([one]):.1f} %" if one.real else "-",
        )
        for one in found
    ]
    sums = (str(sum(int(row[i]) for row in rows)) for i in range(1, 6))
    rows.append(("all", *sums, f"{share(found):.1f} %"))
    widths = [max(len(row[i]) for row in (head, *rows)) for i in range(len(head))]
    return "\n".join(
        "  ".join(
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in (head, *rows)
    )
