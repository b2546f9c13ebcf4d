"""The thread between an event loop and a disk."""

from __future__ import annotations

import asyncio
import threading
from typing import TYPE_CHECKING, Any

import pytest

from rosic.errors import StoreFault
from rosic.stores.write_thread import WriteThread
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.stores.write_thread import WriteJob


class GroupWriter:
    """Writes down what it was given, in groups; fails on what it is told to."""

    def __init__(self) -> None:
        self.groups: list[list[str]] = []
        self.finished = False

    def settle(self, jobs: list[WriteJob[str]]) -> bool:
        self.groups.append([job.content for job in jobs])
        for job in jobs:
            if job.content == "bad":
                job.fail(StoreFault("bad"))
            if job.content == "worse":
                raise ValueError("worse")
        return False

    def finish(self) -> None:
        self.finished = True

    def lane(self, *, group_max: int = 100, queue_max: int = 100) -> WriteThread[str]:
        lane: WriteThread[str] = WriteThread(
            "desk", self.settle, finish=self.finish, group_max=group_max, queue_max=queue_max
        )
        lane.start()
        return lane


async def test_one_turn_of_the_loop_is_one_group_in_order() -> None:
    writer = GroupWriter()
    lane = writer.lane()
    names = [str(index) for index in range(50)]
    await asyncio.gather(*map(lane.put, names))
    assert writer.groups == [names]
    await lane.stop()


async def test_a_group_is_bounded() -> None:
    writer = GroupWriter()
    lane = writer.lane(group_max=20)
    await asyncio.gather(*(lane.put(str(index)) for index in range(50)))
    assert [len(group) for group in writer.groups] == [20, 20, 10]
    await lane.stop()


async def test_a_call_stands_between_two_groups() -> None:
    writer = GroupWriter()
    lane = writer.lane()
    seen: list[int] = []
    await asyncio.gather(
        lane.put("before"), lane.call(lambda: seen.append(len(writer.groups))), lane.put("after")
    )
    assert seen == [1]
    assert writer.groups == [["before"], ["after"]]
    with pytest.raises(ZeroDivisionError):
        await lane.call(lambda: 1 // 0)
    await lane.stop()


async def test_the_thread_outlives_what_goes_wrong_in_it() -> None:
    lane = GroupWriter().lane()
    with pytest.raises(StoreFault):
        await lane.put("bad")
    with pytest.raises(ValueError, match="worse"):
        await lane.put("worse")
    await lane.put("good")
    await lane.stop()


async def test_stopping_finishes_what_waits_and_takes_nothing_more() -> None:
    writer = GroupWriter()
    lane = writer.lane()
    waiting = [asyncio.ensure_future(lane.put(str(index))) for index in range(5)]
    await asyncio.sleep(0)
    assert lane.drop("note")
    await lane.stop()
    await lane.stop()
    await asyncio.gather(*waiting)
    assert writer.groups == [["0", "1", "2", "3", "4", "note"]]
    assert writer.finished
    assert not lane.drop("late")
    with pytest.raises(StoreFault, match="closed"):
        await lane.put("late")


async def test_what_follows_a_note_may_fail_and_hurts_nobody_else() -> None:
    def stumble() -> None:
        raise ValueError("stumbled")

    said: list[object] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, context: said.append(context))
    lane = GroupWriter().lane()
    assert lane.drop("note", stumble)
    await lane.put("behind it")
    assert len(said) == 1
    await lane.stop()


async def test_a_loop_that_has_gone_does_not_hurt_the_thread() -> None:
    writer = GroupWriter()

    async def leave() -> None:
        writer.lane().drop("last words")
        await asyncio.sleep(0)

    await asyncio.to_thread(asyncio.run, leave())
    async with asyncio.timeout(60 * pace()):
        while not writer.groups:  # noqa: ASYNC110 - another thread gets there when it does
            await asyncio.sleep(0.001)


class Slow(GroupWriter):
    """Its disk stands still until it is let go."""

    def __init__(self) -> None:
        super().__init__()
        self.go = threading.Event()
        self.begun = threading.Event()

    def settle(self, jobs: list[WriteJob[str]]) -> bool:
        self.begun.set()
        assert self.go.wait(10)
        return super().settle(jobs)

    def urgent_lane(self, queue_max: int) -> WriteThread[str]:
        lane: WriteThread[str] = WriteThread(
            "desk",
            self.settle,
            finish=self.finish,
            group_max=10,
            queue_max=queue_max,
            urgent=lambda content: content.startswith("!"),
        )
        lane.start()
        return lane


