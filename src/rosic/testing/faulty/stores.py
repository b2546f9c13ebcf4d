"""Stores that break one rule each. A rule that none of them breaks proves nothing.

``FAULTS_BY_RULE`` names for every rule of ``StoreConformance`` the store that it catches.
"""

# ruff: noqa: D102 - the name of a rule is its sentence, and a faulty one's fault is its own
from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

import msgspec

from rosic.core.records import (
    Claimed,
    Concluded,
    Enrolled,
    Fact,
    KeyIssued,
    Letter,
    Memory,
    Placed,
    Record,
    Selected,
    Stopped,
    Told,
    Unfinished,
)
from rosic.errors import Repeated, StoreFault

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.store import Store
    from rosic.testing.store_fixtures import StoreFixture


# ---- an honest store inside ----


class FaultyStore:
    """An honest store inside, and a way to do wrong outside.

    Args:
        inner: The honest store.
        persisted: What the faulty one keeps over restarts.
    """

    def __init__(self, inner: Store, persisted: dict[Any, Any]) -> None:
        self.inner = inner
        self.persisted = persisted

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


class FaultyStoreFixture:
    """A fixture whose stores all break the same rule."""

    def __init__(self, honest: StoreFixture, faulty: type[FaultyStore]) -> None:
        self._honest = honest
        self._faulty = faulty
        self._persisted: dict[Any, Any] = {}

    def make(self) -> FaultyStore:
        """Return a faulty store without data."""
        return self._faulty(self._honest.make(), self._persisted)

    def survivor(self, store: Store) -> FaultyStore:
        """Return the faulty store that the next process would find."""
        assert isinstance(store, FaultyStore)
        return self._faulty(self._honest.survivor(store.inner), self._persisted)


# ---- each breaks one rule of facts ----

replace = msgspec.structs.replace


class ForgetsFacts(FaultyStore):
    """Knows only what was said today."""

    def tell(self, memory: Memory) -> Memory:
        return replace(memory, facts={})


class KeepsTheFirstFact(FaultyStore):
    """Is not to be convinced of anything else."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        if not isinstance(record, Fact):
            return (record,)
        first = self.persisted.setdefault((record.kind, record.key), record)
        return (record,) if first is record else ()


class KeepsFactsThatWereTakenBack(FaultyStore):
    """Does not hear that something is not so any more."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        return () if isinstance(record, Fact) and not record.body else (record,)


class PutsTheLatestLast(FaultyStore):
    """Takes whatever is said again for something new."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        if not isinstance(record, Fact) or not record.body:
            return (record,)
        return (replace(record, body=b"", letter=None), record)


# ---- each breaks one rule of stores ----
# A rule that none of them breaks proves nothing.


class Invents(FaultyStore):
    """Remembers a robot that never was."""

    def tell(self, memory: Memory) -> Memory:
        return replace(memory, numbers=memory.numbers | {"ghost": (1, 1)})


class AcknowledgesEarly(FaultyStore):
    """Says that it is written, and writes at the end of the day."""

    async def write(self, *records: Record) -> None:
        self.persisted.setdefault(id(self), []).append(records)

    async def close(self) -> None:
        for records in self.persisted.pop(id(self), ()):
            await self.inner.write(*records)
        await self.inner.close()


class LosesOrder(FaultyStore):
    """Writes what was asked for together the other way round."""

    async def write(self, *records: Record) -> None:
        waiting = self.persisted.setdefault("waiting", [])
        waiting.append(records)
        await asyncio.sleep(0)
        while waiting:
            await self.inner.write(*waiting.pop())


class PretendsToWrite(FaultyStore):
    """Does not mention that it failed."""

    async def write(self, *records: Record) -> None:
        try:
            await self.inner.write(*records)
        except StoreFault:
            return


class ForgetsDuplicates(FaultyStore):
    """Takes a command as often as it comes."""

    async def write(self, *records: Record) -> None:
        try:
            await self.inner.write(*records)
        except Repeated:
            return


class ForgetsDuplicatesOverNight(FaultyStore):
    """Knows the commands of today only."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        cid = getattr(record, "cid", None)
        if cid is None:
            return (record,)
        return (replace(record, cid=cid + str(id(self)).encode()),)


class WritesHalf(FaultyStore):
    """Writes a call record by record."""

    async def write(self, *records: Record) -> None:
        for record in records:
            await self.inner.write(record)


