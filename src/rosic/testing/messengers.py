"""What every messenger owes, in executable form.

An adapter's tests subclass `MessengerConformance` and give it a fixture ``stage``: a messenger and
the people on the other side. The faulty ones are in `rosic.testing.faulty.messengers`.
"""

from __future__ import annotations

import asyncio

from msgspec.structs import replace

from rosic.core.message import MessageValidity, Outbound
from rosic.errors import MessageGone
from rosic.testing.messenger_files import LONG, YES, EnclosureRules, FileRules
from rosic.testing.messenger_harness import (
    HarnessInbox,
    MessengerHarness,
    SeenMessage,
    faults_only,
    listening,
    until,
    until_confirmed,
    until_fresh,
)

__all__ = ("HarnessInbox", "MessengerConformance", "MessengerHarness", "SeenMessage")

MARKUP = (
    r"*bold* _slanted_ `code` [name](http://example.org) <b>bold</b> &lt; \n ~gone~ || 100 % #1 🤖"
)


class MessengerConformance(FileRules, EnclosureRules):
    """The rules. A subclass gives the fixture ``stage``."""

    async def test_messages_of_a_chat_come_in_order(self, stage: MessengerHarness) -> None:
        """Every message is handed over, once each while nothing goes wrong, and in order."""
        written = [f"omni move {number} cm" for number in range(1, 9)]
        async with listening(stage) as inbox:
            for text in written:
                for person in stage.people:
                    await stage.write(person, text)
            count = len(written) * len(stage.people)
            await until(stage, lambda: len(inbox.done) >= count, "a message was swallowed")
            for person in stage.people:
                assert inbox.texts(stage.chat(person)) == written

    async def test_a_message_says_who_where_and_when(self, stage: MessengerHarness) -> None:
        """Identity is stable and distinct, times are in order, and nothing fresh is backlog."""
        count = len(stage.people) + 1
        async with listening(stage) as inbox:
            await until_fresh(stage, inbox)
            for person in (*stage.people, stage.people[0]):
                await stage.write(person, "status")
            await until(stage, lambda: len(inbox.done) == count, "a message was swallowed")
        senders = {inbound.chat.id: inbound.sender for inbound in inbox.heard}
        assert len(set(senders.values())) == len(stage.people), "different people look the same"
        assert len({(one.chat.id, one.message) for one in inbox.heard}) == count, "an id came twice"
        for inbound in inbox.heard:
            assert inbound.sender == senders[inbound.chat.id], "one person looks like two"
            assert inbound.sender.platform == inbound.chat.platform == stage.messenger.platform
            assert inbound.listening_since_ns <= inbound.sent_ns <= inbound.received_ns
            assert inbound.standing is MessageValidity.FRESH
            assert inbound.nonce is None

    async def test_what_was_changed_or_passed_on_is_not_said_anew(
        self, stage: MessengerHarness
    ) -> None:
        """It comes as what it is, or not at all: only what is fresh may move anything (I17)."""
        person = stage.people[0]
        async with listening(stage) as inbox:
            await until_fresh(stage, inbox)
            for standing in stage.unusual:
                await stage.write_unusually(person, f"omni move {standing.value}", standing)
            await stage.write(person, "status")
            await until(
                stage, lambda: any(one.text == "status" for one in inbox.done), "it was swallowed"
            )
        for one in inbox.heard:
            word = one.text.removeprefix("omni move ")
            assert one.text in ("status", "hello") or one.standing.value == word, one

    async def test_nothing_is_confirmed_before_it_was_received(
        self, stage: MessengerHarness
    ) -> None:
        """What is being received when the power fails must come again."""
        if not stage.keeps:
            return
        async with listening(stage) as inbox:
            inbox.gate.clear()
            await stage.write(stage.people[0], "omni move 1 m")
            await until(stage, lambda: len(inbox.heard) == 1, "a message was swallowed")
            # Its being heard shows that the messenger went on, and could have confirmed.
            await stage.write(stage.people[0], "stop")
            await until(stage, lambda: len(inbox.heard) == 2, "a stop waited for another message")
            assert await stage.unconfirmed() == 2, "confirmed before it was received"
            inbox.gate.set()
            await until_confirmed(stage)

    async def test_what_was_not_received_comes_again_as_the_same(
        self, stage: MessengerHarness
    ) -> None:
        """A duplicate is recognised by who, where and which message; so these never change."""
        if not stage.keeps:
            return
        async with listening(stage) as inbox:
            inbox.gate.clear()
            await stage.write(stage.people[0], "omni move 1 m")
            await until(stage, lambda: bool(inbox.heard), "a message was swallowed")
        async with listening(stage) as again:
            await until(stage, lambda: bool(again.done), "a message did not come again")
        first, second = inbox.heard[0], again.heard[0]
        assert (first.sender, first.chat, first.message, first.text, first.sent_ns) == (
            second.sender,
            second.chat,
            second.message,
            second.text,
            second.sent_ns,
        )

    async def test_a_stop_overtakes_what_is_being_received(self, stage: MessengerHarness) -> None:
        """Nothing that takes long holds up a stop, not even in its own chat (I10)."""
        async with listening(stage) as inbox:
            inbox.gate.clear()
            await stage.write(stage.people[0], "omni move 1 m")
            await until(stage, lambda: len(inbox.heard) == 1, "a message was swallowed")
            await stage.write(stage.people[0], "stop")
            await until(stage, lambda: len(inbox.heard) == 2, "a stop waited for another message")
            inbox.gate.set()

    async def test_nothing_is_left_running(self, stage: MessengerHarness) -> None:
        """When run is cancelled, even while something is received, it leaves no task behind."""
        before = asyncio.all_tasks()
        async with listening(stage) as inbox:
            inbox.gate.clear()
            await stage.write(stage.people[0], "omni move 1 m")
            await until(stage, lambda: bool(inbox.heard), "a message was swallowed")
        await until(stage, lambda: asyncio.all_tasks() <= before, "a task was left running")

    async def test_a_text_arrives_exactly_as_given(self, stage: MessengerHarness) -> None:
        """Markup is never read out of a text."""
        person = stage.people[0]
        async with listening(stage):
            await stage.messenger.send(Outbound(chat=stage.chat(person), text=MARKUP))
        assert [seen.text for seen in await stage.screen(person)] == [MARKUP]

    async def test_a_long_text_arrives_whole(self, stage: MessengerHarness) -> None:
        """In several messages if need be; only white space may go, where it was cut."""
        person = stage.people[0]
        async with listening(stage):
            await stage.messenger.send(Outbound(chat=stage.chat(person), text=LONG))
        shown = [word for seen in await stage.screen(person) for word in seen.text.split()]
        assert shown == LONG.split()

    async def test_sending_names_the_message(self, stage: MessengerHarness) -> None:
        """Each of several sent at once is shown, under the id that was returned for it."""
        texts = {f"omni: at rest ({number})": stage.people[0] for number in range(3)}
        texts |= {f"{person}: hello": person for person in stage.people}
        async with listening(stage):
            ids = await asyncio.gather(
                *[
                    stage.messenger.send(Outbound(chat=stage.chat(person), text=text))
                    for text, person in texts.items()
                ]
            )
        for message, (text, person) in zip(ids, texts.items(), strict=True):
            assert SeenMessage(message, text) in await stage.screen(person)

    async def test_a_message_is_changed_in_place(self, stage: MessengerHarness) -> None:
        """An edit shows the new text where the old one was; who cannot do it says so."""
        messenger, person = stage.messenger, stage.people[0]
        chat = stage.chat(person)
        async with listening(stage):
            message = await messenger.send(Outbound(chat=chat, text="omni: sent"))
            change = messenger.edit(message, Outbound(chat=chat, text="omni: done"))
            if not messenger.edits:
                await faults_only("editing", change)
                return
            await change
        assert await stage.screen(person) == [SeenMessage(message, "omni: done")]

    async def test_editing_to_the_same_content_succeeds(self, stage: MessengerHarness) -> None:
        """Who edits does not know what is shown after a restart."""
        messenger, person = stage.messenger, stage.people[0]
        if not messenger.edits:
            return
        same = Outbound(chat=stage.chat(person), text="omni: done")
        async with listening(stage):
            message = await messenger.send(same)
            try:
                await messenger.edit(message, same)
                await messenger.edit(message, same)
            except Exception as error:
                raise AssertionError("editing to the same content failed") from error
        assert await stage.screen(person) == [SeenMessage(message, "omni: done")]

    async def test_a_message_is_kept_in_sight_until_it_is_not(
        self, stage: MessengerHarness
    ) -> None:
        """Both twice; one that is gone is said to be gone; who cannot do it says so."""
        messenger, person = stage.messenger, stage.people[0]
        chat = stage.chat(person)
        async with listening(stage):
            message = await messenger.send(Outbound(chat=chat, text="omni: free"))
            if not messenger.pins:
                await faults_only("pinning", messenger.pin(chat, message))
                return
            for _ in range(2):
                await messenger.pin(chat, message)
                assert await stage.pinned(person) == [message], "it is not kept in sight"
            for _ in range(2):
                await messenger.pin(chat, message, pinned=False)
                assert await stage.pinned(person) == [], "it is still kept in sight"
            try:
                await messenger.pin(chat, "999999")
            except MessageGone:
                return
        raise AssertionError("a message that is not there was pinned")

    async def test_a_tap_brings_its_nonce_and_its_tapper(self, stage: MessengerHarness) -> None:
        """The nonce travels, never the command; it is dated when it is received."""
        if not stage.taps:
            return
        person = stage.people[-1]
        offer = Outbound(chat=stage.chat(person), text="omni: move 1 m?", buttons=((YES,),))
        async with listening(stage) as inbox:
            await stage.write(person, "hello")
            message = await stage.messenger.send(offer)
            await stage.tap(person, message, YES.label)
            await until(stage, lambda: len(inbox.done) == 2, "a tap was swallowed")
        said, tapped = inbox.heard
        assert (tapped.nonce, tapped.text, tapped.under) == (YES.nonce, "", message)
        assert (tapped.sender, tapped.chat) == (said.sender, said.chat)
        assert tapped.sent_ns == tapped.received_ns
        assert tapped.tap

    async def test_answering_a_tap_never_raises(self, stage: MessengerHarness) -> None:
        """Not twice, not with a handle nobody knows, not while the platform is away."""
        person = stage.people[0]
        chat = stage.chat(person)
        async with listening(stage) as inbox:
            await stage.write(person, "hello")
            await until(stage, lambda: bool(inbox.done), "a message was swallowed")
            tap = replace(inbox.heard[0], chat=chat, nonce=YES.nonce, tap="12345678", text="")
            try:
                await stage.messenger.answer_tap(tap, "")
                await stage.messenger.answer_tap(tap, "This was not asked of you. " * 20)
                async with stage.outage():
                    await stage.messenger.answer_tap(tap, "Too late.")
            except Exception as error:
                raise AssertionError("answering a tap raised") from error

    async def test_every_failure_is_a_messenger_fault(self, stage: MessengerHarness) -> None:
        """Whatever library is underneath, none of its exceptions comes through."""
        messenger, person = stage.messenger, stage.people[0]
        outbound = Outbound(chat=stage.chat(person), text="omni: done")
        async with listening(stage):
            message = await messenger.send(outbound)
            await faults_only("editing what is not there", messenger.edit("999999", outbound))
            async with stage.outage():
                await faults_only("sending into an outage", messenger.send(outbound))
                await faults_only("editing into an outage", messenger.edit(message, outbound))
