from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.bindings import parameters
from rosic.robots.ros2.client.services import MAX_CALLS, wait_until
from rosic.robots.ros2.errors import BadValue, NoAnswer, NotSent
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.services import ServiceLink
    from rosic.robots.ros2.messages.encode import Values
    from rosic.testing.ros2.graph import RosProcess

TRIGGER = "std_srvs/srv/Trigger"
SET_BOOL = "std_srvs/srv/SetBool"


async def answered(link: ServiceLink, values: Values) -> RosObject:
    """Call until somebody answers.

    The first response can be lost: a server that has not found its client after 0.1 s drops it
    (rmw_fastrtps), and on a busy machine that happens.
    """
    for _ in range(5):
        try:
            return await link.call(values, timeout_s=5 * pace(), found_within_s=30)
        except NoAnswer:
            continue
    raise AssertionError(f"{link.name} never answered")


async def test_a_service_answers(runtime: RosRuntime, peer: RosProcess) -> None:
    stop = await runtime.service("/omni/stop", TRIGGER)
    response = await answered(stop, {})
    assert response.success is True
    assert response.message == "at rest"
    await asyncio.to_thread(peer.expect, "stopped")


async def test_a_service_that_nobody_offers_is_not_called(runtime: RosRuntime) -> None:
    nobody = await runtime.service("/omni/stop", TRIGGER)
    assert not nobody.ready()
    with pytest.raises(NotSent, match="Nobody offers /omni/stop; nothing was sent"):
        await nobody.call({}, timeout_s=30, found_within_s=0.1)


async def test_silence_is_told_from_refusal(runtime: RosRuntime, peer: RosProcess) -> None:
    slow = await runtime.service("/omni/slow", SET_BOOL)
    with pytest.raises(NoAnswer, match=r"/omni/slow did not answer within 0\.3 s"):
        await slow.call({"data": True}, timeout_s=0.3, found_within_s=30)
    await asyncio.to_thread(peer.expect, "slow done")  # it was carried out all the same
    assert (await slow.call({"data": False}, timeout_s=30)).success is True
    await wait_until(lambda: not slow._handle._pending_requests, "nothing left", 30)


async def test_what_does_not_fit_is_not_asked(runtime: RosRuntime, peer: RosProcess) -> None:
    slow = await runtime.service("/omni/slow", SET_BOOL)
    with pytest.raises(BadValue, match="data must be yes or no, not a whole number"):
        await slow.call({"data": 1}, timeout_s=30, found_within_s=30)
    assert "slow done" not in peer.lines


@pytest.mark.usefixtures("peer")
async def test_more_calls_than_rclpy_bears_all_complete(runtime: RosRuntime) -> None:
    stop = await runtime.service("/omni/stop", TRIGGER)
    await answered(stop, {})
    answers = await asyncio.gather(*(stop.call({}, timeout_s=60) for _ in range(500)))
    assert all(answer.success for answer in answers)


@pytest.mark.usefixtures("peer")
async def test_a_stop_does_not_wait_behind_other_calls(runtime: RosRuntime) -> None:
    slow = await runtime.service("/omni/slow", SET_BOOL)
    await answered(slow, {"data": False})
    queue = [asyncio.create_task(slow.call({"data": True}, timeout_s=60)) for _ in range(16)]
    late = asyncio.create_task(slow.call({"data": True}, timeout_s=0.05))
    with pytest.raises(NotSent, match="Too many calls are under way; /omni/slow was not called"):
        await late
    assert slow._ordinary.locked()
    assert (await slow.call({"data": False}, timeout_s=30, urgent=True)).success is True
    assert sum(call.done() for call in queue) <= MAX_CALLS
    await asyncio.gather(*queue)
    assert not slow._ordinary.locked()


@pytest.mark.usefixtures("peer")
async def test_closing_answers_whoever_still_waits(runtime: RosRuntime) -> None:
    slow = await runtime.service("/omni/slow", SET_BOOL)
    call = asyncio.create_task(slow.call({"data": True}, timeout_s=30, found_within_s=30))
    await wait_until(lambda: bool(runtime.thread._pending), "the call", 30)
    await runtime.close()
    with pytest.raises((NoAnswer, NotSent)):
        await asyncio.wait_for(call, 60 * pace())


@pytest.mark.usefixtures("peer")
async def test_a_call_that_is_cancelled_leaves_nothing_behind(runtime: RosRuntime) -> None:
    slow = await runtime.service("/omni/slow", SET_BOOL)
    await answered(slow, {"data": False})
    call = asyncio.create_task(slow.call({"data": True}, timeout_s=30))
    await wait_until(lambda: bool(slow._handle._pending_requests), "the call", 30)
    call.cancel()
    with pytest.raises(asyncio.CancelledError):
        await call
    await runtime.thread.run(lambda: None)
    await wait_until(lambda: not slow._handle._pending_requests, "nothing left", 30)
    assert not slow._ordinary.locked()


@pytest.mark.usefixtures("peer")
async def test_parameters_are_set_or_refused_in_the_nodes_words(runtime: RosRuntime) -> None:
    link = await runtime.service(parameters.service_of("/omni/robot"), parameters.SET_PARAMETERS)
    good: parameters.Parameters = {"speed_m_s": 0.25}
    answer = await answered(link, parameters.request(good))
    assert parameters.refusals(good, answer) == ()
    bad: parameters.Parameters = {"speed_m_s": "fast", "colour": 1}
    answer = await link.call(parameters.request(bad), timeout_s=30)
    refused = parameters.refusals(bad, answer)
    assert len(refused) == 2
    assert refused[0].startswith("speed_m_s was not set: ")
    assert refused[1].startswith("colour was not set: ")


def test_a_parameter_of_no_known_type_is_refused() -> None:
    with pytest.raises(BadValue, match="gains cannot be a list"):
        parameters.request({"gains": [1.0]})  # type: ignore[dict-item]
