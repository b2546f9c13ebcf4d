"""However robots answer each other: what passes between two is bounded, and so is a chain."""

from __future__ import annotations

import asyncio
import json
from collections import Counter
from typing import TYPE_CHECKING

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosic.app.people import ConfiguredPerson
from rosic.contracts.robot import UTTERANCE_BYTES
from rosic.core.identity import Address
from rosic.core.records import Fact
from rosic.core.robot.dialogue_protocol import Share, TellRobot, mark_of, read_utterance
from rosic.errors import Refusal
from rosic.features.robot_to_robot.help_requests import KEPT_NS, KEPT_OVER, HelpRequests
from rosic.features.robot_to_robot.inbox import (
    CONVERSATION,
    CUT_NS,
    HOPS_AT_MOST,
    REMEMBERED,
    LoopGuard,
)
from rosic.features.robot_to_robot.permissions import LOOKED_AT_A_STEP
from rosic.gateway.delivery.outbox import KIND as UNSAID
from rosic.stores.memory import MemoryStore
from tests.features.robot_to_robot.peers import PeerRobots
from tests.gateway.place import BO
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.records import Record

ROBOTS = ("a", "b", "c", "d")
SECOND_NS = 1_000_000_000

# Who speaks to whom, how much later than the last, and whether it says that it answers the newest.
TURNS = st.lists(
    st.tuples(
        st.sampled_from(ROBOTS),
        st.sampled_from(ROBOTS),
        st.floats(0, 30),
        st.booleans(),
    ),
    max_size=400,
)


@settings(deadline=None, max_examples=60)
@given(TURNS)
def test_no_history_passes_more_than_the_budget_nor_a_longer_chain(
    turns: list[tuple[str, str, float, bool]],
) -> None:
    guard, now_ns, newest = LoopGuard(), 0, ""
    passed: Counter[frozenset[str]] = Counter()
    cut_until: dict[frozenset[str], int] = {}
    for number, (one, other, later_s, answers) in enumerate(turns):
        now_ns += int(later_s * SECOND_NS)
        pair = frozenset((one, other))
        if one == other:
            continue
        if guard.is_cut(one, other, now_ns):
            assert now_ns < cut_until[pair]
            continue
        assert now_ns >= cut_until.get(pair, 0), "cut for the whole time"
        hops = guard.hops(newest if answers else "")
        if guard.passes(one, other, hops, now_ns):
            assert hops <= HOPS_AT_MOST
            passed[pair] += 1
            newest = str(number)
            guard.remember(newest, one, hops)
        else:
            guard.cut(one, other, now_ns)
            cut_until[pair] = now_ns + CUT_NS
    for count in passed.values():
        budget = CONVERSATION.burst + CONVERSATION.per_s * now_ns / SECOND_NS
        cuts = 1 + now_ns / CUT_NS  # the bucket is full again after a cut
        assert count <= budget + CONVERSATION.burst * cuts + 1


def test_what_it_remembers_is_bounded() -> None:
    guard = LoopGuard()
    for number in range(3 * REMEMBERED):
        guard.remember(str(number), "a", 0)
    assert guard.cause("0") is None
    assert guard.cause(str(3 * REMEMBERED - 1)) is not None
    assert len(guard._said) == REMEMBERED
    for number in range(20_000):
        guard.passes(f"r{number}", "a", 0, 0)
    assert len(guard._pairs) <= REMEMBERED


def test_requests_for_help_that_are_over_are_forgotten() -> None:
    now_ns = 1
    book = HelpRequests(lambda: now_ns)
    for number in range(KEPT_OVER + 50):
        made, fact = book.ask(str(number), "a", "stuck", 60.0)
        book.apply(fact)
        now_ns += 1
        ends = book.end(made.id)
        assert ends is not None
        book.apply(ends)
    gone = book.forgotten()
    assert [fact.key for fact in gone] == [str(number) for number in range(50)]
    for fact in gone:
        book.apply(fact)
    assert book.forgotten() == []
    now_ns += KEPT_NS + 60 * SECOND_NS
    assert len(book.forgotten()) == KEPT_OVER


