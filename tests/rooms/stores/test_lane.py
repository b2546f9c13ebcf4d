"""The thread between an event loop and a disk."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.errors import StoreFault
from rosic.stores.lane import Lane

if TYPE_CHECKING:
    from rosic.stores.lane import Job


class Desk:
    """Writes down what it was given, in groups; fails on what it is told to."""

    def __init__(self) -> None:
        self.groups: list[list[str]] = []
        self.finished = False

    def settle(self, jobs: list[Job[str]]) -> bool:
        self.groups.append([job.content for job in jobs])
        for job in jobs:
            if job.content == "bad":
                job.error = StoreFault("bad")
            if job.content == "worse":
                raise ValueError("worse")
        return False

    def finish(self) -> None:
        self.finished = True

    def lane(self, *, group_max: int = 100, queue_max: int = 100) -> Lane[str]:
        lane: Lane[str] = Lane(
            "desk", self.settle, finish=self.finish, group_max=group_max, queue_max=queue_max
        )
        lane.start()
        return lane


async def test_one_turn_of_the_loop_is_one_group_in_order() -> None:
    desk = Desk()
    lane = desk.lane()
    names = [str(index) for index in range(50)]
    await asyncio.gather(*map(lane.put, names))
    assert desk.groups == [names]
    await lane.stop()


async def test_a_group_is_bounded() -> None:
    desk = Desk()
    lane = desk.lane(group_max=20)
    await asyncio.gather(*(lane.put(str(index)) for index in range(50)))
    assert [len(group) for group in desk.groups] == [20, 20, 10]
    await lane.stop()


async def test_a_call_stands_between_two_groups() -> None:
    desk = Desk()
    lane = desk.lane()
    seen: list[int] = []
    await asyncio.gather(
        lane.put("before"), lane.call(lambda: seen.append(len(desk.groups))), lane.put("after")
    )
    assert seen == [1]
    assert desk.groups == [["before"], ["after"]]
    with pytest.raises(ZeroDivisionError):
        await lane.call(lambda: 1 // 0)
    await lane.stop()


async def test_the_thread_outlives_what_goes_wrong_in_it() -> None:
    lane = Desk().lane()
    with pytest.raises(StoreFault):
        await lane.put("bad")
    with pytest.raises(ValueError, match="worse"):
        await lane.put("worse")
    await lane.put("good")
    await lane.stop()


async def test_stopping_finishes_what_waits_and_takes_nothing_more() -> None:
    desk = Desk()
    lane = desk.lane()
    waiting = [asyncio.ensure_future(lane.put(str(index))) for index in range(5)]
    await asyncio.sleep(0)
    assert lane.drop("note")
    await lane.stop()
    await lane.stop()
    await asyncio.gather(*waiting)
    assert desk.groups == [["0", "1", "2", "3", "4", "note"]]
    assert desk.finished
    assert not lane.drop("late")
    with pytest.raises(StoreFault, match="closed"):
        await lane.put("late")


async def test_what_follows_a_note_may_fail_and_hurts_nobody_else() -> None:
    def stumble() -> None:
        raise ValueError("stumbled")

    said: list[object] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, context: said.append(context))
    lane = Desk().lane()
    assert lane.drop("note", stumble)
    await lane.put("behind it")
    assert len(said) == 1
    await lane.stop()


async def test_a_loop_that_has_gone_does_not_hurt_the_thread() -> None:
    desk = Desk()

    async def leave() -> None:
        desk.lane().drop("last words")
        await asyncio.sleep(0)

    await asyncio.to_thread(asyncio.run, leave())
    async with asyncio.timeout(10):
        while not desk.groups:  # noqa: ASYNC110 - another thread gets there when it does
            await asyncio.sleep(0.001)
