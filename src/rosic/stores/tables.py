"""The tables of the record as they are now. How they came to be is in ``migrations``.

A command has a small number of its own, ``seq``, given in order. Everything that follows from the
command is kept under that number, so that what happens together lies together on the disk; only
the table of commands itself is searched by the command's id. A row is written once and then left
alone; a letter stands in the row of what it was written with, so that it costs no row of its own.

No table here holds what can name a person, except sealed.
"""

from __future__ import annotations

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    ForeignKey,
    Integer,
    LargeBinary,
    MetaData,
    Table,
    Text,
    UniqueConstraint,
)

# SQLite numbers its rows with exactly this type.
NUMBER = BigInteger().with_variant(Integer(), "sqlite")

metadata = MetaData()


def belonging() -> Column[int]:
    """Return the column that says which command a row belongs to."""
    return Column("seq", NUMBER, ForeignKey("commands.seq"), primary_key=True, autoincrement=False)


def container() -> Column[str]:
    """Return the column that says whose key seals the letter of a row; NULL without a letter."""
    return Column("container", Text, ForeignKey("containers.container"))


commands = Table(
    "commands",
    metadata,
    Column("seq", NUMBER, primary_key=True, autoincrement=False),
    Column("cid", LargeBinary, nullable=False, unique=True),
    Column("kind", Text, nullable=False),
    Column("principal", Text, nullable=False),
    Column("at_ns", BigInteger, nullable=False),
    Column("code", Text),
    Column("key", Text),
    Column("robot", Text),
    Column("skill", Text),
    Column("n", BigInteger),
    Column("fence", BigInteger),
    Column("new_fence", Boolean),
    Column("stop_generation", BigInteger),
    Column("epoch", BigInteger),
    Column("digest", LargeBinary),
    Column("expires_ns", BigInteger),
    container(),
    Column("sealed", LargeBinary),
)

# An ending without a letter is told to nobody.
endings = Table(
    "endings",
    metadata,
    belonging(),
    Column("ending", Text, nullable=False),
    Column("at_ns", BigInteger, nullable=False),
    container(),
    Column("sealed", LargeBinary),
)

# Which message shows a life.
places = Table(
    "places",
    metadata,
    belonging(),
    Column("container", Text, ForeignKey("containers.container"), nullable=False),
    Column("sealed", LargeBinary, nullable=False),
)

tellings = Table(
    "tellings",
    metadata,
    belonging(),
    Column("at_ns", BigInteger, nullable=False),
)

# Up to which number the commands were sifted: of those below it, the ones whose author has not
# heard how they ended stand in ``open_lives``. A command that is settled sooner is in no table of
# open ones at all, and what has to be looked through at opening stays small, whatever the history.
sifted = Table(
    "sifted",
    metadata,
    Column("part", Text, primary_key=True),
    Column("below", BigInteger, nullable=False),
)

open_orders_of = Table("open_lives", metadata, belonging())

# ``wrapped`` is the container's key, sealed by the root key; NULL once the container was erased.
containers = Table(
    "containers",
    metadata,
    Column("container", Text, primary_key=True),
    Column("wrapped", LargeBinary),
)

# What the record knows of each robot's numbers; none of them ever falls (I13).
robots = Table(
    "robots",
    metadata,
    Column("robot", Text, primary_key=True),
    Column("n", BigInteger, nullable=False),
    Column("fence", BigInteger, nullable=False),
    Column("generation", BigInteger, nullable=False),
)

stops = Table(
    "stops",
    metadata,
    Column("id", NUMBER, primary_key=True),
    Column("robot", Text, nullable=False),
    Column("generation", BigInteger, nullable=False),
    Column("principal", Text, nullable=False),
    Column("at_ns", BigInteger, nullable=False),
    Column("gap", Boolean, nullable=False),
)

principals = Table(
    "principals",
    metadata,
    Column("principal", Text, primary_key=True),
    Column("roles", Text, nullable=False),
    Column("at_ns", BigInteger, nullable=False),
)

cards = Table(
    "cards",
    metadata,
    Column("principal", Text, ForeignKey("principals.principal"), primary_key=True),
    Column("container", Text, ForeignKey("containers.container"), nullable=False),
    Column("sealed", LargeBinary, nullable=False),
)

keys = Table(
    "keys",
    metadata,
    Column("key", Text, primary_key=True),
    Column("principal", Text, nullable=False),
    Column("issuer", Text, nullable=False),
    Column("issued_ns", BigInteger, nullable=False),
    Column("scopes", Text, nullable=False),
    Column("expires_ns", BigInteger),
    Column("revoked_ns", BigInteger),
)

# Apart from the keys, so that a key that is issued again stays revoked.
revocations = Table(
    "revocations",
    metadata,
    Column("key", Text, primary_key=True),
    Column("by", Text, nullable=False),
    Column("at_ns", BigInteger, nullable=False),
)

seeds = Table(
    "seeds",
    metadata,
    Column("name_digest", LargeBinary, primary_key=True),
    Column("principal", Text, nullable=False),
)

selections = Table(
    "selections",
    metadata,
    Column("principal", Text, primary_key=True),
    Column("chat", LargeBinary, primary_key=True),
    Column("robot", Text, nullable=False),
)

# What the rooms know besides commands: the newest of each kind and key. A row keeps its ``id``, and
# with it its place among the others, until the fact is removed.
facts = Table(
    "facts",
    metadata,
    Column("id", NUMBER, primary_key=True),
    Column("kind", Text, nullable=False),
    Column("key", Text, nullable=False),
    Column("body", LargeBinary, nullable=False),
    container(),
    Column("sealed", LargeBinary),
    UniqueConstraint("kind", "key"),
)

# Administrative acts. Rows are only ever added.
decisions = Table(
    "decisions",
    metadata,
    Column("id", NUMBER, primary_key=True),
    Column("act", Text, nullable=False),
    Column("by", Text, nullable=False),
    Column("about", Text, nullable=False),
    Column("at_ns", BigInteger, nullable=False),
    Column("digest", LargeBinary, nullable=False),
)

# Notes that could not be kept while the record was not writable: when that was noticed, how many.
gaps = Table(
    "gaps",
    metadata,
    Column("id", NUMBER, primary_key=True),
    Column("at_ns", BigInteger, nullable=False),
    Column("lost", BigInteger, nullable=False),
)
