"""`/history`: one's own for everybody, a robot's for whoever may, and nobody else's (I11)."""

from __future__ import annotations

from rosic.core.message import ChatKind
from rosic.pipeline.containers.history import NOTHING_YET
from tests.rooms.pipeline.place import BO, VI, Place


async def test_everybody_reads_what_they_asked_for_and_what_came_of_it() -> None:
    async with Place().open() as place:
        assert await place.say("/history") == NOTHING_YET
        await place.say("omni move 1 m")
        await place.say("omni move 40 m")
        await place.say("kuka1 wave", account=BO, chat=BO)
        await place.say("stop omni")
        await place.say("resume omni")
        told = (await place.say("/history")).splitlines()
        assert len(told) == 3
        assert "omni: omni move 1 m" in told[0]
        assert "done" in told[0]
        assert "one move may be at most 5 m" in told[1]
        assert "resume omni" in told[2]
        bos = await place.say("/history", account=BO, chat=BO)
        assert "kuka1 wave" in bos
        assert "omni" not in bos


async def test_a_robots_is_read_by_whoever_may_and_names_who_asked() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m", account=BO, chat=BO)
        told = await place.say("/history omni")
        assert "Bo · omni: omni move 1 m" in told
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
