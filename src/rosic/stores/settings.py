"""How the record on disk is kept. The defaults are meant to be left alone."""

from __future__ import annotations

import msgspec


class StoreSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Bounds and durability of one record.

    Attributes:
        group_max: Calls that share one transaction.
        queue_max: Calls that may wait; one more is refused with a sentence.
        notes_max: Notes kept for later while the disk does not work; the oldest are lost first.
        lives_max: Commands whose end was never told, before further ones are refused.
        unsifted: Commands that are not sifted yet, after every sifting. At most twice as many and
            one group more are looked through at opening, and a command that is settled before so
            many others were claimed costs no row in the table of open ones.
        busy_timeout_ms: How long another program may hold the database before a write fails.
        synchronous: Anything weaker than ``FULL`` is refused at opening: it loses claims.
        pages_max: Size of the database file in pages of 4,096 bytes; None is the disk's size.
        kept_days: A command is recognised as repeated for at least this long.
        checked_bytes: A database file up to this size is read whole for damage at opening.
    """

    group_max: int = 512
    queue_max: int = 10_000
    notes_max: int = 10_000
    lives_max: int = 100_000
    unsifted: int = 1_024
    busy_timeout_ms: int = 250
    synchronous: str = "FULL"
    pages_max: int | None = None
    kept_days: int = 30
    checked_bytes: int = 64 << 20
