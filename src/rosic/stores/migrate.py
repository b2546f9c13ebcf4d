"""Bringing a database to the present form, or saying why it cannot be."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import inspect, text

from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from sqlalchemy import Connection

MIGRATIONS = Path(__file__).with_name("migrations")
# Every form this ROSIC can read, oldest first; the steps are in migrations. Behind the dot stands
# how often a form was changed before its release: its drafts were never meant to be kept.
FORMS = ("0001.2",)
ALEMBIC_TABLE = "alembic_version"


def present(connection: Connection) -> str | None:
    """Return the form the database has; None for an empty one. Changes nothing.

    Raises:
        ConfigurationError: Something else than ROSIC wrote it.
    """
    names = inspect(connection).get_table_names()
    if not names:
        return None
    form = None
    if ALEMBIC_TABLE in names:
        form = connection.scalar(text(f"SELECT version_num FROM {ALEMBIC_TABLE}"))  # noqa: S608
    if not isinstance(form, str):
        raise ConfigurationError(
            "The database is not a record of ROSIC.", hint="Name another data folder."
        )
    return form


def check(connection: Connection) -> None:
    """See whether this ROSIC can use the database. Changes nothing.

    Raises:
        ConfigurationError: A newer ROSIC wrote it, one that was never released, or something else
            than ROSIC.
    """
    form = present(connection)
    if form is None or form in FORMS:
        return
    if number(form) in map(number, FORMS):
        raise ConfigurationError(
            "The record was written by a version of ROSIC that was never released.",
            hint="Keep the data folder for that version, and start with an empty one.",
        )
    raise ConfigurationError(
        "The record was written by a newer ROSIC.",
        hint="Install that version again, or start with an empty data folder.",
    )


def number(form: str) -> str:
    """Return which form it is, without its draft."""
    return form.partition(".")[0]


def upgrade(connection: Connection, migrations: Path = MIGRATIONS) -> None:
    """Run the missing steps, all or none; the caller's transaction holds them together."""
    if present(connection) == FORMS[-1]:
        return
    # Only here: importing Alembic takes as long as everything else at opening together.
    from alembic import command  # noqa: PLC0415
    from alembic.config import Config  # noqa: PLC0415

    config = Config()
    config.set_main_option("script_location", str(migrations).replace("%", "%%"))
    config.attributes["connection"] = connection
    command.upgrade(config, "head")