async def test_a_write_that_is_cut_off_is_waited_for_until_it_is_known_what_became_of_it() -> None:
    writer = Slow()
    lane = writer.lane()
    kept = asyncio.create_task(lane.put("kept"))
    failed = asyncio.create_task(lane.put("bad"))
    await asyncio.to_thread(writer.begun.wait, 10)
    kept.cancel()
    failed.cancel()
    for _ in range(10):
        await asyncio.sleep(0)
    assert not kept.done(), "whoever goes on now does not know whether it was written"
    assert not failed.done()
    writer.go.set()
    with pytest.raises(asyncio.CancelledError) as written:
        await kept
    assert written.value.__cause__ is None
    with pytest.raises(asyncio.CancelledError) as unwritten:
        await failed
    assert isinstance(unwritten.value.__cause__, StoreFault)
    assert writer.groups == [["kept", "bad"]]
    await lane.stop()


@pytest.mark.parametrize("content", ["kept", "bad"])
async def test_a_write_cut_off_in_the_turn_in_which_its_end_arrives_is_not_waited_for_for_ever(
    content: str,
) -> None:
    """The end is on its way to the loop already; whoever is cut off asks for it a turn too late."""
    lane, reported = GroupWriter().lane(), threading.Event()
    report = lane._report

    def seen(*arguments: Any) -> None:  # noqa: ANN401 - handed on
        report(*arguments)
        reported.set()

    lane._report = seen  # type: ignore[method-assign, assignment]
    writing = asyncio.create_task(lane.put(content))
    for _ in range(3):
        await asyncio.sleep(0)
    assert reported.wait(10 * pace()), "the loop is held until the thread has told it"
    writing.cancel()
    await asyncio.wait((writing,), timeout=10 * pace())
    assert writing.done()
    with pytest.raises(asyncio.CancelledError) as ended:
        await writing
    assert isinstance(ended.value.__cause__, StoreFault) == (content == "bad")
    await lane.stop()


async def test_what_is_urgent_is_not_refused_because_of_what_is_not_and_goes_before_it() -> None:
    writer = Slow()
    lane = writer.urgent_lane(queue_max=20)
    for number in range(100):
        lane.drop(str(number))
    await asyncio.to_thread(writer.begun.wait, 10)
    with pytest.raises(StoreFault, match="keep up"):
        await lane.put("ordinary")
    assert lane.drop("!first")
    putting = [asyncio.ensure_future(lane.put(f"!{number}")) for number in range(10)]
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    writer.go.set()
    await asyncio.gather(*putting)
    everything = [content for group in writer.groups for content in group]
    first = everything.index("!first")
    assert first == 10, "only the group that had begun was before it"
    assert everything[first + 1 : first + 11] == [f"!{number}" for number in range(10)]
    await lane.stop()
    everything = [content for group in writer.groups for content in group]
    assert [c for c in everything if c[0] != "!"] == [str(number) for number in range(40)]


async def test_what_is_urgent_has_bounds_of_its_own() -> None:
    writer = Slow()
    lane = writer.urgent_lane(queue_max=5)
    putting = [asyncio.ensure_future(lane.put(f"!{number}")) for number in range(6)]
    await asyncio.sleep(0)
    assert "keep up" in str(putting[-1].exception())
    ordinary = asyncio.ensure_future(lane.put("ordinary"))
    writer.go.set()
    await asyncio.gather(ordinary, *putting[:-1])
    await lane.stop()


async def test_a_call_comes_after_what_was_urgent_before_it() -> None:
    writer = GroupWriter()
    lane: WriteThread[str] = WriteThread(
        "desk",
        writer.settle,
        finish=writer.finish,
        group_max=10,
        queue_max=5,
        urgent=lambda _: True,
    )
    lane.start()
    lane.drop("!")
    assert await lane.call(lambda: list(writer.groups)) == [["!"]]
    await lane.stop()


class Later(Slow):
    """What is urgent it can only do when it is asked once more."""

    def __init__(self) -> None:
        super().__init__()
        self.asked_again = threading.Event()

    def settle(self, jobs: list[WriteJob[str]]) -> bool:
        super().settle(jobs)
        if not jobs:
            self.asked_again.set()
        return any(job.content.startswith("!") for job in jobs)


async def test_what_is_urgent_is_tried_again_soon_though_a_call_came_right_behind_it() -> None:
    writer = Later()
    lane = writer.urgent_lane(queue_max=5)
    first = asyncio.ensure_future(lane.put("first"))
    await asyncio.to_thread(writer.begun.wait, 10)
    assert lane.drop("!urgent")
    called = asyncio.ensure_future(lane.call(lambda: None))
    await asyncio.sleep(0)
    writer.go.set()
    await asyncio.gather(first, called)
    assert await asyncio.to_thread(writer.asked_again.wait, 60 * pace()), "nothing else comes"
    assert writer.groups[:2] == [["first"], ["!urgent"]]
    await lane.stop()


async def test_a_lane_that_was_not_begun_takes_nothing_and_ends_at_once() -> None:
    writer = GroupWriter()
    lane: WriteThread[str] = WriteThread(
        "desk", writer.settle, finish=writer.finish, group_max=10, queue_max=5
    )
    with pytest.raises(StoreFault, match="closed"):
        await lane.put("early")
    assert not lane.drop("early")
    await lane.stop()
    assert writer.groups == []