class SpoilsTheGroup(FaultyStore):
    """Lets everybody in a group fail for the one who did wrong."""

    async def write(self, *records: Record) -> None:
        self.persisted.pop("spoilt", None)
        try:
            await self.inner.write(*records)
        except Repeated:
            self.persisted["spoilt"] = True
        await asyncio.sleep(0)
        if self.persisted.get("spoilt"):
            raise Repeated("Somebody did wrong.")


class NotesLate(FaultyStore):
    """Writes notes when it has nothing better to do."""

    def note(self, *records: Record) -> None:
        self.persisted.setdefault("notes", []).extend(records)

    async def close(self) -> None:
        self.inner.note(*self.persisted.pop("notes", ()))
        await self.inner.close()


class LosesNotes(FaultyStore):
    """Has no time for notes."""

    def note(self, *records: Record) -> None:
        del records


class CanBeCalledBack(FaultyStore):
    """Does not say that nothing was written when whoever asked was cancelled."""

    async def write(self, *records: Record) -> None:
        for _ in range(3):
            await asyncio.sleep(0)
        await super().write(*records)


class SaysTooEarlyThatItIsKept(FaultyStore):
    """Does not wait for the disk."""

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        then()
        self.inner.keep(record, lambda: None)


class KeepsSilentWhenItFails(FaultyStore):
    """Forgets whoever waits once it is closed."""

    def __init__(self, inner: Store, persisted: dict[Any, Any]) -> None:
        super().__init__(inner, persisted)
        self._closed = False

    async def close(self) -> None:
        self._closed = True
        await super().close()

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        if not self._closed:
            super().keep(record, then)


class RaisesFromNotes(FaultyStore):
    """Bothers whoever leaves a note."""

    def note(self, *records: Record) -> None:
        if any(isinstance(record, Claimed) for record in records):
            raise Repeated("This was already settled.")
        super().note(*records)


class LetsNumbersFall(FaultyStore):
    """Believes the last claim, not the highest."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        if isinstance(record, Claimed):
            self.persisted[record.robot] = (record.n, record.fence)
        return (record,)

    def tell(self, memory: Memory) -> Memory:
        return replace(memory, numbers=dict(self.persisted))


class LetsGenerationsFall(FaultyStore):
    """Believes the last stop, not the highest."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        if isinstance(record, Stopped):
            self.persisted[record.robot] = record.generation
        return (record,)

    def tell(self, memory: Memory) -> Memory:
        return replace(memory, generations=dict(self.persisted))


class RevivesKeys(FaultyStore):
    """Forgets that a key was revoked."""

    def tell(self, memory: Memory) -> Memory:
        return replace(memory, keys=tuple(replace(key, revoked_ns=None) for key in memory.keys))


class RevivesKeysThatAreIssuedAgain(FaultyStore):
    """Takes issuing for more than it is."""

    def tell(self, memory: Memory) -> Memory:
        keys = tuple(
            replace(k, revoked_ns=self.persisted.get(k.id, k.revoked_ns)) for k in memory.keys
        )
        return replace(memory, keys=keys)

    def twist(self, record: Record) -> tuple[Record, ...]:
        if isinstance(record, KeyIssued):
            self.persisted[record.key.id] = None
        return (record,)


class ForgetsLives(FaultyStore):
    """Starts every day with an empty table."""

    def tell(self, memory: Memory) -> Memory:
        return replace(memory, unfinished=tuple(filter(self.keeps, memory.unfinished)))

    def keeps(self, open_order: Unfinished) -> bool:
        """Whether a life is remembered."""
        return open_order.ending is not None


class ForgetsRefusals(ForgetsLives):
    """Refuses, and does not say so."""

    def keeps(self, open_order: Unfinished) -> bool:
        """Whether a life is remembered."""
        return open_order.ending != "refused"


class ForgetsWords(FaultyStore):
    """Knows that it ended, not how to say it."""

    def tell(self, memory: Memory) -> Memory:
        unfinished = tuple(replace(open_order, words=None) for open_order in memory.unfinished)
        return replace(memory, unfinished=unfinished)


class TellsTwice(FaultyStore):
    """Does not write down what was told."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        return () if isinstance(record, Told) else (record,)


class KeepsSilentLives(FaultyStore):
    """Waits for words that never come."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        if isinstance(record, Concluded) and record.letter is None:
            return (replace(record, letter=Letter("p-ada", b"")),)
        return (record,)


