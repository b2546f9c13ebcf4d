"""What is refused at opening, with which sentence, and that nothing was changed by trying."""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing
from hashlib import blake2b
from typing import TYPE_CHECKING

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory

from rosic.core.records import Memory
from rosic.errors import ConfigurationError
from rosic.stores import decoding, migrate, sqlite, tables
from rosic.stores.data_dir import LOCK, StoreSettings
from rosic.stores.database import DatabaseStore
from rosic.stores.encryption import RootKey
from rosic.stores.record_mark import DATABASE
from rosic.stores.root_key import ROOT_KEY
from rosic.testing.clock import ManualClock
from rosic.testing.factories import a_claim

if TYPE_CHECKING:
    from pathlib import Path


def a_store(folder: Path, settings: StoreSettings | None = None) -> DatabaseStore:
    return DatabaseStore(folder, clock=ManualClock(), settings=settings or StoreSettings())


TROUBLE = f"""
from alembic import op
revision, down_revision = "9998", "{migrate.FORMS[-1]}"
def upgrade():
    op.drop_table("gaps")
    raise RuntimeError("in the middle")
"""


COLUMNS = """
SELECT made.name, the.name, the.type, the."notnull", the.pk
FROM sqlite_schema AS made, pragma_table_info(made.name) AS the
WHERE made.type = 'table' ORDER BY 1, the.cid
"""
INDICES = """
SELECT made.name, one."unique", the.name FROM sqlite_schema AS made,
pragma_index_list(made.name) AS one, pragma_index_info(one.name) AS the
WHERE made.type = 'table' ORDER BY 1, one.seq, the.seqno
"""


async def a_used_folder(folder: Path) -> Path:
    store = a_store(folder)
    await store.open()
    await store.write(a_claim(1))
    await store.close()
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    """Everything but the lock, which says who tried last."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != LOCK}


async def refused(folder: Path, settings: StoreSettings | None = None) -> str:
    before = contents(folder)
    with pytest.raises(ConfigurationError) as caught:
        await a_store(folder, settings).open()
    assert contents(folder) == before
    assert caught.value.hint
    return str(caught.value)


async def test_everything_is_for_the_owner_only(tmp_path: Path) -> None:
    folder = tmp_path / "deep" / "data"
    store = a_store(folder)
    await store.open()
    await store.write(a_claim(1))
    assert folder.stat().st_mode & 0o777 == 0o700
    names = {path.name for path in folder.iterdir()}
    assert names >= {DATABASE, f"{DATABASE}-wal", LOCK, ROOT_KEY}
    assert {path.stat().st_mode & 0o777 for path in folder.iterdir()} == {0o600}
    await store.close()


async def test_a_second_gateway_is_refused_until_the_first_has_gone(tmp_path: Path) -> None:
    first, second = a_store(tmp_path), a_store(tmp_path)
    await first.open()
    with pytest.raises(ConfigurationError, match=r"Another gateway is already running.*process \d"):
        await second.open()
    await first.write(a_claim(1))
    await first.close()
    assert len((await second.open()).unfinished) == 1
    await second.close()


async def test_a_failed_opening_leaves_the_folder_free(tmp_path: Path) -> None:
    folder = await a_used_folder(tmp_path)
    await refused(folder, StoreSettings(synchronous="NORMAL"))
    store = a_store(folder)
    assert len((await store.open()).unfinished) == 1
    await store.close()


@pytest.mark.parametrize("weak", ["NORMAL", "OFF"])
async def test_what_would_not_survive_a_power_cut_is_refused(tmp_path: Path, weak: str) -> None:
    folder = await a_used_folder(tmp_path)
    assert "would not survive a power cut" in await refused(folder, StoreSettings(synchronous=weak))


# What a SQLite is built with decides what it does unasked: everything is turned off first.
LAX = (
    "synchronous=OFF",
    "foreign_keys=OFF",
    "trusted_schema=ON",
    "secure_delete=OFF",
    "cell_size_check=OFF",
    "wal_autocheckpoint=7",
    "journal_size_limit=-1",
    "cache_size=7",
)
STRICT = {
    "synchronous": 2,
    "journal_mode": "wal",
    "foreign_keys": 1,
    "busy_timeout": 250,
    "trusted_schema": 0,
    "secure_delete": 1,
    "cell_size_check": 1,
    "wal_autocheckpoint": 4_000,
    "journal_size_limit": 64 << 20,
    "cache_size": -2_048,
}


async def test_the_settings_really_hold(tmp_path: Path) -> None:
    folder = await a_used_folder(tmp_path)
    with sqlite.engine_for(folder / DATABASE, StoreSettings()).connect() as connection:
        for text in LAX:
            sqlite.pragma(connection, text)
        sqlite.make_durable(connection, StoreSettings())
        assert {name: sqlite.pragma(connection, name) for name in STRICT} == STRICT


async def test_a_newer_record_is_refused(tmp_path: Path) -> None:
    folder = await a_used_folder(tmp_path)
    with sqlite3.connect(folder / DATABASE) as database:
        database.execute("UPDATE alembic_version SET version_num = '9999'")
    database.close()
    assert "written by a newer ROSIC" in await refused(folder)


@pytest.mark.parametrize("draft", ["0001", "0001.1", "0001.x"])
async def test_a_record_that_was_never_released_is_refused(tmp_path: Path, draft: str) -> None:
    """It has not all the tables; without this, the first question to one would fail."""
    folder = await a_used_folder(tmp_path)
    with sqlite3.connect(folder / DATABASE) as database:
        database.execute("UPDATE alembic_version SET version_num = ?", (draft,))
        database.execute("DROP TABLE facts")
        database.execute("DROP TABLE decisions")
    database.close()
    assert "by a version of ROSIC that was never released" in await refused(folder)


def test_whoever_changes_the_tables_of_a_form_gives_it_another_name(tmp_path: Path) -> None:
    """A record with other tables under the same name would fail with the database's own words."""
    sqlite.make_file(tmp_path / DATABASE)
    with sqlite.engine_for(tmp_path / DATABASE, StoreSettings()).connect() as connection:
        with connection.begin():
            migrate.upgrade(connection)
        made = [connection.exec_driver_sql(query).all() for query in (COLUMNS, INDICES)]
    digest = blake2b(repr(made).encode(), digest_size=8).hexdigest()
    assert (migrate.FORMS[-1], digest) == ("0001.2", "867462c65ddb4705")