KINDS = ("share", "get", "follow", "help", "accept", "tell", "adjust", "ack", "fly", 1, None)
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=8,
)
KEYS = ("topic", "data", "robot", "to", "re", "ref", "id", "ok", "values", "when", "what", "keep_s")


@settings(deadline=None, max_examples=200)
@given(
    st.binary(max_size=200)
    | st.builds(
        lambda kind, rest: json.dumps({"kind": kind, **rest}).encode(errors="surrogatepass"),
        st.sampled_from(KINDS),
        st.dictionaries(st.sampled_from(KEYS), ANYTHING),
    )
)
def test_whatever_a_robot_says_is_read_or_refused_and_can_be_passed_on(words: bytes) -> None:
    try:
        read = read_utterance(words, UTTERANCE_BYTES)
    except Refusal:
        return
    if isinstance(read, Share | TellRobot):
        passed_on = msgspec.json.encode({"data": read.data})
        assert isinstance(json.loads(passed_on), dict)


@pytest.mark.parametrize(
    ("words", "mark"),
    [
        ('{"kind": "share", "ref": "7", "topic": "No Topic", "data": 1}', "7"),
        ('{"ref": "7", "kind": "dance"}', "7"),
        ('{"kind":"share","ref":"7","topic":"map","data":NaN}', "7"),
        ('{"kind":"share","ref":"7","topic":"map","data":"' + "x" * 100_000, "7"),
        ('{"kind":"share","data":"' + "x" * 100_000, ""),
        ('{"kind":"share","data":{"kind":"share","ref":"7"}', ""),
        ('{"kind":"share","ref":' + "7" * 100_000, ""),
        ("[" * 100_000, ""),
        ("", ""),
    ],
)
def test_the_answer_to_what_cannot_be_read_finds_whoever_waits_for_it(
    words: str, mark: str
) -> None:
    assert mark_of(words.encode()) == mark


class Crowd(PeerRobots):
    """Hundreds of people who may command every robot, and as many who may only look."""

    people = (
        *PeerRobots.people,
        *(
            ConfiguredPerson(f"P{n}", (Address("memory", f"{1_000 + n}"),), (role,))
            for n, role in enumerate(("operator", "viewer") * 200)
        ),
    )


class StepStore(MemoryStore):
    """Notes in which step of the event loop somebody was to be told something."""

    def __init__(self) -> None:
        super().__init__()
        self.step = 0
        self.told: Counter[int] = Counter()
        self.enough = asyncio.Event()

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        """Note it."""
        if isinstance(record, Fact) and record.kind == UNSAID and record.body:
            self.told[self.step] += 1
            if self.told.total() == 201:
                self.enough.set()
        super().keep(record, then)

    async def count(self) -> None:
        """Count the rounds of the loop: in one every task that can go on has a step."""
        while True:
            self.step += 1
            await asyncio.sleep(0)


@pytest.mark.parametrize("line", ["/quiet omni", "/quiet omni off"])
async def test_a_robot_is_silenced_among_many_people_a_few_in_each_step(line: str) -> None:
    """All were looked at and told in one step: with 1,500 people it took longer than 20 ms."""
    store = StepStore()
    async with Crowd(store).open() as here:
        counting = asyncio.create_task(store.count())
        here.chat.say(line, account=BO)
        async with asyncio.timeout(30 * pace()):
            await store.enough.wait()
        assert store.told.total() == 201, "all who may command it but who asked: Ada and 200 more"
        assert max(store.told.values()) == 1, "to tell one is a step"
        assert store.step >= len(Crowd.people) / LOOKED_AT_A_STEP
        counting.cancel()
        await here.quiet()
        assert "omni is" in here.chat.told[-1].outbound.text


async def test_all_who_command_a_robot_hear_that_it_floods() -> None:
    async with Crowd().open() as here:
        here.messaging._flooded("omni")
        async with asyncio.timeout(30 * pace()):
            await asyncio.gather(*here.messaging._warnings)
        await here.quiet()
        warned = [told for told in here.chat.told if "omni says more" in told.outbound.text]
        assert len({told.outbound.chat.id for told in warned}) == 202
