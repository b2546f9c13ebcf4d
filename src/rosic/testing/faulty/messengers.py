"""Messengers that each break one rule, to show that the rule catches them.

Each wraps an honest one. `catches` runs a rule over a faulty one; `FAULTS_BY_RULE` names one for
every rule.
"""

from __future__ import annotations

import asyncio
from contextlib import suppress
from copy import copy
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.contracts.messenger_proxy import MessengerProxy
from rosic.core.identity import Address
from rosic.core.message import MessageValidity
from rosic.core.time_units import HOUR_S, MINUTE_NS
from rosic.errors import MessageGone, MessengerFault
from rosic.testing.messengers import MessengerConformance

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.contracts.messenger import Messenger, Receive
    from rosic.core.message import Chat, Inbound, IncomingFile, Outbound
    from rosic.testing.messengers import MessengerHarness


# ---- each breaks one rule ----


class FaultyMessenger(MessengerProxy):
    """Honest so far: passes everything on. A faulty one changes one thing."""

    def __init__(self, honest: Messenger) -> None:
        super().__init__(honest)
        self.honest = honest


class Tampers(FaultyMessenger):
    """Changes what it hands over."""

    def tamper(self, inbound: Inbound) -> Inbound:
        """Change it."""
        return inbound

    async def run(self, receive: Receive) -> None:
        """Hand over something else than what came."""

        async def receive_other(inbound: Inbound) -> None:
            await receive(self.tamper(inbound))

        await self.honest.run(receive_other)


class SwallowsOne(FaultyMessenger):
    """Hands over every message but the third."""

    async def run(self, receive: Receive) -> None:
        """Lose one."""
        count = 0

        async def receive_most(inbound: Inbound) -> None:
            nonlocal count
            count += 1
            if count != 3:
                await receive(inbound)

        await self.honest.run(receive_most)


class Reorders(FaultyMessenger):
    """Hands over every pair of messages the wrong way round."""

    async def run(self, receive: Receive) -> None:
        """Hold one back until the next has passed."""
        held: list[Inbound] = []

        async def receive_swapped(inbound: Inbound) -> None:
            if held:
                await receive(inbound)
                await receive(held.pop())
            else:
                held.append(inbound)

        await self.honest.run(receive_swapped)


class TakesEverybodyForOne(Tampers):
    """Knows people by what they are called, and everybody is called the same."""

    def tamper(self, inbound: Inbound) -> Inbound:
        """Forget who it was."""
        return replace(inbound, sender=Address("somewhere", "somebody"))


class TakesEverythingForFresh(Tampers):
    """Reads the words of a message, and not how it came."""

    def tamper(self, inbound: Inbound) -> Inbound:
        """Forget how it came."""
        return replace(inbound, standing=MessageValidity.FRESH)


class DatesTheFuture(Tampers):
    """Believes a platform whose clock is ahead."""

    def tamper(self, inbound: Inbound) -> Inbound:
        """Date it after its arrival."""
        return replace(inbound, sent_ns=inbound.received_ns + MINUTE_NS)


class ConfirmsAtOnce(FaultyMessenger):
    """Confirms what it has handed over, whether or not it was received."""

    async def run(self, receive: Receive) -> None:
        """Return from receiving before it is done."""
        async with asyncio.TaskGroup() as group:

            async def receive_later(inbound: Inbound) -> None:
                group.create_task(_awaited(receive, inbound))

            await self.honest.run(receive_later)


class NumbersAnew(Tampers):
    """Gives each message a number of its own when it hands it over."""

    def __init__(self, honest: Messenger) -> None:
        super().__init__(honest)
        self.count = 0

    def tamper(self, inbound: Inbound) -> Inbound:
        """Give it the next number."""
        self.count += 1
        return replace(inbound, message=f"n{self.count}")


class OneAtATime(FaultyMessenger):
    """Hands over nothing, not even a stop, while something is being received."""

    async def run(self, receive: Receive) -> None:
        """Queue everything."""
        turn = asyncio.Lock()

        async def receive_in_turn(inbound: Inbound) -> None:
            async with turn:
                await receive(inbound)

        await self.honest.run(receive_in_turn)


class LeavesATask(FaultyMessenger):
    """Forgets something it started."""

    async def run(self, receive: Receive) -> None:
        """Start what nobody ends."""
        self.forgotten = asyncio.create_task(asyncio.sleep(HOUR_S))
        await self.honest.run(receive)


class ReadsMarkup(FaultyMessenger):
    """Takes asterisks for bold."""

    async def send(self, outbound: Outbound) -> str:
        """Lose the asterisks."""
        return await self.honest.send(replace(outbound, text=outbound.text.replace("*", "")))


class CutsLongTexts(FaultyMessenger):
    """Sends what fits and says nothing about the rest."""

    async def send(self, outbound: Outbound) -> str:
        """Lose the end."""
        return await self.honest.send(replace(outbound, text=outbound.text[:4096]))


