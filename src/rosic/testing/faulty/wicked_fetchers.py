"""Messengers that break the rules about files that people send."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.errors import MessengerFault
from rosic.testing.faulty.messengers import FaultyMessenger, Tampers

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.core.message import Enclosure, Inbound


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

    async def fetch(self, enclosure: Enclosure) -> AsyncIterator[bytes]:
        """Yield the first piece alone."""
        async for piece in self.honest.fetch(enclosure):
            yield piece[:-1]
            return


class FetchesWhateverComes(FaultyMessenger):
    """Does not count what it yields."""

    async def fetch(self, enclosure: Enclosure) -> AsyncIterator[bytes]:
        """Forget how much was said."""
        if enclosure.size > self.fetch_bytes:
            raise MessengerFault("too large")
        async for piece in self.honest.fetch(replace(enclosure, size=0)):
            yield piece


class TakesTroubleForTheEnd(FaultyMessenger):
    """Yields nothing, and says nothing, where nothing can be had."""

    async def fetch(self, enclosure: Enclosure) -> AsyncIterator[bytes]:
        """Swallow the fault."""
        try:
            async for piece in self.honest.fetch(enclosure):
                yield piece
        except MessengerFault:
            return


class FetchRaisesWhatItGets(FaultyMessenger):
    """Lets the exceptions of its library through."""

    async def fetch(self, enclosure: Enclosure) -> AsyncIterator[bytes]:
        """Raise something foreign."""
        try:
            async for piece in self.honest.fetch(enclosure):
                yield piece
        except MessengerFault as fault:
            raise ConnectionResetError(str(fault)) from None


FETCHING_SINNERS: dict[str, tuple[type[FaultyMessenger], ...]] = {
    "test_a_file_of_a_person_comes_as_it_was_sent": (RenamesFiles, LiesAboutSize, LosesTheEnd),
    "test_a_file_that_is_not_as_long_as_was_said_is_a_messenger_fault": (FetchesWhateverComes,),
    "test_a_file_that_cannot_be_fetched_is_a_messenger_fault": (
        TakesTroubleForTheEnd,
        FetchRaisesWhatItGets,
    ),
}
