"""A refusal that could not be written stands all the same (I7)."""

from __future__ import annotations

from tests.gateway.place import BrokenStore, Place


async def test_what_was_told_that_it_may_not_move_does_not_move_when_it_comes_again() -> None:
    store = BrokenStore()
    async with Place(store).open() as place:
        store.broken = True
        message = place.chat.say("omni wave")
        await place.quiet()
        assert "nothing may move" in place.chat.told[-1].outbound.text
        store.broken = False
        place.chat.deliver(message)
        await place.quiet()
        assert place.acted() == 0
