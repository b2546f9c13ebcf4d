"""The record."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

# What stands behind the dot grows when this file is changed; after a release, it never is.
revision = "0001.2"
down_revision = None

NUMBER = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def belonging() -> sa.Column[int]:
    """Return the column that says which command a row belongs to."""
    return sa.Column(
        "seq", NUMBER, sa.ForeignKey("commands.seq"), primary_key=True, autoincrement=False
    )


def container() -> sa.Column[str]:
    """Return the column that says whose key seals the letter of a row."""
    return sa.Column("container", sa.Text, sa.ForeignKey("containers.container"))


def upgrade() -> None:
    """Make the first tables."""
    containers()
    open_orders()
    robots()
    people()
    rooms()


def containers() -> None:
    """Whose letters there are, with the keys that open them."""
    op.create_table(
        "containers",
        sa.Column("container", sa.Text, primary_key=True),
        sa.Column("wrapped", sa.LargeBinary),
    )


def open_orders() -> None:
    """Commands and what became of them."""
    op.create_table(
        "commands",
        sa.Column("seq", NUMBER, primary_key=True, autoincrement=False),
        sa.Column("cid", sa.LargeBinary, nullable=False, unique=True),
        sa.Column("kind", sa.Text, nullable=False),
        sa.Column("principal", sa.Text, nullable=False),
        sa.Column("at_ns", sa.BigInteger, nullable=False),
        sa.Column("code", sa.Text),
        sa.Column("key", sa.Text),
        sa.Column("robot", sa.Text),
        sa.Column("skill", sa.Text),
        sa.Column("n", sa.BigInteger),
        sa.Column("fence", sa.BigInteger),
        sa.Column("new_fence", sa.Boolean),
        sa.Column("stop_generation", sa.BigInteger),
        sa.Column("epoch", sa.BigInteger),
        sa.Column("digest", sa.LargeBinary),
        sa.Column("expires_ns", sa.BigInteger),
        container(),
        sa.Column("sealed", sa.LargeBinary),
    )
    op.create_table(
        "endings",
        belonging(),
        sa.Column("ending", sa.Text, nullable=False),
        sa.Column("at_ns", sa.BigInteger, nullable=False),
        container(),
        sa.Column("sealed", sa.LargeBinary),
    )
    op.create_table(
        "places",
        belonging(),
        sa.Column("container", sa.Text, sa.ForeignKey("containers.container"), nullable=False),
        sa.Column("sealed", sa.LargeBinary, nullable=False),
    )
    op.create_table("tellings", belonging(), sa.Column("at_ns", sa.BigInteger, nullable=False))
    op.create_table(
        "sifted",
        sa.Column("part", sa.Text, primary_key=True),
        sa.Column("below", sa.BigInteger, nullable=False),
    )
    op.create_table("open_lives", belonging())


def robots() -> None:
    """What is known of robots."""
    op.create_table(
        "robots",
        sa.Column("robot", sa.Text, primary_key=True),
        sa.Column("n", sa.BigInteger, nullable=False),
        sa.Column("fence", sa.BigInteger, nullable=False),
        sa.Column("generation", sa.BigInteger, nullable=False),
    )
    op.create_table(
        "stops",
        sa.Column("id", NUMBER, primary_key=True),
        sa.Column("robot", sa.Text, nullable=False),
        sa.Column("generation", sa.BigInteger, nullable=False),
        sa.Column("principal", sa.Text, nullable=False),
        sa.Column("at_ns", sa.BigInteger, nullable=False),
        sa.Column("gap", sa.Boolean, nullable=False),
    )
    op.create_table(
        "gaps",
        sa.Column("id", NUMBER, primary_key=True),
        sa.Column("at_ns", sa.BigInteger, nullable=False),
        sa.Column("lost", sa.BigInteger, nullable=False),
    )


def people() -> None:
    """Who is known, with which keys, and what they chose."""
    op.create_table(
        "principals",
        sa.Column("principal", sa.Text, primary_key=True),
        sa.Column("roles", sa.Text, nullable=False),
        sa.Column("at_ns", sa.BigInteger, nullable=False),
    )
    op.create_table(
        "cards",
        sa.Column("principal", sa.Text, sa.ForeignKey("principals.principal"), primary_key=True),
        sa.Column("container", sa.Text, sa.ForeignKey("containers.container"), nullable=False),
        sa.Column("sealed", sa.LargeBinary, nullable=False),
    )
    op.create_table(
        "keys",
        sa.Column("key", sa.Text, primary_key=True),
        sa.Column("principal", sa.Text, nullable=False),
        sa.Column("issuer", sa.Text, nullable=False),
        sa.Column("issued_ns", sa.BigInteger, nullable=False),
        sa.Column("scopes", sa.Text, nullable=False),
        sa.Column("expires_ns", sa.BigInteger),
        sa.Column("revoked_ns", sa.BigInteger),
    )
    op.create_table(
        "revocations",
        sa.Column("key", sa.Text, primary_key=True),
        sa.Column("by", sa.Text, nullable=False),
        sa.Column("at_ns", sa.BigInteger, nullable=False),
    )
    op.create_table(
        "seeds",
        sa.Column("name_digest", sa.LargeBinary, primary_key=True),
        sa.Column("principal", sa.Text, nullable=False),
    )
    op.create_table(
        "selections",
        sa.Column("principal", sa.Text, primary_key=True),
        sa.Column("chat", sa.LargeBinary, primary_key=True),
        sa.Column("robot", sa.Text, nullable=False),
    )


def rooms() -> None:
    """What the rooms know besides commands, and who decided it."""
    op.create_table(
        "facts",
        sa.Column("id", NUMBER, primary_key=True),
        sa.Column("kind", sa.Text, nullable=False),
        sa.Column("key", sa.Text, nullable=False),
        sa.Column("body", sa.LargeBinary, nullable=False),
        container(),
        sa.Column("sealed", sa.LargeBinary),
        sa.UniqueConstraint("kind", "key"),
    )
    op.create_table(
        "decisions",
        sa.Column("id", NUMBER, primary_key=True),
        sa.Column("act", sa.Text, nullable=False),
        sa.Column("by", sa.Text, nullable=False),
        sa.Column("about", sa.Text, nullable=False),
        sa.Column("at_ns", sa.BigInteger, nullable=False),
        sa.Column("digest", sa.LargeBinary, nullable=False),
    )
