from __future__ import annotations

import random

import pytest

from rosic.container.shared_data import (
    KIND,
    LONGEST_VALUE,
    SharedData,
    SharedDataQuota,
    SharedDataRights,
    SharedValue,
)
from rosic.core.records import Fact, Letter
from rosic.errors import NotPermitted, NotUnderstood, Refusal
from rosic.testing.clock import ManualClock, SeededEntropy

ADA, BO, OMNI = "p-ada", "p-bo", "omni"


class Rack:
    """A shelf whose facts are made so at once; Ada has omni now, Bo only sees it."""

    def __init__(self, quota: SharedDataQuota | None = None) -> None:
        self.clock = ManualClock()
        self.facts: dict[tuple[str, str], Fact] = {}
        self.quota = quota
        self.shelf = self.a_shelf()

    def a_shelf(self) -> SharedData:
        rights = SharedDataRights(
            is_robot=lambda owner: owner in {OMNI, "hidden"},
            sees=lambda _, robot: robot == OMNI,
            works_with=lambda who, _: who == ADA,
            shown=str,
        )
        return SharedData(self.clock, SeededEntropy(len(self.facts)), rights, self.quota)

    def so(self, facts: tuple[Fact, ...]) -> None:
        for fact in facts:
            self.facts[fact.kind, fact.key] = fact
            self.shelf.apply(fact)

    def store(self, who: str, owner: str, name: str, value: str) -> None:
        self.so(self.shelf.store(who, owner, name, value))

    def again(self) -> SharedData:
        shelf = self.a_shelf()
        shelf.restore(fact for fact in self.facts.values() if fact.body)
        return shelf

    def refused(self, who: str, owner: str, name: str = "n", value: str = "v") -> str:
        before = self.everything()
        with pytest.raises(Refusal) as refusal:
            self.shelf.store(who, owner, name, value)
        assert self.everything() == before
        return str(refusal.value)

    def everything(self) -> list[SharedValue]:
        return sorted(self.shelf._at.values(), key=lambda kept: kept.id)


def test_what_is_stored_is_added_and_the_newest_counts() -> None:
    rack = Rack()
    assert rack.shelf.latest(BO, OMNI, "offset") is None
    rack.store(ADA, OMNI, "offset", "0.30")
    rack.store(ADA, OMNI, "offset", "0.31")
    latest = rack.shelf.latest(BO, OMNI, "offset")
    assert latest is not None
    assert (latest.value, latest.sender, latest.at_ns) == ("0.31", ADA, rack.clock.wall_ns())
    assert [kept.value for kept in rack.shelf.history(BO, OMNI, "offset")] == ["0.30", "0.31"]


def test_a_person_s_own_shelf_is_read_by_nobody_else_without_their_word() -> None:
    rack = Rack()
    rack.store(ADA, ADA, "home", "under the stairs")
    for look in (rack.shelf.names, lambda who, whose: rack.shelf.history(who, whose, "home")):
        with pytest.raises(NotPermitted, match=r"You may not read that\."):
            look(BO, ADA)
    assert rack.refused(BO, ADA) == "You may not read that."
    rack.store(ADA, ADA, "other", "not lent")
    rack.so(rack.shelf.lending.lend(ADA, BO, "home"))
    latest = rack.shelf.latest(BO, ADA, "home")
    assert latest is not None
    assert latest.value == "under the stairs"
    with pytest.raises(NotPermitted):
        rack.shelf.latest(BO, ADA, "other")
    with pytest.raises(NotPermitted):
        rack.shelf.names(BO, ADA)
    assert rack.refused(BO, ADA) == "You may not read that."  # reading, not writing
    with pytest.raises(NotPermitted):
        rack.shelf.names(ADA, BO)  # it was not lent in return
    rack.so(rack.shelf.lending.take_back(ADA, "home", BO))
    with pytest.raises(NotPermitted):
        rack.shelf.latest(BO, ADA, "home")


def test_a_robot_s_shelf_is_read_by_whoever_sees_it_and_filled_by_whoever_has_it() -> None:
    rack = Rack()
    assert rack.refused(BO, OMNI) == (
        "Only whoever has omni now can keep data with it. Nothing was kept."
    )
    assert rack.refused(ADA, "hidden") == "You may not read that."


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        (" ", "v", "What is kept needs a name."),
        ("n", "\u200b ", "There is nothing to keep. Write a name and a value."),
        ("n" * 65, "v", "A name can have at most 64 characters. Nothing was kept."),
        (
            "n",
            "v" * (LONGEST_VALUE + 1),
            "A value can have at most 1000 characters. Nothing was kept.",
        ),
    ],
)
def test_what_cannot_be_kept(name: str, value: str, sentence: str) -> None:
    assert Rack().refused(ADA, ADA, name, value) == sentence


def test_quotas() -> None:
    rack = Rack(SharedDataQuota(names=2, history=3, most_bytes=40))
    for n in range(5):
        rack.store(ADA, ADA, "a", str(n))
    assert [kept.value for kept in rack.shelf.history(ADA, ADA, "a")] == ["2", "3", "4"]
    rack.store(ADA, ADA, "b", "x")
    assert rack.refused(ADA, ADA, "c") == (
        "p-ada keeps at most 2 names. Nothing was kept. Remove one first."
    )
    assert rack.refused(ADA, ADA, "b", "y" * 40) == (
        "p-ada keeps at most 40 bytes. Nothing was kept. Remove something first."
    )
    rack.so(rack.shelf.limit(ADA, SharedDataQuota(names=3, history=3, most_bytes=4000)))
    rack.store(ADA, ADA, "c", "y" * 40)
    rack.store(BO, BO, "a", "1")
    assert rack.shelf.quota(BO).names == 2  # one is changed, the other is not touched


