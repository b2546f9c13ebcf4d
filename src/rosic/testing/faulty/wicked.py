"""A store that does wrong: an honest one inside, and what a sinner changes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.store import Store
    from rosic.core.records import Memory, Record
    from rosic.testing.premises import Premises


class FaultyStore:
    """An honest store inside, and a way to do wrong outside.

    Args:
        inner: The honest store.
        diary: What the sinner keeps over restarts.
    """

    def __init__(self, inner: Store, diary: dict[Any, Any]) -> None:
        self.inner = inner
        self.diary = diary

    async def open(self) -> Memory:
        """Open the honest store and tell about it."""
        return self.tell(await self.inner.open())

    def tell(self, memory: Memory) -> Memory:
        """Return what is said to be remembered."""
        return memory

    async def close(self) -> None:
        """Close the honest store."""
        await self.inner.close()

    async def write(self, *records: Record) -> None:
        """Write what is let through."""
        await self.inner.write(*(twisted for record in records for twisted in self.twist(record)))

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        """Keep what is let through."""
        for twisted in self.twist(record):
            self.inner.keep(twisted, then)

    def note(self, *records: Record) -> None:
        """Note what is let through."""
        self.inner.note(*(twisted for record in records for twisted in self.twist(record)))

    def twist(self, record: Record) -> tuple[Record, ...]:
        """Return what is written instead of a record."""
        return (record,)


class WickedPremises:
    """Premises on which every store sins in the same way."""

    def __init__(self, honest: Premises, sinner: type[FaultyStore]) -> None:
        self._honest = honest
        self._sinner = sinner
        self._diary: dict[Any, Any] = {}

    def make(self) -> FaultyStore:
        """Return a wicked store without data."""
        return self._sinner(self._honest.make(), self._diary)

    def survivor(self, store: Store) -> FaultyStore:
        """Return the wicked store that the next process would find."""
        assert isinstance(store, FaultyStore)
        return self._sinner(self._honest.survivor(store.inner), self._diary)
