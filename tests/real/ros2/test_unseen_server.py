"""Actions and services that are on the graph, and that a client does not see.

Which meeting of two ends is lost on a busy machine cannot be chosen: a client of another name sees
no more of them than one that has lost every one.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.client.actions import ActionLink
from rosic.robots.ros2.client.graph import wait_for
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.client.services import ServiceLink, wait_until
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.messages.types import TypeRegistry
    from rosic.testing.ros2.graph import RosGraph, RosProcess

MOVE = "rosic_interfaces/action/Move"
TRIGGER = "std_srvs/srv/Trigger"
FASTER = 20


@pytest.fixture
async def runtime(graph: RosGraph, types: TypeRegistry) -> AsyncIterator[RosRuntime]:
    """The gateway's side, by a clock that runs faster."""
    begun_ns = time.monotonic_ns()

    def now_ns() -> int:
        return begun_ns + FASTER * (time.monotonic_ns() - begun_ns)

    domain = graph.domain_id
    async with await RosRuntime.open(types, domain_id=domain, now_ns=now_ns) as runtime:
        yield runtime


async def blind_to(runtime: RosRuntime) -> tuple[ActionLink, ServiceLink]:
    """Return clients of ``/omni/move`` and ``/omni/stop`` that do not see them."""
    cls, trigger = runtime.types.action(MOVE), runtime.types.service(TRIGGER)
    node = runtime.thread.node

    def client(name: str) -> RosObject:
        return runtime.ros.action.ActionClient(node, cls, name)

    def asker(name: str) -> RosObject:
        return node.create_client(trigger, name)

    goal = await runtime.opened(lambda: client("/elsewhere/move"))
    call = await runtime.opened(lambda: asker("/elsewhere/stop"))
    return (
        ActionLink(runtime, "/omni/move", cls, goal, lambda: client("/omni/move")),
        ServiceLink(runtime, "/omni/stop", trigger, call, lambda: asker("/omni/stop")),
    )


async def test_an_action_and_a_service_are_found_by_a_client_that_did_not_see_them(
    runtime: RosRuntime, mover: RosProcess
) -> None:
    move, stop = await blind_to(runtime)
    await wait_until(move.sought, "/omni/move", 60 * pace())
    await wait_until(stop.sought, "/omni/stop", 60 * pace())
    assert move.renewed >= 1
    assert stop.renewed >= 1
    goal = await move.send({"direction": "forward", "distance_m": 0.01}, timeout_s=30 * pace())
    assert goal is not None
    assert (await goal.end(timeout_s=30 * pace())).status == "succeeded"
    assert (await stop.call({}, timeout_s=30 * pace())).message == "at rest"
    assert mover.lines.count("moved") == 1
    await move.close()
    await stop.close()


async def test_half_an_action_is_waited_for(runtime: RosRuntime, interfaces: object) -> None:  # noqa: ARG001 - built before
    """Where the other half is missing at the server's side, no new client helps, nor does harm."""
    cls, node = runtime.types.action(MOVE), runtime.thread.node
    asked: list[RosObject] = []

    def half() -> RosObject:
        service = cls.Impl.SendGoalService
        return node.create_service(service, "/half/move/_action/send_goal", asked.append)

    incomplete = await runtime.opened(half)
    link = await runtime.action("/half/move", MOVE)
    await wait_until(lambda: link.sought() or link.renewed == 3, "three new clients", 60 * pace())
    assert not link.ready()

    def whole() -> RosObject:
        return runtime.ros.action.ActionServer(node, cls, "/half/move", lambda _goal: None)

    await runtime.opened(lambda: node.destroy_service(incomplete))
    await runtime.opened(whole)
    await wait_for(runtime, lambda seen: bool(seen.actions), timeout_s=60 * pace())
    await wait_until(link.sought, "/half/move", 60 * pace())
    assert not asked, "nothing was sent to what is half there"
    await link.close()
