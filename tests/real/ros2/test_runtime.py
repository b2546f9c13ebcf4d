from __future__ import annotations

import asyncio
import os
import subprocess
import sys
import textwrap
import threading
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from rosic.robots.ros2.client import executor_thread as handing
from rosic.robots.ros2.client.executor_thread import LoopBridge
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.client.services import wait_until
from rosic.robots.ros2.errors import BadName, NotSent, RosMissing
from rosic.testing.ros2.graph import environment_for_another_python
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.robots.ros2.messages.types import TypeRegistry
    from rosic.testing.ros2.graph import RosGraph

SOURCES = Path(__file__).parents[3] / "src"


def python(
    program: str, environment: dict[str, str], *flags: str
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(  # noqa: S603 - the program stands in the test
        [sys.executable, *flags, "-c", textwrap.dedent(program)],
        env=environment | {"PYTHONPATH": str(SOURCES)},
        capture_output=True,
        text=True,
        timeout=120 * pace(),
        check=False,
    )


async def test_work_is_done_on_the_ros_thread_and_its_failure_comes_back(
    runtime: RosRuntime,
) -> None:
    assert await runtime.thread.run(threading.current_thread) is not threading.current_thread()
    with pytest.raises(ZeroDivisionError):
        await runtime.thread.run(lambda: 1 / 0)
    assert runtime.alive
    assert runtime.thread.faults == 0


async def test_an_answer_in_the_turn_in_which_whoever_asked_is_cut_off_is_late(
    runtime: RosRuntime,
) -> None:
    thread, sent = runtime.thread, threading.Event()
    late: list[object] = []
    asked: Any = import_module("rclpy.task").Future()

    def send() -> object:
        sent.set()
        return asked

    def cut_off() -> None:
        asking.cancel()

    asking = asyncio.create_task(thread.ask(send, "/omni/move", timeout_s=None, late=late.append))
    assert await asyncio.to_thread(sent.wait, 60 * pace())
    await thread.run(lambda: None)  # after it was sent it is waited for
    asked.set_result("accepted")
    thread.hand_over(cut_off)
    with pytest.raises(asyncio.CancelledError):
        await asking
    assert late == ["accepted"], "a goal would go on that nobody knows of"


async def test_a_turn_that_fails_does_not_end_the_link(
    runtime: RosRuntime, caplog: pytest.LogCaptureFixture
) -> None:
    def timer() -> None:
        raise RuntimeError("broken on purpose")

    clock = await runtime.thread.run(lambda: runtime.thread.node.create_timer(0.01, timer))
    await wait_until(lambda: runtime.thread.faults >= 3, "three faults", 30)
    await runtime.thread.run(lambda: runtime.thread.node.destroy_timer(clock))
    assert runtime.alive
    assert await runtime.thread.run(lambda: 7) == 7
    assert "a turn of the ROS thread failed (1 so far)" in caplog.text
    assert "(3 so far)" not in caplog.text


async def test_two_gateways_in_one_process_do_not_meet(
    graph: RosGraph, types: TypeRegistry
) -> None:
    async with await RosRuntime.open(types, domain_id=graph.domain_id) as one:
        async with await RosRuntime.open(
            types, domain_id=graph.domain_id, node_name="other"
        ) as two:
            assert await two.thread.run(lambda: 2) == 2
        assert not two.alive
        assert await one.thread.run(lambda: 1) == 1


async def test_when_ros_shuts_down_underneath_it_is_said(
    runtime: RosRuntime, caplog: pytest.LogCaptureFixture
) -> None:
    runtime.thread._context.shutdown()
    await wait_until(lambda: not runtime.alive, "the end", 30)
    await wait_until(lambda: "its robots are out of reach" in caplog.text, "the log", 30)
    with pytest.raises(NotSent):
        await runtime.thread.run(lambda: 1)


@pytest.mark.parametrize("name", ["", "1st", "a-b", "a/b", "größe", "x" * 201])
async def test_a_node_that_cannot_be_called_that(types: TypeRegistry, name: str) -> None:
    with pytest.raises(BadName, match="cannot be a node"):
        await RosRuntime.open(types, node_name=name)


@pytest.mark.parametrize("domain", [-1, 233])
async def test_a_domain_that_is_none(types: TypeRegistry, domain: int) -> None:
    with pytest.raises(BadName, match="from 0 to 232"):
        await RosRuntime.open(types, domain_id=domain)


def test_nothing_of_ros_is_imported_before_it_is_opened() -> None:
    done = python(
        """
        import sys
        import rosic.robots.ros2.client.graph, rosic.robots.ros2.client.runtime
        import rosic.robots.ros2.bindings.parameters
        import rosic.robots.ros2.interfaces.cache
        foreign = ("rclpy", "std_msgs", "rosidl")
        print(sorted(name for name in sys.modules if name.startswith(foreign)))
        """,
        dict(os.environ),
    )
    assert done.stdout.strip() == "[]", done.stderr


def test_without_ros_one_sentence_says_how_to_get_it() -> None:
    done = python(
        """
        import asyncio, importlib.abc, sys

        class Nothing(importlib.abc.MetaPathFinder):
            def find_spec(self, name, path, target=None):
                if name.split(".")[0] == "rclpy":
                    raise ModuleNotFoundError("No module named 'rclpy'")

        sys.meta_path.insert(0, Nothing())
        from rosic.robots.ros2.messages.types import TypeRegistry
        from rosic.robots.ros2.client.runtime import RosRuntime
        try:
            asyncio.run(RosRuntime.open(TypeRegistry([])))
        except Exception as error:
            print(type(error).__name__, error)
        """,
        dict(os.environ),
    )
    name, _, sentence = done.stdout.strip().partition(" ")
    assert name == RosMissing.__name__, done.stderr
    assert sentence.endswith(
        "Source your ROS 2 distribution, or run pip install 'rosic[ros2]' "
        "(in a checkout: .venv/bin/pip install -e '.[ros2]')."
    )


def test_a_process_that_forgets_to_close_still_ends_well(graph: RosGraph) -> None:
    done = python(
        """
        import asyncio
        from rosic.robots.ros2.messages.types import TypeRegistry
        from rosic.robots.ros2.client.runtime import RosRuntime

        async def main():
            global runtime
            runtime = await RosRuntime.open(TypeRegistry(["std_msgs/msg/String"]))
            await runtime.latest("/a", "std_msgs/msg/String")

        asyncio.run(main())
        print("over")
        """,
        graph.environment,
    )
    assert (done.returncode, done.stdout.strip()) == (0, "over"), done.stderr


def test_signals_stay_with_the_gateway(graph: RosGraph) -> None:
    done = python(
        """
        import asyncio, signal
        from rosic.robots.ros2.messages.types import TypeRegistry
        from rosic.robots.ros2.client.runtime import RosRuntime

        async def main():
            told = asyncio.Event()
            asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, told.set)
            async with await RosRuntime.open(TypeRegistry([])) as runtime:
                signal.raise_signal(signal.SIGTERM)
                await asyncio.wait_for(told.wait(), 60)
                print(await runtime.thread.run(lambda: "still here"))

        asyncio.run(main())
        """,
        graph.environment,
    )
    assert (done.returncode, done.stdout.strip()) == (0, "still here"), done.stderr


def test_a_python_of_another_environment_is_not_led_astray() -> None:
    """What the wheels of ROS 2 put into the environment of every child, and how to take it away."""
    inherited = os.environ | {"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"}
    libraries = f"{sys.prefix}/lib:{sys.prefix}/lib/python3/site-packages/ros.libs:/elsewhere/lib"
    cleaned = environment_for_another_python(inherited | {"LD_LIBRARY_PATH": libraries})
    assert "_ROS_WHEELS_BOOTSTRAP_COMPLETE" not in cleaned
    assert cleaned["LD_LIBRARY_PATH"] == "/elsewhere/lib"
    done = python("import rclpy; print('found')", cleaned)
    assert done.stdout.strip() == "found", done.stderr


# ---- the handover ----


async def test_a_burst_wakes_the_loop_once_and_keeps_its_order() -> None:
    loop = asyncio.get_running_loop()
    wakes: list[object] = []
    seen: list[int] = []

    class Loop:
        def call_soon_threadsafe(self, callback: object) -> None:
            wakes.append(callback)
            loop.call_soon_threadsafe(callback)  # type: ignore[arg-type]

        def call_soon(self, callback: object) -> None:
            loop.call_soon(callback)  # type: ignore[arg-type]

    handover = LoopBridge(Loop())  # type: ignore[arg-type]

    def burst() -> None:
        for number in range(1000):
            handover.offer(lambda number=number: seen.append(number))  # type: ignore[misc]

    burst()
    assert len(wakes) == 1
    await wait_until(lambda: len(seen) == 1000, "all of them", 30)
    assert seen == list(range(1000))
    assert len(wakes) == 1


async def test_a_burst_does_not_keep_the_loop_to_itself() -> None:
    handover = LoopBridge(asyncio.get_running_loop())
    turns: list[int] = []
    seen: list[int] = []
    for number in range(1000):
        handover.offer(lambda number=number: seen.append(number))  # type: ignore[misc]
    async with asyncio.timeout(60 * pace()):
        while len(seen) < 1000:
            await asyncio.sleep(0)
            turns.append(len(seen))
    assert turns[0] <= handing._PER_TURN
    assert len(turns) >= 1000 // handing._PER_TURN


async def test_what_comes_after_a_failure_is_delivered() -> None:
    loop = asyncio.get_running_loop()
    complaints: list[object] = []
    loop.set_exception_handler(lambda _loop, context: complaints.append(context["exception"]))
    handover = LoopBridge(loop)
    seen: list[int] = []
    handover.offer(lambda: seen.append(1 // 0))
    handover.offer(lambda: seen.append(2))
    await wait_until(lambda: seen == [2], "the second", 30)
    assert [type(complaint) for complaint in complaints] == [ZeroDivisionError]


async def test_what_waits_is_bounded_and_counted() -> None:
    handover = LoopBridge(asyncio.get_running_loop(), limit=10)
    seen: list[int] = []
    taken = [handover.offer(lambda: seen.append(1)) for _ in range(15)]
    assert taken == [True] * 10 + [False] * 5
    assert handover.refused == 5
    await wait_until(lambda: len(seen) == 10, "all of them", 30)
    assert handover.offer(lambda: None)


def test_a_loop_that_is_gone_is_no_error() -> None:
    loop = asyncio.new_event_loop()
    loop.close()
    assert LoopBridge(loop).offer(lambda: None) is False
