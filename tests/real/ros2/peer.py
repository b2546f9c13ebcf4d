"""A robot's side for tests: plain rclpy, none of ROSIC. Ends when its standard input ends.

Usage: peer.py [FOLDER_OF_BUILT_INTERFACES]. Commands come as lines on standard input; see `Peer`.
Modules are imported by name because ROS has no types to check against.
"""

from __future__ import annotations

import hashlib
import sys
import threading
import time
from importlib import import_module
from pathlib import Path
from typing import Any, TypeAlias

RosObject: TypeAlias = Any

rclpy: Any = import_module("rclpy")
actions: Any = import_module("rclpy.action")
executors: Any = import_module("rclpy.executors")
std: Any = import_module("std_msgs.msg")
AddDiagnostics: Any = import_module("diagnostic_msgs.srv").AddDiagnostics
CancelGoal: Any = import_module("action_msgs.srv").CancelGoal


def say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


class Peer:
    """Under /omni: a velocity it writes down, text it gives back, services, and an action."""

    def __init__(self, node: RosObject) -> None:
        services: Any = import_module("std_srvs.srv")
        twist: Any = import_module("geometry_msgs.msg").Twist
        self.node = node
        self.group = import_module("rclpy.callback_groups").ReentrantCallbackGroup()
        self.hesitates = self.jammed = False
        self.metre_s = 1.0
        node.declare_parameter("speed_m_s", 0.5)
        self.counter = node.create_publisher(std.Int32, "count", 10)
        self.voice = node.create_publisher(std.String, "from_robot_topic", 50)
        node.create_subscription(twist, "cmd_vel", self.on_twist, 10)
        node.create_subscription(std.String, "to_robot_topic", self.on_text, 10)
        self.read = node.create_publisher(std.String, "file_read", 10)
        node.create_subscription(std.String, "file", self.on_file, 10)
        node.create_subscription(std.String, "mission", self.on_mission, 10)
        for kind, name, answer in (
            (services.Trigger, "stop", self.on_stop),
            (services.SetBool, "slow", self.on_slow),
            (AddDiagnostics, "take", self.on_take),
            (services.SetBool, "latch", self.on_latch),
            (CancelGoal, "code", self.on_code),
        ):
            node.create_service(kind, name, answer, callback_group=self.group)

    # ---- what ROS asks ----

    def on_twist(self, message: RosObject) -> None:
        say(f"twist {message.linear.x!r} {message.angular.z!r}")

    def on_text(self, message: RosObject) -> None:
        self.voice.publish(std.String(data=f"heard: {message.data}"))

    def on_take(self, request: RosObject, response: RosObject) -> RosObject:
        """Take a file by its path, unless it is called so that it is declined; say its checksum."""
        path = Path(request.load_namespace)
        response.success = "bad" not in path.name
        response.message = (
            hashlib.sha256(path.read_bytes()).hexdigest() if response.success else "no room"
        )
        say(f"took {path.name}")
        return response

    def on_file(self, message: RosObject) -> None:
        """Read a file by its path and say its checksum, or another one, or nothing."""
        path = Path(message.data)
        content = path.read_bytes() + (b"!" if "other" in path.name else b"")
        say(f"read {path.name}")
        if "silent" not in path.name:
            self.read.publish(std.String(data="thank you"))
            self.read.publish(std.String(data=hashlib.sha256(content).hexdigest().upper()))

    def on_mission(self, message: RosObject) -> None:
        say(f"mission {message.data!r}")

    def on_stop(self, _request: RosObject, response: RosObject) -> RosObject:
        response.success, response.message = True, "at rest"
        say("stopped")
        return response

    def on_latch(self, request: RosObject, response: RosObject) -> RosObject:
        """Hold, or hold no longer; a release is declined while it is jammed."""
        response.success = request.data or not self.jammed
        response.message = "" if response.success else "the button is pressed"
        say(f"latch {request.data}")
        return response

    def on_code(self, request: RosObject, response: RosObject) -> RosObject:
        """Answer by the code that it was asked for."""
        response.return_code = request.goal_info.stamp.sec
        return response

    def on_slow(self, request: RosObject, response: RosObject) -> RosObject:
        time.sleep(1.0 if request.data else 0.2)
        response.success = True
        say(f"slow done {request.data}")
        return response

    def on_goal(self, goal: RosObject) -> RosObject:
        say(f"goal {goal.direction} {goal.distance_m}")
        if self.hesitates:
            time.sleep(1.0)
        answer = actions.GoalResponse
        return answer.REJECT if goal.distance_m > 5 else answer.ACCEPT

    def on_move(self, goal: RosObject) -> RosObject:
        """Take one second for a metre, unless it dawdles."""
        move = import_module("rosic_interfaces.action").Move
        result = move.Result(fact_names=["distance_m"])
        steps = 20
        for step in range(steps):
            if goal.is_cancel_requested:
                goal.canceled()
                result.message, result.fact_values = "called off", [step / steps]
                say(f"called off after {step}")
                return result
            goal.publish_feedback(move.Feedback(fraction=step / steps, stage="rolling"))
            time.sleep(goal.request.distance_m * self.metre_s / steps)
        goal.succeed()
        distance = goal.request.distance_m
        result.success, result.message, result.fact_values = True, "there", [distance]
        say("moved")
        return result

    # ---- what the test asks ----

    def hesitate(self, _rest: str) -> None:
        """Take a second from now on before a goal is accepted."""
        self.hesitates = True

    def jam(self, rest: str) -> None:
        """Decline to release what holds from now on, or ``jam off`` no more."""
        self.jammed = rest != "off"

    def dawdle(self, rest: str) -> None:
        """Take so many seconds for a metre from now on."""
        self.metre_s = float(rest)

    def listeners(self, rest: str) -> None:
        """Wait until so many listen: each side of a topic discovers the other in its own time."""
        name, number = rest.split()
        publisher = {"count": self.counter, "voice": self.voice}[name]
        end = time.monotonic() + 60
        while publisher.get_subscription_count() < int(number) and time.monotonic() < end:
            time.sleep(0.005)

    def burst(self, rest: str) -> None:
        """Send so many numbers, counting from 1."""
        for number in range(1, int(rest) + 1):
            self.counter.publish(std.Int32(data=number))

    def texts(self, rest: str) -> None:
        """Say so many words."""
        for number in range(1, int(rest) + 1):
            self.voice.publish(std.String(data=str(number)))

    def flood(self, rest: str) -> None:
        """Send numbers as fast as can be, for so many seconds, and -1 at the end."""
        end = time.monotonic() + float(rest)
        count = 0
        while time.monotonic() < end:
            count += 1
            self.counter.publish(std.Int32(data=count))
        time.sleep(0.2)
        for _ in range(3):
            self.counter.publish(std.Int32(data=-1))
        say(f"sent {count}")

    def obey(self) -> None:
        for line in sys.stdin:
            word, _, rest = line.strip().partition(" ")
            getattr(self, word)(rest)
            say(f"ok {word}")


def spin(executor: RosObject) -> None:
    try:
        executor.spin()
    except executors.ExternalShutdownException:
        return


def main() -> None:
    sys.path[:0] = sys.argv[1:]
    no_signals = import_module("rclpy.signals").SignalHandlerOptions.NO
    rclpy.init(signal_handler_options=no_signals)
    peer = Peer(rclpy.create_node("robot", namespace="/omni"))
    if len(sys.argv) > 1:
        actions.ActionServer(
            peer.node,
            import_module("rosic_interfaces.action").Move,
            "move",
            peer.on_move,
            goal_callback=peer.on_goal,
            cancel_callback=lambda _goal: actions.CancelResponse.ACCEPT,
            callback_group=peer.group,
        )
    executor = executors.MultiThreadedExecutor(num_threads=6)
    executor.add_node(peer.node)
    thread = threading.Thread(target=spin, args=(executor,))
    thread.start()
    say("ready")
    peer.obey()
    executor.shutdown(timeout_sec=1)
    thread.join()  # a thread inside rclpy would take the process with it at its end
    peer.node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