def test_a_shelf_can_be_lent_to_so_many_and_no_more() -> None:
    rack = Rack()
    for n in range(64):
        rack.so(rack.shelf.lending.lend(ADA, f"p{n}", "home"))
    rack.so(rack.shelf.lending.lend(ADA, "p3", "home"))
    assert len(rack.shelf.lending.by(ADA)) == 64
    with pytest.raises(Refusal, match="You can share 64 things at most, and you do"):
        rack.shelf.lending.lend(ADA, "one more", "home")


def test_a_loan_ends_by_the_clock_with_its_name_and_over_a_restart() -> None:
    rack = Rack()
    rack.store(ADA, ADA, "home", "under the stairs")
    hour_ns = 3_600_000_000_000
    until_ns = rack.clock.wall_ns() + hour_ns
    (fact,) = rack.shelf.lending.lend(ADA, OMNI, "home", until_ns=until_ns)
    assert fact.letter is not None
    assert (fact.letter.container, b"home" in fact.body + fact.key.encode()) == (ADA, False)
    rack.so((fact,))
    again = rack.again()
    assert again.latest(BO, ADA, "home") is not None  # he sees omni
    assert [loan.name for loan in again.lending.to((OMNI,))] == ["home"]
    rack.clock.jump_wall(3_601)
    with pytest.raises(NotPermitted):
        again.latest(BO, ADA, "home")
    assert again.lending.to((OMNI,)) == ()
    rack.so(rack.shelf.lending.lend(ADA, BO, "home"))  # what is over goes with the next
    assert len(rack.shelf.lending._at) == 1
    rack.so(rack.shelf.remove(ADA, ADA, "home"))
    rack.store(ADA, ADA, "home", "elsewhere")
    with pytest.raises(NotPermitted):
        rack.shelf.latest(BO, ADA, "home")


def test_removing() -> None:
    rack = Rack()
    rack.store(ADA, OMNI, "a", "1")
    with pytest.raises(NotPermitted, match="Only whoever has omni now"):
        rack.shelf.remove(BO, OMNI, "a")
    with pytest.raises(NotUnderstood, match='omni keeps nothing called "b"'):
        rack.shelf.remove(ADA, OMNI, "b")
    rack.so(rack.shelf.remove(ADA, OMNI, "a"))
    assert rack.shelf.names(ADA, OMNI) == ()
    assert rack.shelf.used(OMNI) == (0, 0)


def test_in_the_open_stand_ids_alone_and_the_letter_is_the_owner_s() -> None:
    rack = Rack()
    (fact,) = rack.shelf.store(ADA, OMNI, "shelf height", "two palms")
    assert fact.letter is not None
    assert fact.letter.container == OMNI
    open_part = fact.key.encode() + fact.body
    assert b"height" not in open_part
    assert b"palms" not in open_part


def test_whoever_is_erased_leaves_nothing_anywhere() -> None:
    rack = Rack()
    rack.store(ADA, OMNI, "a", "1")
    rack.store(ADA, ADA, "a", "1")
    rack.store(BO, BO, "a", "1")
    rack.so(rack.shelf.lending.lend(ADA, BO, "a"))
    rack.so(rack.shelf.lending.lend(BO, ADA, "a"))
    rack.so(rack.shelf.limit(ADA, SharedDataQuota()))
    rack.so(rack.shelf.end_all(ADA))
    assert [kept.owner for kept in rack.everything()] == [BO]
    lending = rack.shelf.lending
    assert (lending._at, lending._by, lending._to) == ({}, {}, {})
    assert rack.shelf._quotas == {}


@pytest.mark.parametrize("seed", range(20))
def test_a_restart_and_a_removal_lose_count_of_nothing(seed: int) -> None:
    chance = random.Random(seed)  # noqa: S311 - a repeatable history, not a secret
    rack = Rack(SharedDataQuota(names=4, history=3, most_bytes=300))
    for _ in range(150):
        who, name = chance.choice((ADA, BO)), chance.choice("abcdef")
        owner = chance.choice((OMNI, who))
        try:
            if chance.random() < 0.8:
                rack.store(who, owner, name, "v" * chance.randint(1, 60))
            else:
                rack.so(rack.shelf.remove(who, owner, name))
        except Refusal:
            continue
    again = rack.again()
    for owner in (ADA, BO, OMNI):
        kept = [k for k in rack.everything() if k.owner == owner]
        size = sum(len(k.name) + len(k.value) for k in kept)
        assert rack.shelf.used(owner) == again.used(owner) == (len({k.name for k in kept}), size)
        assert size <= 300


def test_what_cannot_be_read_or_was_erased_is_left_out(caplog: pytest.LogCaptureFixture) -> None:
    rack = Rack()
    rack.store(ADA, ADA, "a", "1")
    (key,) = rack.shelf._at
    rack.shelf.apply(Fact(kind=KIND, key=key, body=rack.facts[KIND, key].body))
    assert rack.everything() == []
    rack.shelf.apply(Fact(kind=KIND, key="x", body=b"\xc1", letter=Letter(ADA, b"\xc1")))
    rack.shelf.apply(Fact(kind="shelf-loan", key="x", body=b"\xc1"))
    rack.shelf.apply(Fact(kind="shelf-quota", key="x", body=b"\xc1"))
    assert "a shelf-quota cannot be read" in caplog.text
