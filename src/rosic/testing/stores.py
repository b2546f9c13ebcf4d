"""What every record must do, in executable form.

Subclass ``StoreConformance`` and give it a fixture named ``fixture``; pytest does the rest. Each
rule is known to fail on a store that breaks it: ``rosic.testing.faulty.stores``.
"""
# ruff: noqa: D102 - the name of a rule is its sentence

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.core.records import KeyIssued, KeyRevoked, Letter, Memory, Seeded, Unfinished
from rosic.errors import Repeated, StoreFault
from rosic.testing.fact_rules import FactRules
from rosic.testing.factories import (
    ADA,
    AWKWARD,
    KUKA,
    OMNI,
    a_choice,
    a_claim,
    a_conclusion,
    a_key,
    a_place,
    a_refusal,
    a_resumption,
    a_stop,
    an_enrolment,
    an_id,
    told,
)
from rosic.testing.store_fixtures import StoreFixture, open_orders, recall

if TYPE_CHECKING:
    from rosic.contracts.store import Store


PATIENCE_S = 10.0


class StoreConformance(FactRules):
    """The rules. Each opens a store of its own and closes it."""

    # ---- durable, whole, in order ----

    async def test_a_new_record_remembers_nothing(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        assert await store.open() == Memory()
        await store.close()

    async def test_what_was_written_survives(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1))
        assert an_id(1) in await open_orders(fixture, store)
        await store.close()
        assert an_id(1) in await open_orders(fixture, store)

    async def test_writes_keep_their_order(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        robots = [f"robot{index}" for index in range(20)]
        await asyncio.gather(*(store.write(a_choice(robot)) for robot in robots))
        assert (await recall(fixture, store)).selected == (a_choice(robots[-1]),)
        await store.close()

    async def test_a_closed_record_takes_nothing(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.close()
        await store.close()
        with pytest.raises(StoreFault):
            await store.write(a_claim(1))

    async def test_a_cancelled_write_leaves_when_it_is_decided(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        writing = asyncio.ensure_future(store.write(a_claim(1)))
        await asyncio.sleep(0)
        writing.cancel()
        written = True
        try:
            await writing
        except asyncio.CancelledError as cancelled:
            written = cancelled.__cause__ is None
        assert (an_id(1) in await open_orders(fixture, store)) is written
        await store.close()

    # ---- once ----

    async def test_a_command_is_settled_once(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        kinds = (a_claim, a_refusal, a_resumption)
        for first in kinds:
            for second in kinds:
                name = (first.__name__, second.__name__)
                await store.write(first(name))
                with pytest.raises(Repeated):
                    await store.write(second(name))
        with pytest.raises(Repeated):
            await store.write(a_claim("twice at once"), a_refusal("twice at once"))
        await store.close()

    async def test_a_command_is_settled_once_over_a_restart(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1), a_conclusion(1), told(1))
        survivor = fixture.survivor(store)
        await survivor.open()
        with pytest.raises(Repeated):
            await survivor.write(a_claim(1))
        await survivor.close()
        await store.close()

    async def test_a_repeated_call_writes_nothing(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1))
        with pytest.raises(Repeated):
            await store.write(a_choice(KUKA), a_claim(2, n=9), a_claim(1), a_stop(4))
        memory = await recall(fixture, store)
        assert memory.selected == ()
        assert memory.generations == {}
        assert memory.numbers == {OMNI: (1, 1)}
        assert [open_order.cid for open_order in memory.unfinished] == [an_id(1)]
        await store.write(a_claim(2))
        await store.close()

    async def test_a_repeated_call_spoils_nobody_elses(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(3))
        await store.write(a_claim(7))
        answers = await asyncio.gather(
            *(store.write(a_claim(name, n=name)) for name in range(10)), return_exceptions=True
        )
        bad = {name for name, answer in enumerate(answers) if answer is not None}
        assert bad == {3, 7}
        assert isinstance(answers[3], Repeated)
        assert set(await open_orders(fixture, store)) == {an_id(name) for name in range(10)}
        await store.close()

    # ---- notes ----

    async def test_notes_keep_their_order_with_writes(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1), a_conclusion(1))
        store.note(told(1))
        store.note(a_choice(OMNI))
        await store.write(a_choice(KUKA))
        memory = await recall(fixture, store)
        assert memory.unfinished == ()
        assert memory.selected == (a_choice(KUKA),)
        await store.close()

    async def test_a_note_is_written_before_closing(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        store.note(a_stop(3))
        await store.close()
        assert (await recall(fixture, store)).generations == {OMNI: 3}

    async def test_a_note_never_raises(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1))
        store.note(a_claim(1))
        await store.write(a_claim(2))
        await store.close()
        store.note(a_stop(1))

    # ---- what never goes back ----

    async def test_what_is_kept_is_written_when_it_says_so(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1))
        kept = asyncio.Event()
        survivors: list[Store] = []

        def then() -> None:
            survivors.append(fixture.survivor(store))
            kept.set()

        store.keep(a_conclusion(1), then)
        await asyncio.wait_for(kept.wait(), PATIENCE_S)
        [survivor] = survivors
        [open_order] = (await survivor.open()).unfinished
        assert open_order.ending is not None
        await survivor.close()
        await store.close()

    async def test_what_cannot_be_kept_says_so_all_the_same(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.close()
        said: list[int] = []
        store.keep(a_conclusion(1), lambda: said.append(1))
        assert said == [1]

    async def test_numbers_never_decrease(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await asyncio.gather(
            store.write(a_claim(1, n=5, fence=2)), store.write(a_claim(2, n=3, fence=4))
        )
        await store.write(a_claim(3, n=4, fence=3), a_claim(4, robot=KUKA, n=1, fence=1))
        assert (await recall(fixture, store)).numbers == {OMNI: (5, 4), KUKA: (1, 1)}
        await store.close()

    async def test_generations_never_decrease(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_stop(5))
        await store.write(a_stop(4))
        assert (await recall(fixture, store)).generations == {OMNI: 5}
        await store.write(a_claim(1, stop_generation=6))
        await store.write(a_resumption(2, generation=5))
        assert (await recall(fixture, store)).generations == {OMNI: 6}
        await store.close()

    async def test_a_revoked_key_stays_revoked(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(KeyIssued(key=a_key()), KeyIssued(key=a_key("k-other")))
        await store.write(KeyRevoked(key="k-ada", by="owner", at_ns=70))
        await store.write(KeyRevoked(key="k-ada", by="owner", at_ns=80))
        keys = {key.id: key for key in (await recall(fixture, store)).keys}
        assert keys["k-ada"].revoked_ns == 70
        assert keys["k-other"] == a_key("k-other")
        await store.close()

    async def test_a_key_that_is_issued_again_stays_revoked(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(KeyIssued(key=a_key()))
        await store.write(KeyRevoked(key="k-ada", by="owner", at_ns=70))
        await store.write(KeyIssued(key=a_key()))
        await store.write(KeyRevoked(key="k-new", by="owner", at_ns=71))
        await store.write(KeyIssued(key=a_key("k-new")))
        keys = {key.id: key.revoked_ns for key in (await recall(fixture, store)).keys}
        assert keys == {"k-ada": 70, "k-new": 71}
        await store.close()

    # ---- lives that the last run did not finish ----

    async def test_a_claim_without_outcome_is_unfinished(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1))
        await store.write(a_place(1, b"message 8"))
        open_order = Unfinished(
            cid=an_id(1),
            principal=ADA,
            robot=OMNI,
            skill="move",
            ending=None,
            claim=b"chat 7",
            words=None,
            placed=b"message 8",
        )
        assert await open_orders(fixture, store) == {an_id(1): open_order}
        await store.close()

    async def test_an_outcome_that_was_not_told_is_unfinished(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1))
        await store.write(a_conclusion(1, "failed", b"no object"))
        open_order = (await open_orders(fixture, store))[an_id(1)]
        assert (open_order.ending, open_order.claim, open_order.words) == (
            "failed",
            b"chat 7",
            b"no object",
        )
        await store.close()

    async def test_a_refusal_that_was_not_told_is_unfinished(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_refusal(1, Letter(ADA, b"chat 7")))
        await store.write(a_refusal("silent"))
        await store.write(a_refusal(2, Letter(ADA, b"chat 7")))
        await store.write(told(2))
        open_order = Unfinished(
            cid=an_id(1),
            principal=ADA,
            robot="",
            skill="",
            ending="refused",
            claim=b"chat 7",
            words=None,
            placed=None,
        )
        assert await open_orders(fixture, store) == {an_id(1): open_order}
        await store.close()

    async def test_what_was_told_is_finished(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1), a_claim(2))
        await store.write(a_conclusion(1), a_conclusion(2))
        await store.write(told(1))
        assert set(await open_orders(fixture, store)) == {an_id(2)}
        await store.close()

    async def test_an_outcome_without_words_is_finished(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1))
        await store.write(a_conclusion(1, words=None))
        assert await open_orders(fixture, store) == {}
        await store.close()

    async def test_the_first_outcome_counts(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1))
        await store.write(a_conclusion(1, "done", b"moved"))
        await store.write(a_conclusion(1, "failed", b"fell"))
        open_order = (await open_orders(fixture, store))[an_id(1)]
        assert (open_order.ending, open_order.words) == ("done", b"moved")
        await store.close()

    async def test_the_latest_place_counts(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1), a_place(1, b"message 8"))
        await store.write(a_place(1, b"message 9"))
        assert (await open_orders(fixture, store))[an_id(1)].placed == b"message 9"
        await store.close()

    # ---- people and their choices ----

    async def test_the_latest_choice_counts(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_choice(OMNI), a_choice(OMNI, b"other"))
        await store.write(a_choice(KUKA))
        chosen = {choice.chat: choice.robot for choice in (await recall(fixture, store)).selected}
        assert chosen == {b"chat": KUKA, b"other": OMNI}
        await store.close()

    async def test_a_choice_can_be_undone(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_choice(OMNI))
        await store.write(a_choice(""))
        assert (await recall(fixture, store)).selected == ()
        await store.close()

    async def test_people_are_remembered(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        seeded = Seeded(name_digest=b"name", principal=ADA)
        await store.write(seeded, an_enrolment(), KeyIssued(key=a_key()))
        memory = await recall(fixture, store)
        assert memory.enrolled == (an_enrolment(),)
        assert memory.seeded == (seeded,)
        assert memory.keys == (a_key(),)
        await store.close()

    async def test_the_newest_roles_count(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(an_enrolment(("admin",), 10))
        await store.write(an_enrolment(("viewer",), 20))
        enrolled = (await recall(fixture, store)).enrolled
        assert [record.roles for record in enrolled] == [("viewer",)]
        await store.close()

    async def test_letters_come_back_as_they_were(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1, letter=Letter(ADA, AWKWARD)), a_place(1, b""))
        await store.write(a_conclusion(1, words=b" "))
        open_order = (await open_orders(fixture, store))[an_id(1)]
        assert (open_order.claim, open_order.words, open_order.placed) == (AWKWARD, b" ", b"")
        await store.close()
