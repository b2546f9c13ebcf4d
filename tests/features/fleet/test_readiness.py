"""A task that waits says for what; robots that are busy are named once."""

from __future__ import annotations

from tests.features.fleet.test_tasks import warehouse, worker
from tests.gateway.place import ADA, BO


async def test_a_task_that_is_let_go_on_says_why_it_waits() -> None:
    async with warehouse().open() as here:
        await here.say("/task w1 move 3 m then wave")
        await here.say("stop w1")
        assert await here.say("/task go 1") == "Task 1: waiting. Why: w1: stopped."
        assert "waiting · 0 of 2 steps done · w1: stopped" in await here.say("/tasks")
        assert "Warum: w1: angehalten." not in await here.say("/language de")
        await here.say("/task pause 1")
        assert await here.say("/task go 1") == "Aufgabe 1: wartet. Warum: w1: angehalten."


async def test_of_several_robots_each_says_why_and_one_that_is_ready_is_enough() -> None:
    async with warehouse().open() as here:
        await here.say("w1 wave", account=BO, chat=BO)
        await here.say("/task warehouse wave then wave")
        await here.say("stop")
        told = await here.say("/task go 1")
        assert told == "Task 1: waiting. Why: w1: stopped; w2: stopped; w3: stopped."
        await here.say("resume w3")
        await here.say("/task pause 1")
        assert "Why" not in await here.say("/task go 1")


async def test_a_broadcast_to_busy_robots_says_so_once() -> None:
    async with warehouse().open() as here:
        await here.say("/broadcast warehouse wave")
        assert [here.acted(name) for name in ("w1", "w2", "w3")] == [1, 1, 1]
        told = await here.say("/broadcast warehouse move 1 m", account=ADA)
        assert told == (
            "0 of 3 robots are asked. The others:\n"
            "w1, w2 and w3 are busy. Ask again when that has ended, or stop them."
        )
        worker(here, "w3").finish()
        await here.quiet()
        told = await here.say("/broadcast warehouse move 1 m")
        assert told.count("busy") == 1
        assert "w1 and w2 are busy." in told
        assert here.acted("w3") == 2
