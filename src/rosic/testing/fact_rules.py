"""What every record must do with facts. ``StoreConformance`` has these rules among its own."""
# ruff: noqa: D102 - the name of a rule is its sentence

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.core.records import Letter
from rosic.errors import Repeated
from rosic.testing.factories import ADA, AWKWARD, KUKA, a_choice, a_claim, a_decision, a_fact
from rosic.testing.store_fixtures import recall

if TYPE_CHECKING:
    from rosic.core.records import Fact
    from rosic.testing.store_fixtures import StoreFixture

THE_AWKWARD = ("", " ", "a'b", "50 cm \U0001f916", "null\0", "%s", "Slot", "slot")


def keys(facts: tuple[Fact, ...]) -> str:
    """Return the keys of facts in one word."""
    return "".join(fact.key for fact in facts)


class FactRules:
    """The rules. Each opens a store of its own and closes it."""

    async def test_facts_are_remembered(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        slot = a_fact("1", AWKWARD, letter=Letter(ADA, b"for the visit"))
        grant = a_fact("1", b"grant", kind="grant")
        await store.write(a_decision("1"), slot, grant)
        assert (await recall(fixture, store)).facts == {"slot": (slot,), "grant": (grant,)}
        await store.close()
        survivor = fixture.survivor(store)
        await survivor.open()
        await survivor.write(a_fact("2"))
        await survivor.close()
        facts = (await recall(fixture, survivor)).facts
        assert facts == {"slot": (slot, a_fact("2")), "grant": (grant,)}

    async def test_the_newest_fact_of_a_kind_and_key_counts(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_fact("1", b"old", letter=Letter(ADA, b"named")), a_fact("2", b"old"))
        await store.write(a_fact("1", b"old", kind="grant"), a_fact("1", b"newer"))
        await store.write(a_fact("2", b"newer"), a_fact("2", b"new", letter=Letter(ADA, b"named")))
        await store.write(a_fact("1", b"new"))
        facts = (await recall(fixture, store)).facts
        assert facts["slot"] == (
            a_fact("1", b"new"),
            a_fact("2", b"new", letter=Letter(ADA, b"named")),
        )
        assert facts["grant"] == (a_fact("1", b"old", kind="grant"),)
        await store.close()

    async def test_a_fact_can_be_taken_back(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(*(a_fact(key) for key in "1234"), a_fact("1", kind="grant"))
        await store.write(a_fact("1", b""), a_fact("3", b"", letter=Letter(ADA, b"bye")))
        await store.write(a_fact("5"), a_fact("5", b""), a_fact("never", b""))
        facts = (await recall(fixture, store)).facts
        assert facts == {
            "slot": (a_fact("2"), a_fact("4")),
            "grant": (a_fact("1", kind="grant"),),
        }
        await store.write(a_fact("2", b""), a_fact("4", b""))
        assert set((await recall(fixture, store)).facts) == {"grant"}
        await store.close()

    async def test_facts_stand_in_the_order_in_which_they_were_first_said(
        self, fixture: StoreFixture
    ) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_fact("c"), a_fact("a"))
        await store.write(a_fact("b"), a_fact("c", b"again"), a_fact("d"), a_fact("a", b"again"))
        assert keys((await recall(fixture, store)).facts["slot"]) == "cabd"
        # What was taken back and is said again was first said just now, in one call or in two.
        await store.write(a_fact("a", b""), a_fact("e"), a_fact("a"), a_fact("f"))
        await store.write(a_fact("c", b""))
        await store.write(a_fact("c"))
        assert keys((await recall(fixture, store)).facts["slot"]) == "bdeafc"
        await store.write(a_fact("g"), a_fact("h"), a_fact("g", b""), a_fact("g"))
        assert keys((await recall(fixture, store)).facts["slot"]) == "bdeafchg"
        await store.close()

    async def test_facts_asked_for_together_keep_their_order(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        calls = [a_fact(str(index % 7), b"%d" % index) for index in range(70)]
        calls += [a_fact("6", b""), a_fact("5", b""), a_fact("6", b"back")]
        await asyncio.gather(*map(store.write, calls))
        expected = [a_fact(str(index), b"%d" % (63 + index)) for index in range(5)]
        assert (await recall(fixture, store)).facts["slot"] == (*expected, a_fact("6", b"back"))
        await store.close()

    async def test_facts_that_are_noted_keep_their_order_with_writes(
        self, fixture: StoreFixture
    ) -> None:
        store = fixture.make()
        await store.open()
        store.note(a_fact("1", b"noted"), a_fact("2", b"noted"))
        store.note(a_decision("2"))
        store.keep(a_fact("2", b"kept"), lambda: None)
        await store.write(a_fact("1", b"written"), a_fact("3"))
        store.note(a_fact("3", b""))
        await store.write(a_fact("4"))
        expected = (a_fact("1", b"written"), a_fact("2", b"kept"), a_fact("4"))
        assert (await recall(fixture, store)).facts["slot"] == expected
        store.note(a_fact("4", b"last"))
        await store.close()
        assert (await recall(fixture, store)).facts["slot"][-1] == a_fact("4", b"last")

    async def test_a_repeated_call_says_nothing_new(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        await store.write(a_claim(1), a_fact("1", b"old"), a_fact("2", b"old"))
        with pytest.raises(Repeated):
            await store.write(
                a_fact("1", b"new"), a_fact("2", b""), a_fact("3"), a_choice(KUKA), a_claim(1)
            )
        facts = (await recall(fixture, store)).facts
        assert facts == {"slot": (a_fact("1", b"old"), a_fact("2", b"old"))}
        await store.close()

    async def test_letters_of_facts_come_back_as_they_were(self, fixture: StoreFixture) -> None:
        store = fixture.make()
        await store.open()
        places = [(kind, key) for kind in THE_AWKWARD for key in THE_AWKWARD]
        written = [
            a_fact(key, b"\0", kind=kind, letter=Letter(f"p{index % 3}", b" %d " % index + AWKWARD))
            for index, (kind, key) in enumerate(places)
        ]
        written.append(a_fact("empty", letter=Letter(ADA, b"")))
        await store.write(*written)
        facts = (await recall(fixture, store)).facts
        assert [fact for kind in facts.values() for fact in kind] == [
            fact for name in facts for fact in written if fact.kind == name
        ]
        assert set(facts) == set(THE_AWKWARD)
        await store.close()