async def test_somebody_elses_database_is_refused(tmp_path: Path) -> None:
    (await a_used_folder(tmp_path) / DATABASE).unlink()
    with sqlite3.connect(tmp_path / DATABASE) as database:
        database.execute("CREATE TABLE recipes (soup)")
    database.close()
    assert "not a record of ROSIC" in await refused(tmp_path)


async def test_a_file_that_is_no_database_is_refused(tmp_path: Path) -> None:
    folder = await a_used_folder(tmp_path)
    (folder / DATABASE).write_bytes(b"not a database" * 1000)
    assert "damaged" in await refused(folder)


async def test_a_damaged_page_is_refused(tmp_path: Path) -> None:
    folder = await a_used_folder(tmp_path)
    content = bytearray((folder / DATABASE).read_bytes())
    content[4096:8192] = b"\x5a" * 4096
    (folder / DATABASE).write_bytes(content)
    assert "damaged" in await refused(folder)


async def test_whichever_page_is_damaged_no_start_ends_in_anything_but_a_sentence(
    tmp_path: Path,
) -> None:
    """A small record is read whole; of a large one a damaged page may be met much later."""
    folder = await a_used_folder(tmp_path / "data")
    content = (folder / DATABASE).read_bytes()
    small, large = (
        StoreSettings(checked_bytes=len(content)),
        StoreSettings(checked_bytes=len(content) - 1),
    )
    met = []
    for at in range(0, len(content), 4096):
        other = tmp_path / f"{at}"
        shutil.copytree(folder, other)
        (other / DATABASE).write_bytes(content[:at] + b"\x5a" * 4096 + content[at + 4096 :])
        assert "damaged" in await refused(other, small)
        store, said = a_store(other, large), ""
        try:
            await store.open()
        except ConfigurationError as error:
            said = str(error)
        await store.close()
        assert not said or "damaged. Keep the file" in said, at
        met.append(bool(said))
    assert any(met)
    assert not all(met), "a large record is not read whole"


