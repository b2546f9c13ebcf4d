"""The record of a running gateway, read as anybody who may only read it could."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path


def ask_record(data: Path, query: str) -> list[Any]:
    """Ask the record in a data folder."""
    with closing(sqlite3.connect(f"file:{data}/rosic.db?mode=ro", uri=True)) as connection:
        return connection.execute(query).fetchall()


def settled(data: Path) -> int:
    """Return how many commands have an ending on disk, refusals included."""
    [[ended]] = ask_record(data, "select count(*) from endings")
    [[refused]] = ask_record(data, "select count(*) from commands where kind = 'refused'")
    return int(ended + refused)


def refused_as(data: Path, code: str) -> int:
    """Return how many commands were refused with this code."""
    rows = ask_record(data, "select code from commands where kind = 'refused'")
    return sum(1 for (found,) in rows if found == code)
