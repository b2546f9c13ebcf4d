"""Where stores can be had, and what the next process would find in them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from rosic.contracts.store import Store
    from rosic.core.identity import CommandId
    from rosic.core.records import Memory, Unfinished


class StoreFixture(Protocol):
    """Where stores of one kind can be had."""

    def make(self) -> Store:
        """Return a store that was never opened, without any data."""
        ...

    def survivor(self, store: Store) -> Store:
        """Return what the next process would find if the one that owns ``store`` died now.

        The answer was never opened. ``store`` itself is not touched, whether open or closed.
        """
        ...


async def recall(fixture: StoreFixture, store: Store) -> Memory:
    """Return what the next process would know."""
    survivor = fixture.survivor(store)
    memory = await survivor.open()
    await survivor.close()
    return memory


async def open_orders(fixture: StoreFixture, store: Store) -> dict[CommandId, Unfinished]:
    """Return the unfinished lives that the next process would find."""
    return {open_order.cid: open_order for open_order in (await recall(fixture, store)).unfinished}
