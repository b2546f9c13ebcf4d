"""I5: what was said before a stop moves nothing after it, wherever it waited meanwhile."""

from __future__ import annotations

from rosic.core.records import Claimed
from tests.gateway.place import BO, Place, SlowStore


async def test_what_waited_while_its_robot_was_stopped_moves_nothing_after_a_resume() -> None:
    store = SlowStore(Claimed)
    async with Place(store).open() as place:
        place.chat.say("kuka1 wave")
        place.chat.say("omni wave")
        await place.clock.advance(0.3)  # within the second that it may wait for the record
        place.chat.say("stop omni")
        await place.clock.advance(0.3)
        place.chat.say("resume omni", account=BO, chat="2")
        await place.quiet()
        assert not place.robot("omni").gate.latched
        store.ready.set()
        await place.quiet()
        assert place.acted("omni") == 0, "it was received before the stop"


async def test_what_was_sent_after_a_stop_is_not_said_to_be_older_than_that() -> None:
    """All that one answer of a platform brings has one time of receiving, and stops go first."""
    store = SlowStore(Claimed)
    async with Place(store).open() as place:
        place.chat.say("kuka1 wave")
        place.chat.say("stop omni", account=BO, chat="2")
        await place.quiet()
        assert place.robot("omni").presence().at_rest
        waits = place.chat.say("omni wave")
        await place.clock.advance(0.3)  # within the second that it may wait for the record
        place.chat.say("resume omni", account=BO, chat="2")
        await place.quiet()
        assert not place.robot("omni").gate.latched
        store.ready.set()
        await place.quiet()
        assert place.acted("omni") == 0
        [told] = [sent.outbound for sent in place.chat.told if sent.outbound.cause == waits.message]
        assert told.text == "omni was stopped and resumed before I came to this. Nothing was done."
        assert [button.label for row in told.buttons for button in row] == ["omni wave"]