class LosesFiles(FaultyMessenger):
    """Sends what is said of a file, and not the file."""

    async def send(self, outbound: Outbound) -> str:
        """Lose the file."""
        return await self.honest.send(replace(outbound, attachment=None))


class ChangesLineEnds(FaultyMessenger):
    """Takes every file for a text of another system."""

    async def send(self, outbound: Outbound) -> str:
        """Change what is in the file."""
        file = outbound.attachment
        if file is not None:
            changed = replace(file, content=file.content.replace(b"\n", b"\r\n"))
            outbound = replace(outbound, attachment=changed)
        return await self.honest.send(outbound)


class CutsLargeFiles(FaultyMessenger):
    """Sends as much of a file as there is room for."""

    async def send(self, outbound: Outbound) -> str:
        """Lose the end."""
        file = outbound.attachment
        if file is not None:
            content = file.content or b"what had come so far"
            cut = replace(file, content=content[: self.file_bytes or 1], pieces=None)
            outbound = replace(outbound, attachment=cut if self.file_bytes else None)
        return await self.honest.send(outbound)


class CannotChangeWhatHasAFile(FaultyMessenger):
    """Changes texts alone, not what is written under a picture."""

    def __init__(self, honest: Messenger) -> None:
        super().__init__(honest)
        self.with_files: set[str] = set()

    async def send(self, outbound: Outbound) -> str:
        """Remember what has a file."""
        message = await self.honest.send(outbound)
        if outbound.attachment is not None:
            self.with_files.add(message)
        return message

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Refuse what has a file."""
        if message in self.with_files:
            raise MessengerFault("There is no text in the message to edit.")
        await self.honest.edit(message, outbound)


class MixesUpIds(FaultyMessenger):
    """Returns the id of another message."""

    def __init__(self, honest: Messenger) -> None:
        super().__init__(honest)
        self.last = "0"

    async def send(self, outbound: Outbound) -> str:
        """Return the id of the message before."""
        before, self.last = self.last, await self.honest.send(outbound)
        return before


class SendsInsteadOfChanging(FaultyMessenger):
    """Cannot edit, and pretends that it can."""

    async def edit(self, message: str, outbound: Outbound) -> None:  # noqa: ARG002  (the sin)
        """Send another message."""
        await self.honest.send(outbound)


class RefusesTheSame(FaultyMessenger):
    """Passes on that the platform found nothing to change."""

    def __init__(self, honest: Messenger) -> None:
        super().__init__(honest)
        self.shown: dict[str, Outbound] = {}

    async def send(self, outbound: Outbound) -> str:
        """Remember what is shown."""
        message = await self.honest.send(outbound)
        self.shown[message] = outbound
        return message

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Refuse what is shown already."""
        if self.shown.get(message) == outbound:
            raise MessengerFault("The message is not modified.")
        await self.honest.edit(message, outbound)


class PretendsToPin(FaultyMessenger):
    """Says that a message is kept in sight, and does nothing."""

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:
        """Do nothing."""


class NeverUnpins(FaultyMessenger):
    """Keeps in sight for ever what was once pinned."""

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:
        """Pin in any case."""
        if pinned:
            await self.honest.pin(chat, message)


class PinsWhatIsGone(FaultyMessenger):
    """Says nothing when there is nothing to pin."""

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:
        """Pass over that the message is gone."""
        with suppress(MessageGone):
            await self.honest.pin(chat, message, pinned=pinned)


class ForgetsTheNonce(Tampers):
    """Hands over a tap as if its command had been typed."""

    def tamper(self, inbound: Inbound) -> Inbound:
        """Put the nonce into the text."""
        return replace(inbound, text=inbound.nonce or inbound.text, nonce=None)


class TakesTheBotForTheTapper(Tampers):
    """Reads who wrote the message with the button, instead of who tapped."""

    def tamper(self, inbound: Inbound) -> Inbound:
        """Say it was the bot."""
        if inbound.nonce is None:
            return inbound
        return replace(inbound, sender=Address(inbound.sender.platform, "bot"))


class RaisesWhenAnswering(FaultyMessenger):
    """Complains that a tap is too old."""

    async def answer_tap(self, inbound: Inbound, text: str) -> None:
        """Answer, then complain."""
        await self.honest.answer_tap(inbound, text)
        raise MessengerFault("The query is too old.")


class RaisesWhatItGets(FaultyMessenger):
    """Lets the exceptions of its library through."""

    async def send(self, outbound: Outbound) -> str:
        """Raise something foreign."""
        try:
            return await self.honest.send(outbound)
        except MessengerFault as fault:
            raise ConnectionResetError(str(fault)) from None


async def _awaited(receive: Receive, inbound: Inbound) -> None:
    await receive(inbound)


