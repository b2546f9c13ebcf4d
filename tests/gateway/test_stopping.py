"""I5 and I10: a stop overtakes everything, needs nothing, and stays until it is undone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.history import HistoryQuery
from rosic.core.identity import Address
from rosic.core.message import Chat, ChatEvent, ChatEventKind, ChatKind, MessageValidity
from rosic.core.records import Claimed, Fact
from rosic.core.robot.profile import Busy
from rosic.errors import StoreFault
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import MemoryLatch
from rosic.testing.clock import ManualClock
from tests.gateway.place import ADA, BO, VI, BrokenStore, Place, SlowStore, profile

if TYPE_CHECKING:
    from rosic.core.records import Memory

QUEUED = 10_000


class BrokenLatch(MemoryLatch):
    """Writes nothing."""

    async def write(self, _robot: str, _generation: int, *, latched: bool) -> None:  # noqa: ARG002
        raise StoreFault("no disk at all")


@pytest.mark.parametrize(
    "word",
    ["stop", "STOP!", "/stop", "halt", "stpo", "🛑", "arrête", "стоп", "停止", "stop everything"],
)
async def test_a_stop_stops_whatever_its_author_may_see(word: str) -> None:
    async with Place().open() as place:
        told = await place.say(word, account=VI, chat="3")
        assert all(robot.gate.latched for robot in place.gateway.robots.values())
        assert "STOP: omni at rest (0.00 s). kuka1 at rest" in told


async def test_a_named_stop_stops_only_those() -> None:
    async with Place().open() as place:
        await place.say("stop omni")
        assert place.robot("omni").gate.latched
        assert not place.robot("kuka1").gate.latched


async def test_a_stop_of_something_unknown_stops_everything() -> None:
    async with Place().open() as place:
        await place.say("stop onmi")
        assert all(robot.gate.latched for robot in place.gateway.robots.values())


async def test_after_a_stop_nothing_moves_until_somebody_who_may_resumes() -> None:
    async with Place().open() as place:
        await place.say("stop")
        told = await place.say("omni move 1 m")
        assert told.startswith(
            "omni is stopped, by you, since 22:13. It stays stopped until you resume it."
        )
        refused = await place.say("resume omni", account=VI, chat="3")
        assert refused.startswith('Resume needs the right "operator" on omni.')
        assert place.robot("omni").gate.latched
        assert await place.say("resume omni", account=BO, chat="2") == "omni is ready again."
        await place.say("omni move 1 m")
        assert place.acted() == 1
        assert place.robot("kuka1").gate.latched, "only omni was resumed"


async def test_a_stop_does_not_wait_for_its_chat() -> None:
    store = SlowStore(Claimed)
    async with Place(store).open() as place:
        place.chat.say("omni move 1 m")
        await place.quiet()
        assert place.acted() == 0, "the claim is not on disk yet"
        place.chat.say("stop omni")
        await place.quiet()
        assert place.robot("omni").gate.latched
        store.ready.set()
        await place.quiet()
        assert place.acted() == 0


async def test_a_stop_overtakes_ten_thousand_queued_commands() -> None:
    fleet = (replace(profile("kuka1", busy=Busy.QUEUE), queue_length=QUEUED),)
    async with Place(fleet=fleet).open() as place:
        robot = place.robot("kuka1")
        robot.work_s = 3600.0
        for number in range(QUEUED):
            place.chat.say("kuka1 wave", chat=f"c{number % 100}")
            if number % 500 == 0:
                await place.quiet()
        await place.quiet()
        assert place.gateway.rooms.linker.waiting("kuka1") > QUEUED * 0.9
        place.chat.say("stop", account=BO, chat="2")
        for _ in range(3):
            if robot.gate.latched:
                break
            await place.quiet()
        assert robot.gate.latched
        acted = place.acted("kuka1")
        await place.quiet()
        assert place.acted("kuka1") == acted == 1
        assert place.gateway.rooms.linker.waiting("kuka1") == 0


async def test_a_stop_needs_no_record_and_says_what_was_not_written() -> None:
    store = BrokenStore()
    async with Place(store, BrokenLatch()).open() as place:
        place.robot("omni").work_s = 60.0
        await place.say("omni move 1 m")
        store.broken = True
        told = await place.say("stop")
        assert place.robot("omni").gate.latched
        assert "omni at rest" in told
        assert "I could not write this down" in told
        refused = await place.say("kuka1 move 1 m")
        assert "stopped" in refused
        store.broken = False


async def test_without_a_record_nothing_moves_and_it_works_again_by_itself() -> None:
    store = BrokenStore()
    async with Place(store).open() as place:
        store.broken = True
        told = await place.say("omni move 1 m")
        assert told.startswith("I cannot write down what is decided, so nothing may move.")
        assert place.acted() == 0
        store.broken = False
        await place.say("omni move 1 m")
        assert place.acted() == 1


async def test_an_anonymous_stop_counts_for_the_people_of_that_chat() -> None:
    async with Place().open() as place:
        await place.say("status", chat="g", kind=ChatKind.GROUP)
        await place.say(
            "stop",
            chat="g",
            kind=ChatKind.GROUP,
            account="1087968824",
            standing=MessageValidity.ANONYMOUS,
        )
        assert place.robot("omni").gate.latched


async def unnamed_stop(
    place: Place, standing: MessageValidity = MessageValidity.ANONYMOUS, chat: str = "g"
) -> None:
    await place.say("stop", chat=chat, kind=ChatKind.GROUP, account="1087968824", standing=standing)


@pytest.mark.parametrize("standing", [MessageValidity.ANONYMOUS, MessageValidity.CHANNEL])
async def test_a_stop_of_nobody_counts_for_those_who_wrote_there_in_an_earlier_run(
    standing: MessageValidity,
) -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        await place.say("status", chat="g", kind=ChatKind.GROUP)
    async with Place(store).open() as place:
        assert not place.robot("omni").gate.latched
        await unnamed_stop(place, standing)
        assert place.robot("omni").gate.latched


async def test_a_stop_of_nobody_counts_for_whoever_brought_us_there() -> None:
    async with Place().open() as place:
        chat = Chat("memory", "g", ChatKind.GROUP)
        place.chat.passed(
            ChatEvent(chat=chat, what=ChatEventKind.ADDED, who=Address("memory", ADA))
        )
        await unnamed_stop(place)
        assert place.robot("omni").gate.latched


async def test_a_stop_of_nobody_counts_for_nobody_whose_access_has_ended() -> None:
    async with Place().open() as place:
        await place.say("status", chat="g", kind=ChatKind.GROUP, account=BO)
        await place.revoke("Bo")
        await unnamed_stop(place)
        assert not place.robot("omni").gate.latched


async def test_where_nobody_is_known_the_chats_admins_are_asked_for_now_and_then() -> None:
    asked = []

    async def admins(chat: Chat) -> tuple[Address, ...]:
        asked.append(chat.id)
        return (Address("memory", "77"), Address("memory", ADA)) if chat.id == "g" else ()

    async with Place().open() as place:
        place.gateway._messengers[0].admins = admins  # type: ignore[attr-defined]
        for _ in range(3):
            await place.say(
                "stop",
                chat="h",
                kind=ChatKind.GROUP,
                account="5",
                standing=MessageValidity.ANONYMOUS,
            )
        assert asked == ["h"]
        assert not place.robot("omni").gate.latched
        await unnamed_stop(place)
        assert place.robot("omni").gate.latched
        assert asked == ["h", "g"]


async def test_a_stop_of_nobody_counts_no_more_for_whoever_left() -> None:
    async with Place().open() as place:
        await place.say("use omni", chat="g", kind=ChatKind.GROUP)
        chat = Chat("memory", "g", ChatKind.GROUP)
        place.chat.passed(ChatEvent(chat=chat, what=ChatEventKind.LEFT, who=Address("memory", ADA)))
        principal = place.gateway.rooms.authoriser.directory.named("Ada")[0].id
        assert principal not in place.gateway.rooms.container.company(chat)


async def test_a_stop_survives_a_restart() -> None:
    store, latch = MemoryStore(), MemoryLatch()
    async with Place(store, latch).open() as place:
        await place.say("stop omni")
    async with Place(store, latch).open() as place:
        told = await place.say("omni move 1 m")
        assert told.startswith("omni is stopped, by you, since")
        assert place.acted() == 0
        await place.say("resume omni")
        await place.say("omni move 1 m")
        assert place.acted() == 1


async def test_whose_a_stop_was_and_since_when_survives_a_restart() -> None:
    store, latch, clock = MemoryStore(), MemoryLatch(), ManualClock()
    async with Place(store, latch, clock=clock).open() as place:
        await place.say("stop omni", account=BO, chat=BO)
        before = await place.say("omni wave")
        assert before.startswith("omni is stopped, by Bo, since 22:13.")
        await place.say("stop kuka1", account=BO, chat=BO)
        place.gateway.rooms.linker.hold("kuka1")  # nobody's: its last order may have done anything
        await place.gateway.rooms.linker.hold_for_good("kuka1", 2)
    await clock.advance(3_600)
    async with Place(store, latch, clock=clock).open() as place:
        assert await place.say("omni wave") == before
        told = await place.say("kuka1 wave")
        assert told.startswith("kuka1 is stopped. It stays stopped")
        await place.say("stop omni")
        told = await place.say("omni wave")
        assert told.startswith("omni is stopped, by Bo and you, since 22:13."), "Bo's is not over"


async def test_what_cannot_be_read_of_a_stop_leaves_it_nobodys() -> None:
    store, latch = MemoryStore(), MemoryLatch()
    async with Place(store, latch).open() as place:
        await place.say("stop omni")
    store = MemoryStore()
    await store.open()
    await store.write(Fact(kind="stopped-by", key="omni", body=b"?"))
    await store.write(Fact(kind="stopped-by", key="gone", body=b""))
    async with Place(store, latch).open() as place:
        assert (await place.say("omni wave")).startswith("omni is stopped. It stays")


async def test_a_stop_that_only_the_stop_file_knows_survives_a_restart() -> None:
    store, latch = BrokenStore(), MemoryLatch()
    async with Place(store, latch).open() as place:
        store.broken = True
        await place.say("stop omni")
    store.broken = False
    async with Place(store, latch).open() as place:
        assert place.robot("omni").gate.latched
        await place.say("omni move 1 m")
        assert place.acted() == 0


async def test_a_stop_that_only_the_record_knows_survives_a_restart() -> None:
    store = MemoryStore()
    async with Place(store, BrokenLatch()).open() as place:
        await place.say("stop omni")
    async with Place(store, MemoryLatch()).open() as place:
        assert place.robot("omni").gate.latched
        assert place.robot("omni").gate.generation == 1
        told = await place.say("omni move 1 m")
        assert told.startswith("omni is stopped")
        assert place.acted() == 0


async def test_a_resume_survives_a_restart() -> None:
    store, latch = MemoryStore(), MemoryLatch()
    async with Place(store, latch).open() as place:
        await place.say("stop omni")
        await place.say("resume omni")
    async with Place(store, latch).open() as place:
        await place.say("omni move 1 m")
        assert place.acted() == 1


async def test_a_claim_without_an_outcome_is_unknown_held_and_never_repeated() -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        place.robot("omni").work_s = 60.0
        inbound = place.chat.say("omni move 1 m")
        await place.quiet()
        memory: Memory = await store.open()
        assert len(memory.unfinished) == 1
        reborn = Place(store)
        async with reborn.open() as after:
            await after.quiet()
            assert "may or may not have been carried out" in after.chat.told[-1].outbound.text
            assert after.robot("omni").gate.latched
            after.chat.deliver(inbound)
            await after.quiet()
            assert after.acted() == 0
            told = await after.say("omni move 1 m")
            assert "omni is stopped" in told


async def test_a_robot_in_doubt_is_held_by_the_run_after_the_next_too() -> None:
    """The order counts as settled then: only what holds the robot says that it is in doubt (I5)."""
    store, latch = MemoryStore(), MemoryLatch()
    async with Place(store, latch).open() as dies:
        dies.robot("omni").work_s = 60.0
        await dies.say("omni move 1 m")
        async with Place(store, latch).open() as dies_too:
            await dies_too.quiet()
            assert not (await store.open()).unfinished
            async with Place(store, latch).open() as place:
                assert place.robot("omni").gate.latched
                assert "omni is stopped" in await place.say("omni move 1 m", message="later")


async def test_numbers_and_fences_go_on_after_a_restart() -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        await place.say("omni move 1 m")
        await place.say("omni move 1 m")
    async with Place(store).open() as place:
        await place.say("omni move 1 m", message="another")
        assert list(place.robot("omni").acted) == [3]
        assert place.robot("omni").gate.fence == 2


async def test_a_resume_that_a_later_stop_overtook_undoes_nothing() -> None:
    async with Place().open() as place:
        await place.say("stop omni")
        await place.clock.advance(1.0)
        resume = place.chat._inbound("1", place.chat.say("status").chat, "late", None)
        await place.clock.advance(1.0)
        await place.say("stop omni")
        place.chat.deliver(replace(resume, text="resume omni"))
        await place.quiet()
        assert place.robot("omni").gate.latched
        assert "omni was stopped after you sent this." in place.last()[1].text
        await place.clock.advance(1.0)
        await place.say("resume omni")
        assert not place.robot("omni").gate.latched


async def test_a_resume_sent_while_nobody_listened_undoes_nothing() -> None:
    async with Place().open() as place:
        await place.say("stop omni")
        await place.clock.advance(2.0)
        sent_ns = place.clock.wall_ns() - 1_000_000_000
        place.chat.gap()
        await place.say("resume omni", sent_ns=sent_ns)
        await place.clock.advance(1.0)  # more of it might come
        told = place.chat.told[-1].outbound.text
        assert told == "You sent this while I could not listen. Nothing was done."
        assert place.robot("omni").gate.latched


async def test_a_stop_sent_while_nobody_listened_is_applied_however_old() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = 60.0
        await place.clock.advance(7_200.0)
        sent_ns = place.clock.wall_ns() - 3_600_000_000_000
        place.chat.gap()
        await place.say("omni move 1 m", sent_ns=sent_ns)
        told = await place.say("stop omni", sent_ns=sent_ns)
        assert place.robot("omni").gate.latched
        assert "STOP: omni at rest" in told
        assert place.acted() == 0


async def _in_group(place: Place, text: str) -> tuple[str, list[str]]:
    """Say something in a group that is addressed to nobody; return what was answered."""
    before = len(list(place.chat.told))
    await place.say(text, chat="g", kind=ChatKind.GROUP, account=BO)
    told = [sent.outbound for sent in list(place.chat.told)[before:]]
    labels = [button.label for outbound in told for row in outbound.buttons for button in row]
    return "\n".join(outbound.text for outbound in told), labels


SHOUTS = [
    "watch out stop",
    "guys stop omni",
    "omni won't stop",
    "стойте останови робота",
    "停下机器人",
]


@pytest.mark.parametrize("text", SHOUTS)
async def test_a_shout_among_other_words_stops_in_a_group(text: str) -> None:
    async with Place().open() as place:
        await _in_group(place, text)

        assert place.gateway.rooms.stops["omni"].latched


async def test_what_only_speaks_of_a_stop_in_a_group_is_answered_with_the_button() -> None:
    async with Place().open() as place:
        answer, labels = await _in_group(place, "where is the stop button over there")
        assert answer == "To stop, send stop in a line of its own."
        assert labels == ["stop"]
        assert not place.gateway.rooms.stops["omni"].latched
        assert await _in_group(place, "we meet at the bus stop over there") == ("", [])
        assert await _in_group(place, "where is the button over there") == ("", [])


async def test_stops_said_all_day_of_what_is_stopped_are_obeyed_and_fill_no_record() -> None:
    """Each wrote a row for every robot there: a person who did so for a day filled the disk."""
    store = MemoryStore()
    async with Place(store).open() as place:

        async def rows(account: str = ADA) -> int:
            who = place.gateway.rooms.authoriser.directory.at(Address("memory", account))
            assert who is not None
            query = HistoryQuery(principal=who[0].id, robot="omni", limit=1_000)
            return len(await store.history(query))

        place.robot("omni").work_s = 300.0
        await place.say("omni move 1 m")
        for said in range(1, 40):
            assert "STOP: omni at rest" in await place.say("stop omni")
            assert place.robot("omni").gate.latched
            assert place.robot("omni").gate.generation == said, "each was handed to the robot"
            assert place.latch.read()["omni"] == (said, True), "and is in the latch"
            await place.clock.advance(1.0)
        assert await rows() == 2, "one order, one stop"
        await place.say("stop omni", account=BO)
        assert await rows(BO) == 1, "somebody else's is their own"
        await place.say("stop omni")
        assert await rows() == 2
        await place.clock.advance(60.0)
        await place.say("stop omni")
        assert await rows() == 3, "one a minute"
        await place.say("resume omni")
        assert not place.robot("omni").gate.latched
        before = await rows()
        await place.say("stop omni")
        assert await rows() == before + 1, "what stops something is never left out"
        generation = place.robot("omni").gate.generation
    assert (await store.open()).generations["omni"] == generation
