"""What a messenger's platform counts over a restart is on record, by messenger."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.app.messenger_setup import SAID_LATELY
from rosic.messengers.memory import MemoryMessenger
from rosic.stores.memory import MemoryStore
from tests.gateway.place import Place

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.contracts.messenger import Keep


class Counted(MemoryMessenger):
    """Speaks on a platform that counts."""

    kept: Mapping[str, bytes]
    keep: Keep

    def keep_pace(self, kept: Mapping[str, bytes], keep: Keep) -> None:
        self.kept, self.keep = kept, keep


async def test_the_next_run_goes_on_with_what_was_kept() -> None:
    store = MemoryStore()
    async with Place(store, chat=lambda clock: Counted("memory", clock=clock)).open() as place:
        assert isinstance(place.chat, Counted)
        assert place.chat.kept == {}
        place.chat.keep("a", b"1")
        place.chat.keep("b", b"2")
        place.chat.keep("b", b"")
    facts = (await store.open()).facts[SAID_LATELY]
    assert [(fact.key, fact.body) for fact in facts] == [("memory:a", b"1")]
    async with Place(store, chat=lambda clock: Counted("memory", clock=clock)).open() as place:
        assert isinstance(place.chat, Counted)
        assert place.chat.kept == {"a": b"1"}
    async with Place(store, chat=lambda clock: Counted("other", clock=clock)).open() as place:
        assert isinstance(place.chat, Counted)
        assert place.chat.kept == {}
