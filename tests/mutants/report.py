"""The table of a campaign in the documentation: written by a run, read by a test."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from tests.mutants.campaign import ROOT, SOURCE, Found, listed, unlisted
from tests.mutants.modules import MODULES
from tests.mutants.mutation import mutants

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from tests.mutants.campaign import Known

PAGE = ROOT / "docs" / "mutants.md"
_CELLS = (
    "what",
    "module",
    "changes",
    "drawn",
    "tried",
    "noticed",
    "may live",
    "open",
    "noticed, %",
    "on",
)
HEAD = f"| {' | '.join(_CELLS)} |\n"
_COUNTS = (2, 4, 5, 6, 7)
_ALL = "all"


class Row(msgspec.Struct, frozen=True):
    """What became of one module, as it stands in the table.

    Attributes:
        about, file: As in `Module`.
        changes: So many could be made in its source at that time.
        drawn: Which of them were: ``seed 2``, or ``all``.
        tried: So many of those changed what is compiled.
        noticed: Of them.
        executor: So many survived, each with a reason.
        gaps: So many survived that nobody has looked into yet.
        on: The day, ``2026-11-25``.
    """

    about: str
    file: str
    changes: int
    drawn: str
    tried: int
    noticed: int
    executor: int
    gaps: int
    on: str

    @property
    def cells(self) -> tuple[str, ...]:
        """What stands in its line."""
        counts = (str(self.tried), str(self.noticed), str(self.executor), str(self.gaps))
        each = share_in_words(self.noticed, self.tried)
        return (self.about, f"`{self.file}`", str(self.changes), self.drawn, *counts, each, self.on)


def share_in_words(noticed: int, tried: int) -> str:
    """Return how many of a hundred, with one decimal."""
    return f"{100 * noticed / tried:.1f}" if tried else "-"


def rows_of(
    found: Iterable[Found], known: Iterable[Known], seed: int, on: str, source: Path = SOURCE
) -> dict[str, Row]:
    """Return the lines of what was tried to the end."""
    known = tuple(known)
    return {
        one.module.file: _row(one, len(unlisted([one], known)), seed, on, source)
        for one in found
        if len(one.results) == len(one.chosen)
    }


def _row(one: Found, gaps: int, seed: int, on: str, source: Path) -> Row:
    changes = len(mutants((source / one.module.file).read_text(encoding="utf-8")))
    return Row(
        one.module.about,
        one.module.file,
        changes,
        _ALL if changes == len(one.chosen) else f"seed {seed}",
        one.real,
        one.killed,
        len(one.survivors()) - gaps,
        gaps,
        on,
    )


def written(page: str, rows: dict[str, Row]) -> str:
    """Return a page with a table of these lines and, for other modules, of those it has."""
    kept = {row.file: row for row in read(page)} | rows
    mine = [kept[module.file] for module in MODULES if module.file in kept]
    before, _, after = _parted(page)
    return f"{before}{_table(mine)}{after}"


def read(page: str) -> list[Row]:
    """Return the lines of the table of a page, without its sum."""
    _, table, _ = _parted(page)
    cells = [[cell.strip() for cell in line.strip("|\n").split("|")] for line in table[2:-1]]
    return [
        Row(
            c[0], c[1].strip("`"), int(c[2]), c[3], int(c[4]), int(c[5]), int(c[6]), int(c[7]), c[9]
        )
        for c in cells
    ]


def _parted(page: str) -> tuple[str, list[str], str]:
    """Return what stands before the table, its lines, and what stands after it."""
    lines = page.splitlines(keepends=True)
    first = lines.index(HEAD)
    last = first
    while last < len(lines) and lines[last].startswith("|"):
        last += 1
    return "".join(lines[:first]), lines[first:last], "".join(lines[last:])


def _table(rows: list[Row]) -> str:
    cells = [row.cells for row in rows]
    sums = [sum(int(line[i]) for line in cells) for i in _COUNTS]
    changes, *others = map(str, sums)
    total = (_ALL, "", changes, "", *others, share_in_words(sums[2], sums[1]), "")
    rule = ["---" if i not in {*_COUNTS, 8} else "---:" for i in range(len(_CELLS))]
    return "".join(map(_line, (_CELLS, rule, *cells, total)))


def _line(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |\n".replace("|  |", "| |")


def write(found: Iterable[Found], seed: int, on: str) -> None:
    """Put what was found into the documentation."""
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(written(page, rows_of(found, listed(), seed, on)), encoding="utf-8")
