"""`/history`: one's own for everybody, a robot's for whoever may, and nobody else's (I11)."""

from __future__ import annotations

from rosic.core.history import REFUSED, HistoryQuery
from rosic.core.message import ChatKind
from rosic.features.personal_data.order_history import NOTHING_YET, named_once, read_entry
from rosic.stores.memory import MemoryStore
from tests.gateway.place import BO, VI, Place


async def test_everybody_reads_what_they_asked_for_and_what_came_of_it() -> None:
    async with Place().open() as place:
        assert await place.say("/history") == NOTHING_YET
        await place.say("omni move 1 m")
        await place.say("omni move 40 m")
        await place.say("kuka1 wave", account=BO, chat=BO)
        await place.say("stop omni")
        await place.say("resume omni")
        told = (await place.say("/history")).splitlines()
        assert len(told) == 4
        assert "omni: move, 1.00 m forward" in told[0], "what was meant, and its name once"
        assert "done" in told[0]
        assert '"omni move 40 m" · omni: one move may be at most 5 m' in told[1]
        assert told[2].endswith("stop omni · told to stop")
        assert "resume omni" in told[3]
        bos = await place.say("/history", account=BO, chat=BO)
        assert "kuka1: wave" in bos
        assert "omni" not in bos


async def test_a_robots_is_read_by_whoever_may_and_names_who_asked() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m", account=BO, chat=BO)
        told = await place.say("/history omni")
        assert "Bo · omni: move, 1.00 m forward" in told
        for who in (BO, VI):
            told = await place.say("/history omni", account=who, chat=who)
            assert "is read by admins" in told
            assert "1 m" not in told
        assert "Say history" in await place.say("/history nobody")


async def test_it_is_said_in_private_only() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m")
        told = await place.say("/history", chat="-5", kind=ChatKind.GROUP)
        assert "private" in told
        assert "1 m" not in told


async def test_more_of_it_is_one_tap_away() -> None:
    async with Place().open() as place:
        for _ in range(12):
            await place.say("omni wave")
        assert len((await place.say("/history")).splitlines()) == 10
        await place.tap(*place.button("More"))
        assert len(place.last()[1].text.splitlines()) == 12


async def test_a_stop_of_several_is_one_line_and_stands_with_each_robot() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m")
        await place.say("stop", account=BO, chat=BO)
        bos = await place.say("/history", account=BO, chat=BO)
        assert bos.endswith("stop omni, kuka1, cf1, cf2 · told to stop")
        assert len(bos.splitlines()) == 1
        told = (await place.say("/history kuka1")).splitlines()
        assert [line.partition(" · ")[2] for line in told] == ["Bo · stop kuka1 · told to stop"]
        assert "stop" not in await place.say("/history"), "Ada stopped nothing"


async def test_values_stand_as_they_were_resolved_in_ones_own_language_and_units() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 ft")
        await place.say("/task omni move 50 cm")
        await place.clock.advance(2.0)
        told = (await place.say("/history")).splitlines()
        assert "omni: move, 0.305 m forward · done" in told[0]
        assert "omni: move, 0.50 m forward · task 1 · done" in told[1]
        await place.say("/settings units imperial")
        assert "omni: move, 1 ft forward" in (await place.say("/history")).splitlines()[0]
        await place.say("/settings units metric")
        await place.say("/language de")
        told = (await place.say("/protokoll")).splitlines()
        assert "omni: move, 0,305 m vorwärts" in told[0]
        assert "0,50 m vorwärts · Aufgabe 1" in told[1]


async def test_programs_read_what_a_refusal_refused() -> None:
    async with Place().open() as place:
        await place.say("omni move 40 m")
        button, under = place.button("omni move 5 m")
        await place.tap(button, under)
        await place.say("omni dance")
        vocabulary = place.gateway.rooms.vocabulary
        assert isinstance(place.store, MemoryStore)
        found = await place.store.history(HistoryQuery())
        refused = [read_entry(entry, vocabulary) for entry in found if entry.kind == REFUSED]
        assert [read.asked for read in refused] == ["omni dance", "omni move 40 m"]


async def test_codes_are_not_kept_with_what_refused_them() -> None:
    async with Place().open() as place:
        await place.say("/code 123456")
        await place.say("omni dance\ncode 654321")
        told = await place.say("/history")
        assert "123456" not in told
        assert "654321" not in told
        assert '"omni dance code"' in told, "the rest of it is"


def test_records_of_before_say_a_name_once() -> None:
    assert named_once("omni: omni move 1 m") == "omni: move 1 m"
    assert named_once("KUKA iiwa: kuka1 grasp") == "KUKA iiwa: kuka1 grasp"
    assert named_once("omni: omni") == "omni: omni"
    assert named_once("omni: move 1 m") == "omni: move 1 m"