class RewritesHistory(FaultyStore):
    """Lets the last outcome win."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        if isinstance(record, Concluded):
            self.persisted[record.cid] = record.ending
        return (record,)

    def tell(self, memory: Memory) -> Memory:
        open_orders = [
            replace(open_order, ending=self.persisted[open_order.cid])
            for open_order in memory.unfinished
        ]
        return replace(memory, unfinished=tuple(open_orders))


class KeepsTheFirst(FaultyStore):
    """Writes down only the first of its kind."""

    kind: type[Any]

    def twist(self, record: Record) -> tuple[Record, ...]:
        if not isinstance(record, self.kind):
            return (record,)
        mark = getattr(record, "cid", getattr(record, "chat", None))
        return (record,) if self.persisted.setdefault(mark, record) is record else ()


class KeepsTheFirstPlace(KeepsTheFirst):
    """Edits a message that has gone."""

    kind = Placed


class KeepsTheFirstChoice(KeepsTheFirst):
    """Does not hear a second choice."""

    kind = Selected


class KeepsTheFirstRoles(KeepsTheFirst):
    """Once an admin, always an admin."""

    kind = Enrolled


class KeepsWhatWasUndone(FaultyStore):
    """Does not hear that a choice was undone."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        return () if isinstance(record, Selected) and not record.robot else (record,)


class ForgetsPeople(FaultyStore):
    """Knows nobody in the morning."""

    def tell(self, memory: Memory) -> Memory:
        return replace(memory, enrolled=())


class TidiesLetters(FaultyStore):
    """Strips what it finds untidy."""

    def twist(self, record: Record) -> tuple[Record, ...]:
        letter = getattr(record, "letter", None)
        if letter is None:
            return (record,)
        return (replace(record, letter=Letter(letter.container, letter.content.strip())),)


FAULTS_BY_RULE: dict[str, type[FaultyStore]] = {
    "test_a_new_record_remembers_nothing": Invents,
    "test_what_was_written_survives": AcknowledgesEarly,
    "test_writes_keep_their_order": LosesOrder,
    "test_a_closed_record_takes_nothing": PretendsToWrite,
    "test_a_cancelled_write_leaves_when_it_is_decided": CanBeCalledBack,
    "test_a_command_is_settled_once": ForgetsDuplicates,
    "test_a_command_is_settled_once_over_a_restart": ForgetsDuplicatesOverNight,
    "test_a_repeated_call_writes_nothing": WritesHalf,
    "test_a_repeated_call_spoils_nobody_elses": SpoilsTheGroup,
    "test_notes_keep_their_order_with_writes": NotesLate,
    "test_a_note_is_written_before_closing": LosesNotes,
    "test_a_note_never_raises": RaisesFromNotes,
    "test_what_is_kept_is_written_when_it_says_so": SaysTooEarlyThatItIsKept,
    "test_what_cannot_be_kept_says_so_all_the_same": KeepsSilentWhenItFails,
    "test_numbers_never_decrease": LetsNumbersFall,
    "test_generations_never_decrease": LetsGenerationsFall,
    "test_a_revoked_key_stays_revoked": RevivesKeys,
    "test_a_key_that_is_issued_again_stays_revoked": RevivesKeysThatAreIssuedAgain,
    "test_a_claim_without_outcome_is_unfinished": ForgetsLives,
    "test_an_outcome_that_was_not_told_is_unfinished": ForgetsWords,
    "test_a_refusal_that_was_not_told_is_unfinished": ForgetsRefusals,
    "test_what_was_told_is_finished": TellsTwice,
    "test_an_outcome_without_words_is_finished": KeepsSilentLives,
    "test_the_first_outcome_counts": RewritesHistory,
    "test_the_latest_place_counts": KeepsTheFirstPlace,
    "test_the_latest_choice_counts": KeepsTheFirstChoice,
    "test_a_choice_can_be_undone": KeepsWhatWasUndone,
    "test_people_are_remembered": ForgetsPeople,
    "test_the_newest_roles_count": KeepsTheFirstRoles,
    "test_letters_come_back_as_they_were": TidiesLetters,
    "test_facts_are_remembered": ForgetsFacts,
    "test_the_newest_fact_of_a_kind_and_key_counts": KeepsTheFirstFact,
    "test_a_fact_can_be_taken_back": KeepsFactsThatWereTakenBack,
    "test_facts_stand_in_the_order_in_which_they_were_first_said": PutsTheLatestLast,
    "test_facts_asked_for_together_keep_their_order": LosesOrder,
    "test_facts_that_are_noted_keep_their_order_with_writes": NotesLate,
    "test_a_repeated_call_says_nothing_new": WritesHalf,
    "test_letters_of_facts_come_back_as_they_were": TidiesLetters,
}
