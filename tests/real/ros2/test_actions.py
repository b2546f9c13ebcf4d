from __future__ import annotations

import asyncio
import contextlib
import gc
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.client.services import wait_until
from rosic.robots.ros2.errors import BadValue, NoAnswer, NotSent
from rosic.robots.ros2.messages.decode import compile_path
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.robots.ros2.client.actions import ActionLink
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.messages.types import TypeRegistry
    from rosic.testing.ros2.graph import RosProcess

MOVE = "rosic_interfaces/action/Move"


def metres(distance_m: float) -> dict[str, object]:
    return {"direction": "forward", "distance_m": distance_m}


@pytest.fixture
async def move(runtime: RosRuntime, mover: RosProcess) -> ActionLink:  # noqa: ARG001 - it has to be there
    link = await runtime.action("/omni/move", MOVE)
    for _ in range(6):
        # DDS drops an answer to a client that its server has not found yet: ask until it has.
        with contextlib.suppress(NoAnswer):
            goal = await link.send(metres(0.01), timeout_s=5 * pace(), found_within_s=30)
            assert goal is not None
            await goal.end(timeout_s=30)
            return link
    raise AssertionError("six goals, and no answer")


async def test_a_goal_is_carried_out_and_tells_how_it_goes(
    move: ActionLink, types: TypeRegistry
) -> None:
    feedback_type = types.action(MOVE).Feedback
    fraction, stage = compile_path(feedback_type, "fraction"), compile_path(feedback_type, "stage")
    fractions: list[float] = []
    stages: set[object] = set()

    def hear(feedback: object) -> None:
        told = fraction(feedback)
        assert isinstance(told, float)
        fractions.append(told)
        stages.add(stage(feedback))

    goal = await move.send(metres(0.5), timeout_s=30, on_feedback=hear)
    assert goal is not None
    assert len(goal.id) == 16
    end = await goal.end(timeout_s=30)
    assert end.status == "succeeded"
    assert end.result.success is True
    result = types.action(MOVE).Result
    assert compile_path(result, "message")(end.result) == "there"
    assert compile_path(result, "fact_names")(end.result) == ["distance_m"]
    assert compile_path(result, "fact_values.0")(end.result) == 0.5
    # What it tells and how it ended come on two ways.
    await wait_until(lambda: fractions[-1:] > [0.94], "the last of the feedback", 30)
    assert fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(0.95)
    assert len(fractions) >= 10
    assert stages == {"rolling"}


async def test_a_goal_under_way_is_called_off(move: ActionLink, mover: RosProcess) -> None:
    started = asyncio.Event()
    goal = await move.send(metres(3), timeout_s=30, on_feedback=lambda _feedback: started.set())
    assert goal is not None
    await asyncio.wait_for(started.wait(), 60 * pace())
    assert await goal.cancel(timeout_s=30) == "cancelling"
    end = await goal.end(timeout_s=30)
    assert end.status == "cancelled"
    assert end.result.success is False
    assert end.result.fact_values[0] < 1
    await asyncio.to_thread(mover.expect, "called off")
    assert await goal.cancel(timeout_s=30) in {"ended", "unknown"}


async def test_a_goal_that_is_not_accepted_moves_nothing(move: ActionLink) -> None:
    for _ in range(5):
        refused = await move.send(metres(6), timeout_s=30, on_feedback=lambda _feedback: None)
        assert refused is None
    assert move.rejected == 5
    await wait_until(lambda: not move._handle._feedback_callbacks, "nothing left", 30)


async def test_one_id_is_carried_out_once(move: ActionLink, mover: RosProcess) -> None:
    name = bytes(range(16))
    first = await move.send(metres(0.2), timeout_s=30, goal_id=name)
    assert first is not None
    assert first.id == name
    assert await move.send(metres(0.2), timeout_s=30, goal_id=name) is None
    assert (await first.end(timeout_s=30)).status == "succeeded"
    for _ in range(2):  # the fixture's, and this one
        await asyncio.to_thread(mover.expect, "moved")
    mover.say("texts 1")
    await asyncio.to_thread(mover.expect, "ok texts")
    assert mover.lines.count("moved") == 2


async def test_an_acceptance_that_comes_too_late_is_called_off(
    move: ActionLink, mover: RosProcess
) -> None:
    mover.say("hesitate")
    await asyncio.to_thread(mover.expect, "ok hesitate")
    with pytest.raises(NoAnswer):
        await move.send(metres(4), timeout_s=0.3)
    await asyncio.to_thread(mover.expect, "called off")


async def test_a_send_that_is_cancelled_calls_its_goal_off(
    move: ActionLink, mover: RosProcess
) -> None:
    mover.say("hesitate")
    await asyncio.to_thread(mover.expect, "ok hesitate")
    sending = asyncio.create_task(move.send(metres(4), timeout_s=30))
    await asyncio.to_thread(mover.expect, "goal forward 4")
    sending.cancel()
    with pytest.raises(asyncio.CancelledError):
        await sending
    await asyncio.to_thread(mover.expect, "called off")


@pytest.mark.usefixtures("interfaces")
async def test_an_action_that_nobody_offers_is_not_asked(runtime: RosRuntime) -> None:
    nobody = await runtime.action("/omni/move", MOVE)
    assert not nobody.ready()
    with pytest.raises(NotSent, match="Nobody offers /omni/move"):
        await nobody.send(metres(1), timeout_s=30, found_within_s=0.05)


async def test_what_does_not_fit_is_not_sent(move: ActionLink) -> None:
    with pytest.raises(BadValue, match="distance_m must be a number, not text"):
        await move.send({"distance_m": "0.5"}, timeout_s=30)
    with pytest.raises(BadValue, match="did you mean distance_m"):
        await move.send({"distance": 0.5}, timeout_s=30)
    with pytest.raises(BadValue, match="16 bytes"):
        await move.send(metres(1), timeout_s=30, goal_id=b"short")


async def test_a_robot_that_dies_is_not_taken_for_done(move: ActionLink, mover: RosProcess) -> None:
    goal = await move.send(metres(4), timeout_s=30)
    assert goal is not None
    mover.kill()
    with pytest.raises(NoAnswer):
        await goal.end(timeout_s=0.3)
    goal.forget()


async def test_many_goals_leave_nothing_behind(move: ActionLink) -> None:
    for _ in range(20):
        goal = await move.send(metres(0.001), timeout_s=30, on_feedback=lambda _feedback: None)
        assert goal is not None
        await goal.end(timeout_s=30)
    client = move._handle

    def nothing_is_left() -> bool:
        """The ROS thread puts away what it held, after the answer was handed over."""
        gc.collect()
        kept = (client._feedback_callbacks, client._pending_goal_requests)
        return (
            not any((*kept, client._pending_result_requests, move._goals))
            and len(client._futures) <= 1
        )

    await wait_until(nothing_is_left, "nothing left of twenty goals", 30)