async def test_a_record_that_another_program_holds_is_refused_and_said(tmp_path: Path) -> None:
    folder = await a_used_folder(tmp_path)
    with closing(sqlite3.connect(folder / DATABASE, isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        with pytest.raises(ConfigurationError, match="another program holds the record") as caught:
            await a_store(folder, StoreSettings(busy_timeout_ms=20)).open()
        assert caught.value.hint == "Close the other program."
        other.execute("ROLLBACK")
    await a_used_folder(tmp_path / "another")
    (folder / DATABASE).unlink()
    (folder / DATABASE).mkdir()
    with pytest.raises(ConfigurationError) as caught:
        await a_store(folder).open()
    assert "other program" not in caught.value.hint


async def test_a_root_key_that_others_can_read_is_refused(tmp_path: Path) -> None:
    folder = await a_used_folder(tmp_path)
    (folder / ROOT_KEY).chmod(0o640)
    assert "can be read by others" in await refused(folder)


async def test_a_missing_root_key_is_not_made_anew(tmp_path: Path) -> None:
    folder = await a_used_folder(tmp_path)
    (folder / ROOT_KEY).unlink()
    assert "is missing" in await refused(folder)


async def test_another_root_key_is_refused(tmp_path: Path) -> None:
    folder = await a_used_folder(tmp_path)
    (folder / ROOT_KEY).write_bytes(bytes(32))
    assert "does not belong to this record" in await refused(folder)


async def test_half_a_root_key_is_refused(tmp_path: Path) -> None:
    folder = await a_used_folder(tmp_path)
    (folder / ROOT_KEY).write_bytes(bytes(16))
    assert "damaged" in await refused(folder)


async def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(ConfigurationError, match="cannot be written"):
        await a_store(tmp_path / "file" / "data").open()


async def test_the_migrations_lead_to_the_tables(tmp_path: Path) -> None:
    folder = await a_used_folder(tmp_path)
    with sqlite.engine_for(folder / DATABASE, StoreSettings()).connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, tables.metadata) == []
        referenced = connection.exec_driver_sql("PRAGMA foreign_key_list(places)").all()
        assert {row[2] for row in referenced} == {"commands", "containers"}


def test_every_migration_is_known() -> None:
    steps = ScriptDirectory(str(migrate.MIGRATIONS)).walk_revisions()
    assert tuple(step.revision for step in steps)[::-1] == migrate.FORMS


def test_a_migration_that_fails_leaves_nothing(tmp_path: Path) -> None:
    migrations, path = tmp_path / "migrations", tmp_path / DATABASE
    shutil.copytree(migrate.MIGRATIONS, migrations)
    (migrations / "versions" / "9998_trouble.py").write_text(TROUBLE)
    sqlite.make_file(path)
    with (
        sqlite.engine_for(path, StoreSettings()).connect() as connection,
        pytest.raises(RuntimeError, match="in the middle"),
        connection.begin(),
    ):
        migrate.upgrade(connection, migrations)
    with closing(sqlite3.connect(path)) as database:
        assert database.execute("SELECT name FROM sqlite_master").fetchall() == []


async def test_opening_looks_at_open_commands_only(tmp_path: Path) -> None:
    """However long the history is: no statement of opening walks through it."""
    folder = await a_used_folder(tmp_path)
    asked: list[str] = []
    with sqlite.engine_for(folder / DATABASE, StoreSettings()).connect() as connection:
        driver = connection.connection.driver_connection
        assert isinstance(driver, sqlite3.Connection)
        driver.set_trace_callback(asked.append)
        root = RootKey((folder / ROOT_KEY).read_bytes())
        assert len(decoding.RecordDecoder(connection, root).memory().unfinished) == 1
        decoding.standing(connection)
        driver.set_trace_callback(None)
        plans = [
            row[3]
            for statement in asked
            if statement.lstrip().startswith("SELECT")
            for row in driver.execute(f"EXPLAIN QUERY PLAN {statement}")
        ]
    assert not [plan for plan in plans if "TEMP B-TREE" in plan and "facts" in plan]
    walked = {plan.split()[1] for plan in plans if plan.startswith("SCAN")}
    assert "robots" in walked
    assert not walked & {"commands", "endings", "places", "tellings", "stops", "decisions"}


async def test_an_empty_folder_and_an_empty_file_are_new_records(tmp_path: Path) -> None:
    (tmp_path / DATABASE).touch(0o600)
    store = a_store(tmp_path)
    assert await store.open() == Memory()
    await store.close()
