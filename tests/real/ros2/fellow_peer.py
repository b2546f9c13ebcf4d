"""Robots' own nodes for tests: plain rclpy, none of ROSIC. Ends when its standard input ends.

Usage: fellow_peer.py ROBOT... Commands come as lines on standard input: ``say omni {...}``,
``flood omni SECONDS``, ``large omni BYTES``. What a robot hears is printed: ``heard omni {...}``.
By services that another node of the robot offers: ``get omni cf1.road ...``, ``help omni -`` and
``share omni {"road": true}``, answered by ``got [...]``, ``helped [...]`` and ``shared [...]``.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from functools import partial
from importlib import import_module
from typing import Any, TypeAlias

RosObject: TypeAlias = Any

rclpy: Any = import_module("rclpy")
executors: Any = import_module("rclpy.executors")
Parameter: Any = import_module("rclpy.parameter").Parameter
String: Any = import_module("std_msgs.msg").String
Trigger: Any = import_module("std_srvs.srv").Trigger
services: Any = import_module("rcl_interfaces.srv")

A_SECOND = 10_000
IN_ONE_GO = 100


def out(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


class Nodes:
    """One node for each robot."""

    def __init__(self, robots: list[str]) -> None:
        self.nodes = {robot: rclpy.create_node("brain", namespace=f"/{robot}") for robot in robots}
        self.voices = {
            robot: node.create_publisher(String, "among/say", 50)
            for robot, node in self.nodes.items()
        }
        self.gets, self.shares, self.helps = (
            {robot: node.create_client(kind, name) for robot, node in self.nodes.items()}
            for kind, name in (
                (services.GetParameters, "among/get"),
                (services.SetParameters, "among/share"),
                (Trigger, "among/help"),
            )
        )
        for robot, node in self.nodes.items():
            node.create_subscription(String, "among/hear", partial(self.heard, robot), 50)

    def heard(self, robot: str, message: RosObject) -> None:
        out(f"heard {robot} {message.data}")

    def obey(self) -> None:
        for line in sys.stdin:
            word, robot, rest = line.rstrip("\n").split(" ", 2)
            getattr(self, word)(robot, rest)
            out(f"ok {word}")

    def meet(self, robot: str, _rest: str) -> None:
        """Wait until both topics are matched."""
        end = time.monotonic() + 20
        voice, node = self.voices[robot], self.nodes[robot]
        while time.monotonic() < end:
            if voice.get_subscription_count() and node.count_publishers(f"/{robot}/among/hear"):
                return
            time.sleep(0.01)

    def say(self, robot: str, rest: str) -> None:
        self.voices[robot].publish(String(data=rest))

    def large(self, robot: str, rest: str) -> None:
        filler = "x" * int(rest)
        self.say(robot, f'{{"kind":"share","ref":"large","topic":"map","data":"{filler}"}}')

    def get(self, robot: str, rest: str) -> None:
        answer = self._call(self.gets[robot], services.GetParameters.Request(names=rest.split()))
        values = [rclpy.parameter.parameter_value_to_python(value) for value in answer.values]
        out(f"got {json.dumps(values)}")

    def share(self, robot: str, rest: str) -> None:
        parameters = [Parameter(n, value=v).to_parameter_msg() for n, v in json.loads(rest).items()]
        request = services.SetParameters.Request(parameters=parameters)
        answer = self._call(self.shares[robot], request)
        out(f"shared {json.dumps([[one.successful, one.reason] for one in answer.results])}")

    def help(self, robot: str, _rest: str) -> None:
        answer = self._call(self.helps[robot], Trigger.Request())
        out(f"helped {json.dumps([answer.success, answer.message])}")

    def _call(self, client: RosObject, request: RosObject) -> RosObject:
        """Ask, and wait here, in the main thread: the executor has its own."""
        client.wait_for_service(20)
        answered = threading.Event()
        future = client.call_async(request)
        future.add_done_callback(lambda _: answered.set())
        answered.wait(20)
        return future.result()

    def flood(self, robot: str, rest: str) -> None:
        """Share numbers, 10,000 a second as far as this machine comes to it."""
        begun, count = time.monotonic(), 0
        while time.monotonic() - begun < float(rest):
            due = int((time.monotonic() - begun) * A_SECOND)
            for _ in range(min(due - count, IN_ONE_GO)):
                count += 1
                self.say(robot, f'{{"kind":"share","topic":"road","data":{count}}}')
            time.sleep(0.001)
        time.sleep(0.3)
        self.say(robot, '{"kind":"share","topic":"road","data":"last"}')
        out(f"sent {count}")


def spin(executor: RosObject) -> None:
    try:
        executor.spin()
    except executors.ExternalShutdownException:
        return


def main() -> None:
    rclpy.init(signal_handler_options=import_module("rclpy.signals").SignalHandlerOptions.NO)
    nodes = Nodes(sys.argv[1:])
    executor = executors.SingleThreadedExecutor()
    for node in nodes.nodes.values():
        executor.add_node(node)
    thread = threading.Thread(target=spin, args=(executor,))
    thread.start()
    out("ready")
    nodes.obey()
    executor.shutdown(timeout_sec=1)
    thread.join()
    for node in nodes.nodes.values():
        node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
