"""What a text would be found as in what a homeserver keeps; each has been put there here."""

from __future__ import annotations

import base64
import json
import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING

import pytest

from tests.real.matrix.database import found_in
from tests.real.matrix.synapse import synapse_in

if TYPE_CHECKING:
    from pathlib import Path

    from tests.real.matrix.synapse import Synapse

TEXT = "drive 1.5 2 für „Ada“"


@pytest.fixture
def kept(tmp_path: Path) -> Synapse:
    """A homeserver that never ran, with a database that this test writes."""
    synapse = synapse_in(tmp_path)
    with closing(sqlite3.connect(synapse.database)) as database, database:
        database.execute("CREATE TABLE events (id INTEGER, said TEXT, raw BLOB)")
        database.execute("CREATE TABLE 'to \"be\" sent' (said TEXT)")
        database.execute("INSERT INTO events VALUES (1, 'nothing', NULL)")
    return synapse


def write(synapse: Synapse, statement: str, *values: object) -> None:
    with closing(sqlite3.connect(synapse.database)) as database, database:
        database.execute("PRAGMA secure_delete = OFF")  # some builds of SQLite have it on
        database.execute(statement, values)


def test_what_is_not_there_is_not_found(kept: Synapse) -> None:
    assert found_in(kept, TEXT) == []


@pytest.mark.parametrize(
    "written",
    [
        TEXT,
        json.dumps({"body": TEXT}),
        json.dumps({"body": TEXT}, ensure_ascii=False),
        f"before {TEXT} after".encode(),
        *(base64.b64encode(before + TEXT.encode() + b" after") for before in (b"", b"1", b"12")),
        base64.urlsafe_b64encode(b"1" + TEXT.encode()),
    ],
)
def test_a_cell_that_holds_it_is_found_whatever_it_is_written_as(
    kept: Synapse, written: str | bytes
) -> None:
    write(kept, "INSERT INTO events (raw) VALUES (?)", written)

    assert found_in(kept, TEXT) == ["events.raw", "homeserver.db"]


def test_every_table_is_looked_through(kept: Synapse) -> None:
    write(kept, "INSERT INTO 'to \"be\" sent' VALUES (?)", TEXT)

    assert found_in(kept, TEXT) == ['to "be" sent.said', "homeserver.db"]


def test_what_was_deleted_and_stands_in_the_file_yet_is_found(kept: Synapse) -> None:
    write(kept, "INSERT INTO events (said) VALUES (?)", TEXT)
    write(kept, "DELETE FROM events WHERE said = ?", TEXT)

    assert found_in(kept, TEXT) == ["homeserver.db"]


def test_files_of_media_are_looked_through(kept: Synapse) -> None:
    (kept.media / "local").mkdir(parents=True)
    (kept.media / "local" / "abc").write_bytes(b"\x00" + TEXT.encode())

    assert found_in(kept, TEXT) == ["media/local/abc"]
