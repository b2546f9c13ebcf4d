"""I10, L2: a record or a stop file that neither writes nor fails hides no stop (I1, I7, I9)."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.app.admin.dispatch import NOT_KEPT, AdminDispatcher
from rosic.container.bounded_writes import WITHIN_S
from rosic.core.history import RESUMED, HistoryQuery
from rosic.core.message import Chat, MessageValidity
from rosic.core.records import Claimed, Concluded, Refused, Resumed, Told
from rosic.errors import RecordUnavailable, StoreFault
from rosic.gateway.replies import LATE
from rosic.gateway.stop import LATCH_WITHIN_S, NOT_WRITTEN
from rosic.gateway.unfollowed_messages import COUNTED_S
from rosic.linker.linker import KEPT_WITHIN_S
from rosic.organiser.refusals import CLOCK_SET_BACK
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import MemoryLatch
from rosic.testing.clock import settle
from tests.gateway.place import BO as BO_THERE
from tests.gateway.place import Place, SlowStore
from tests.gateway.received import ADA, BO, STRANGER, Receiving, receiving
from tests.gateway.test_rights import who
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.core.records import Record

STOPPED_WITHIN_S = 5.0


class HangingStore(MemoryStore):
    """Writes nothing, and does not fail either, until it goes on."""

    def __init__(self) -> None:
        super().__init__()
        self.goes_on = asyncio.Event()
        self.goes_on.set()
        self.written: list[Record] = []

    async def write(self, *records: Record) -> None:
        """Wait for the disk."""
        await self.goes_on.wait()
        await super().write(*records)
        self.written += records


class HangingLatch(MemoryLatch):
    """Likewise; never goes on."""

    hangs = False

    async def write(self, robot: str, generation: int, *, latched: bool) -> None:
        """Wait for the disk."""
        if self.hangs:
            await asyncio.Event().wait()
        await super().write(robot, generation, latched=latched)


async def stopped(place: Receiving, robot: str) -> None:
    async with asyncio.timeout(STOPPED_WITHIN_S * pace()):
        while not place.gateway.rooms.stops[robot].latched:  # noqa: ASYNC110 - nobody is told
            await asyncio.sleep(0.01)


@pytest.mark.parametrize(
    "before",
    [[(BO, "omni fly")], [(BO, "omni move 0.1 m")] * 100, [(ADA, "/invite operator omni for 2h")]],
    ids=["a refusal", "a hundred orders", "an invitation"],
)
async def test_a_record_that_hangs_hides_no_stop(before: list[tuple[int, str]]) -> None:
    store = HangingStore()
    async with receiving(store) as place:
        place.give(place.message(ADA, "status"))
        await place.drained()
        store.goes_on.clear()
        place.give(*(place.message(who, text) for who, text in before))
        place.give(*(place.message(STRANGER + n, "hi") for n in range(100)))
        place.give(place.message(ADA, "stop"))
        try:
            await stopped(place, "omni")
        finally:
            store.goes_on.set()
        await place.drained()
        robot = place.gateway.robots["omni"]
        assert not getattr(robot, "acted", None), "what was written too late moves nothing"


@pytest.mark.parametrize("said", ["/task move 1 m", "/invite viewer for 2h", "omni move 0.1 m"])
async def test_what_people_send_while_the_record_hangs_delays_no_stop(said: str) -> None:
    """Six hundred of two people: each hundred was asked for again for a second, ten times."""
    store = HangingStore()
    async with receiving(store) as place:
        place.give(place.message(ADA, "status"), place.message(BO, "status"))
        await place.drained()
        store.goes_on.clear()
        place.give(*(place.message((ADA, BO)[n % 2], said) for n in range(600)))
        place.give(place.message(ADA, "stop"))
        before = place._line.polls
        try:
            await stopped(place, "omni")
        finally:
            store.goes_on.set()
        assert place._line.polls - before <= 2 * 7, "once, and once more to confirm it"
        await place.drained()


async def test_whoever_sent_what_is_given_up_is_told() -> None:
    """In one sentence for all of it, each in their chat, once; nobody else is told of it."""
    store = MemoryStore()
    async with Place(store).open() as place:
        there = [("1", "1"), (BO_THERE, "2"), ("nobody", "3")]
        for number in range(30):
            account, chat = there[number % 3]
            inbound = place.chat._inbound(account, Chat("memory", chat), f"m{number}", None)
            dropped = replace(inbound, text="kuka1 move 1 m", standing=MessageValidity.DROPPED)
            await place.gateway.pipeline.receive(place.chat, dropped)
        await place.clock.advance(COUNTED_S)
        await place.quiet()
        told = {each.outbound.chat.id: each.outbound.text for each in place.chat.told}
        assert set(told) == {"1", "2"}
        assert len(place.chat.told) == 2
        assert told["1"] == (
            "The record cannot keep up, so I gave up 10 messages of yours. "
            "Nothing was done for them. Stop still works."
        )
        assert place.acted("kuka1") == 0


async def test_whoever_changes_something_is_told_that_it_waits_and_then_how_it_ended() -> None:
    """Whoever has the turn, and whoever waits for it: their change is never half known."""
    store = HangingStore()
    async with Place(store).open() as place:
        store.goes_on.clear()
        place.chat.say("/invite viewer for 2h")
        await place.quiet()
        place.chat.say("/book kuka1 now 30 min", account=BO_THERE, chat=BO_THERE)
        place.chat.say("/me", account="3", chat="3")
        await place.quiet()
        before = len(place.chat.told)
        await place.clock.advance(WITHIN_S)
        await place.quiet()
        told = [each.outbound for each in list(place.chat.told)[before:]]
        assert sorted((each.chat.id, each.text) for each in told) == [
            ("1", str(LATE)),
            (BO_THERE, str(LATE)),
        ]
        await place.clock.advance(10 * WITHIN_S)
        await place.quiet()
        assert len(place.chat.told) == before + 2, "once"
        store.goes_on.set()
        await place.quiet()
        answers = "\n".join(each.outbound.text for each in list(place.chat.told)[before + 2 :])
        assert "Invitation as viewer" in answers
        assert "kuka1 is yours" in answers


async def test_a_stop_file_that_hangs_hides_no_stop_of_another_robot() -> None:
    latch = HangingLatch()
    async with receiving(latch=latch) as place:
        latch.hangs = True
        place.give(*(place.message(BO, "stop omni") for _ in range(100)))
        await stopped(place, "omni")
        place.give(place.message(ADA, "stop kuka1"))
        await stopped(place, "kuka1")
        assert place._line.waiting, "the newest of each robot is not confirmed"


async def test_only_the_newest_stop_of_a_robot_waits_for_the_stop_file() -> None:
    latch = HangingLatch()
    latch.hangs = True
    async with Place(latch=latch).open() as place:
        pipeline, chat = place.gateway.pipeline, place.chat
        said = [chat._inbound("1", Chat("memory", "1"), f"m{n}", None) for n in range(5)]
        texts = ("stop omni", "stop omni kuka1", "stop kuka1", "stop omni", "stop omni")
        taken = [
            asyncio.create_task(pipeline.receive(chat, replace(each, text=text)))
            for each, text in zip(said, texts, strict=True)
        ]
        await settle()
        assert [task.done() for task in taken] == [True, True, False, True, False]
        await place.clock.advance(LATCH_WITHIN_S)
        assert all(task.done() for task in taken)
        assert not place.gateway.stop_lane._latch_wait._newest


async def test_a_stop_is_answered_though_the_stop_file_hangs() -> None:
    """By chat and by the operator: what was measured, and that it could not be written down."""
    latch = HangingLatch()
    async with Place(latch=latch).open() as place:
        latch.hangs = True
        place.chat.say("stop omni")
        await place.quiet()
        assert place.robot("omni").gate.latched
        await place.clock.advance(KEPT_WITHIN_S)
        await place.quiet()
        told = place.last()[1].text
        assert told.startswith("STOP: omni at rest")
        assert str(NOT_WRITTEN) in told
        assert place.gateway.stop_lane.quiet

        desk = AdminDispatcher(place.gateway)
        yielded: list[str] = []

        async def stop() -> None:
            yielded.extend([one async for one in desk.stop(["kuka1"])])

        stopping = asyncio.create_task(stop())
        await place.quiet()
        await place.clock.advance(KEPT_WITHIN_S)
        await asyncio.wait_for(stopping, 60 * pace())
        assert yielded[-1] == str(NOT_KEPT)


async def late_order(place: Place, store: SlowStore) -> str:
    """Have an order claimed too late; return what its author was told."""
    before = len(place.chat.told)
    place.chat.say("omni move 1 m", account=BO_THERE, chat="2", message="late")
    await place.quiet()
    await place.clock.advance(WITHIN_S)
    await place.quiet()
    told = place.chat.told[before].outbound.text
    store.ready.set()
    await place.quiet()
    return told


async def test_what_is_claimed_too_late_is_disowned_and_never_done() -> None:
    store = SlowStore(Claimed)
    async with Place(store).open() as place:
        told = await late_order(place, store)
        assert told.startswith("I cannot write down what is decided, so nothing may move.")
        assert place.acted() == 0
        await place.say("omni move 1 m", account=BO_THERE, chat="2", message="late")
        assert place.acted() == 0, "its identity is that of a refusal"
        await place.say("omni move 1 m", account=BO_THERE, chat="2", message="again")
        assert place.acted() == 1, "the record answers again"
    assert not (await store.open()).unfinished, "settled and told"
    async with Place(store).open() as place:
        await place.say("omni move 1 m", account=BO_THERE, chat="2", message="late")
        assert place.acted() == 0
        assert not place.robot("omni").gate.latched, "nobody is in doubt about it"


async def test_what_was_claimed_too_late_and_not_disowned_is_unknown_after_a_restart() -> None:
    class Dies(SlowStore):
        def note(self, *records: Record) -> None:
            super().note(*(r for r in records if not isinstance(r, Concluded | Told)))

    store = Dies(Claimed)
    async with Place(store).open() as place:
        await late_order(place, store)
    assert len((await store.open()).unfinished) == 1
    async with Place(store).open() as place:
        await place.quiet()
        assert place.robot("omni").gate.latched
        assert "may or may not have been carried out" in place.chat.told[-1].outbound.text
        await place.say("omni move 1 m", account=BO_THERE, chat="2", message="late")
        assert place.acted() == 0


async def test_while_something_is_late_nothing_else_waits() -> None:
    store = SlowStore(Claimed)
    async with Place(store).open() as place:
        place.chat.say("omni move 1 m")
        await place.quiet()
        await place.clock.advance(WITHIN_S)
        told = await place.say("kuka1 move 1 m")
        assert told.startswith("I cannot write down what is decided, so nothing may move.")
        store.ready.set()
        await place.quiet()
        assert place.acted() == place.acted("kuka1") == 0


async def test_a_claim_in_time_is_carried_out() -> None:
    store = SlowStore(Claimed)
    async with Place(store).open() as place:
        place.chat.say("omni move 1 m")
        await place.quiet()
        await place.clock.advance(WITHIN_S * 0.9)
        store.ready.set()
        await place.quiet()
        assert place.acted() == 1


@pytest.mark.parametrize(("slow", "said"), [(Refused, "omni fly"), (Resumed, "resume omni")])
async def test_what_moves_nothing_does_not_wait_longer_either(slow: type, said: str) -> None:
    store = SlowStore(slow)
    async with Place(store).open() as place:
        await place.say("stop omni")
        await place.clock.advance(1.0)
        before = len(place.chat.told)
        place.chat.say(said)
        await place.quiet()
        assert len(place.chat.told) == before
        await place.clock.advance(WITHIN_S)
        await place.quiet()
        assert len(place.chat.told) > before
        store.ready.set()
        await place.quiet()
        assert place.robot("omni").gate.latched, "it was said to stay stopped"


async def test_a_resume_that_is_written_too_late_is_told_to_have_had_no_effect() -> None:
    store = SlowStore(Resumed)
    async with Place(store).open() as place:
        await place.say("stop omni")
        await place.clock.advance(1.0)
        place.chat.say("resume omni")
        await place.quiet()
        await place.clock.advance(WITHIN_S)
        await place.quiet()
        assert place.chat.told[-1].outbound.text.endswith("omni stays stopped.")
        store.ready.set()
        await place.quiet()
        assert place.robot("omni").gate.latched
        told = await place.say("/history omni")
        [resumed] = [line for line in told.splitlines() if "resume omni" in line]
        assert resumed.endswith("stayed stopped"), told
        await place.say("resume omni")
        told = await place.say("/history omni")
        assert "ready again" in told, "one that had its effect is said to"


async def test_a_resume_whose_stop_file_fails_is_told_to_have_had_no_effect() -> None:
    class Fails(MemoryLatch):
        async def write(self, robot: str, generation: int, *, latched: bool) -> None:
            if not latched:
                raise StoreFault("The stop holds, but could not be kept on disk.")
            await super().write(robot, generation, latched=latched)

    store = MemoryStore()
    async with Place(store, Fails()).open() as place:
        await place.say("stop omni")
        assert (await place.say("resume omni")).startswith("omni stays stopped: ")
        assert place.robot("omni").gate.latched
        assert "ready again" not in await place.say("/history omni")
        with pytest.raises(RecordUnavailable):
            await place.gateway.pipeline.resuming.by_operator(["omni"], place.clock.wall_ns())
        entries = await store.history(HistoryQuery(robot="omni"))
        assert [e.outcome for e in entries if e.kind == RESUMED] == ["refused", "refused"]


async def test_a_right_that_ends_while_the_record_hangs_moves_nothing_any_more() -> None:
    """I8: what ends by the clock waits for no write, neither of its own nor of somebody else."""
    store = HangingStore()
    async with Place(store).open() as place:
        keys, changes = place.gateway.access.keys, place.gateway.access.changes
        bo, omni = who(place, "Bo"), place.robot("omni")
        async with changes.turn() as turn:
            await turn.write(keys.issue(bo, "test", lasts_s=90)[1])
        omni.work_s = 3_600.0
        await place.say("omni move 1 m", account=BO_THERE, chat=BO_THERE)
        store.goes_on.clear()
        await place.clock.advance(80.0)  # the mark of the clock is due each minute, and hangs
        assert not omni.gate.latched, "the key is still good"
        await place.clock.advance(11.0)
        await settle()
        assert omni.gate.latched
        store.goes_on.set()
        await place.quiet()


async def test_a_clock_that_is_set_back_while_the_record_hangs_is_said() -> None:
    store = HangingStore()
    async with Place(store).open() as place:
        store.goes_on.clear()
        await place.clock.advance(80.0)
        place.clock.jump_wall(-3_600)
        await place.clock.advance(60.0)
        await place.quiet()
        told = [each.outbound.text for each in place.chat.told]
        store.goes_on.set()
        await place.quiet()
        assert any(text.startswith(str(CLOCK_SET_BACK)) for text in told), told