FAULTS_BY_RULE: dict[str, tuple[type[FaultyMessenger], ...]] = {
    "test_messages_of_a_chat_come_in_order": (SwallowsOne, Reorders),
    "test_a_message_says_who_where_and_when": (TakesEverybodyForOne, DatesTheFuture),
    "test_what_was_changed_or_passed_on_is_not_said_anew": (TakesEverythingForFresh,),
    "test_nothing_is_confirmed_before_it_was_received": (ConfirmsAtOnce,),
    "test_what_was_not_received_comes_again_as_the_same": (NumbersAnew, ConfirmsAtOnce),
    "test_a_stop_overtakes_what_is_being_received": (OneAtATime,),
    "test_nothing_is_left_running": (LeavesATask,),
    "test_a_text_arrives_exactly_as_given": (ReadsMarkup,),
    "test_a_long_text_arrives_whole": (CutsLongTexts,),
    "test_sending_names_the_message": (MixesUpIds,),
    "test_a_file_arrives_whole_and_under_its_name": (LosesFiles, ChangesLineEnds),
    "test_a_picture_arrives_and_what_is_said_of_it_can_be_changed": (
        LosesFiles,
        CannotChangeWhatHasAFile,
    ),
    "test_a_file_in_pieces_arrives_whole_or_not_at_all": (CutsLargeFiles,),
    "test_a_file_that_is_too_large_is_a_messenger_fault": (CutsLargeFiles,),
    "test_a_message_is_changed_in_place": (SendsInsteadOfChanging,),
    "test_editing_to_the_same_content_succeeds": (RefusesTheSame,),
    "test_a_message_is_kept_in_sight_until_it_is_not": (
        PretendsToPin,
        NeverUnpins,
        PinsWhatIsGone,
    ),
    "test_a_tap_brings_its_nonce_and_its_tapper": (ForgetsTheNonce, TakesTheBotForTheTapper),
    "test_answering_a_tap_never_raises": (RaisesWhenAnswering,),
    "test_every_failure_is_a_messenger_fault": (RaisesWhatItGets,),
}


def rules() -> set[str]:
    """Return the names of all rules."""
    return {name for name in dir(MessengerConformance) if name.startswith("test_")}


async def catches(rule: str, faulty: type[FaultyMessenger], stage: MessengerHarness) -> bool:
    """Whether a rule catches a faulty one on this stage."""
    faked = copy(stage)  # the same people and platform, before another messenger
    faked.messenger = faulty(stage.messenger)
    try:
        await getattr(MessengerConformance(), rule)(faked)
    except AssertionError:
        return True
    return False


# ---- each breaks one rule of files ----


class RenamesFiles(Tampers):
    """Knows better what a file should be called."""

    def tamper(self, inbound: Inbound) -> Inbound:
        """Call it otherwise."""
        if inbound.enclosed is None:
            return inbound
        return replace(inbound, enclosed=replace(inbound.enclosed, name="file.bin"))


class LiesAboutSize(Tampers):
    """Says that a file is smaller than it is."""

    def tamper(self, inbound: Inbound) -> Inbound:
        """Say a smaller size."""
        if inbound.enclosed is None:
            return inbound
        return replace(inbound, enclosed=replace(inbound.enclosed, size=10))


class LosesTheEnd(FaultyMessenger):
    """Takes what has come so far for all of it."""

    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Yield the first piece alone."""
        async for piece in self.honest.fetch(enclosure):
            yield piece[:-1]
            return


class FetchesWhateverComes(FaultyMessenger):
    """Does not count what it yields."""

    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Forget how much was said."""
        if enclosure.size > self.fetch_bytes:
            raise MessengerFault("too large")
        async for piece in self.honest.fetch(replace(enclosure, size=0)):
            yield piece


class BeginsWhatIsTooLarge(FaultyMessenger):
    """Counts only while it yields."""

    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Begin, then find out."""
        async for piece in self.honest.fetch(replace(enclosure, size=0)):
            yield piece
        if enclosure.size > self.fetch_bytes:
            raise MessengerFault("too large")


class TakesTroubleForTheEnd(FaultyMessenger):
    """Yields nothing, and says nothing, where nothing can be had."""

    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Swallow the fault."""
        try:
            async for piece in self.honest.fetch(enclosure):
                yield piece
        except MessengerFault:
            return


class FetchRaisesWhatItGets(FaultyMessenger):
    """Lets the exceptions of its library through."""

    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Raise something foreign."""
        try:
            async for piece in self.honest.fetch(enclosure):
                yield piece
        except MessengerFault as fault:
            raise ConnectionResetError(str(fault)) from None


FETCHING_FAULTS_BY_RULE: dict[str, tuple[type[FaultyMessenger], ...]] = {
    "test_a_file_of_a_person_comes_as_it_was_sent": (RenamesFiles, LiesAboutSize, LosesTheEnd),
    "test_a_file_that_is_not_as_long_as_was_said_is_a_messenger_fault": (FetchesWhateverComes,),
    "test_a_file_that_cannot_be_fetched_is_a_messenger_fault": (
        BeginsWhatIsTooLarge,
        TakesTroubleForTheEnd,
        FetchRaisesWhatItGets,
    ),
}
