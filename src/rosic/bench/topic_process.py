"""The robot's side of `rosic bench api`: a plain ROS 2 node in a process of its own.

It hears one topic and publishes to another, with rclpy and nothing else, and takes down when each
message came. Started by `rosic.bench.api`; takes commands as lines:

    clear               forget what was heard so far
    heard               say whether anything was heard since
    report COUNT        when so many were heard, or none for a while, say what was seen
    publish SIZE RATE SECONDS COUNT    publish, and say how many
"""

from __future__ import annotations

import queue
import sys
import threading
import time
from importlib import import_module
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.bench.report import quantile
from rosic.core.time_units import SECOND_NS
from rosic.robots.ros2.client.rclpy_import import load_ros

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject

TYPE: Final = "std_msgs/msg/String"
TO_ROS: Final = "/bench/to_ros"
FROM_ROS: Final = "/bench/from_ros"
DEPTH: Final = 20_000
QUIET_S: Final = 2.0
"""After so long without a message no more is waited for."""
AT_MOST_S: Final = 60.0
MATCHED_WITHIN_S: Final = 20.0
HELLO: Final = -1
HEAD: Final = slice(8, 56)
"""Where number and time stand in a serialised text: behind how it is encoded, and how long."""


class StreamFigures(msgspec.Struct, frozen=True, kw_only=True):
    """What was heard of a stream of messages.

    Attributes:
        count: How many different ones.
        rate_per_s: From the first to the last.
        p50_us, p99_us: From the moment that each was made.
        repeated: How many came again.
    """

    count: int = 0
    rate_per_s: float = 0.0
    p50_us: float = 0.0
    p99_us: float = 0.0
    repeated: int = 0


class MessageTimes:
    """When messages of one stream came, by the clock of this machine."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._taken_ns: list[int] = []
        self._numbers: set[int] = set()
        self._repeated = 0
        self._first_ns = self.last_ns = 0
        self.said_hello = False

    def note(self, head: str | bytes) -> None:
        """Take in a message, by its number and the moment when it was made."""
        now_ns = time.monotonic_ns()
        number, made_ns, *_ = head.split()
        if int(number) == HELLO:
            self.said_hello = True
            return
        if int(number) in self._numbers:
            self._repeated += 1
            return
        self._numbers.add(int(number))
        self._first_ns = self._first_ns or now_ns
        self.last_ns = now_ns
        self._taken_ns.append(now_ns - int(made_ns))

    def __len__(self) -> int:
        return len(self._taken_ns)

    def figures(self) -> StreamFigures:
        """Return what was heard."""
        taken, lasted_ns = self._taken_ns, self.last_ns - self._first_ns
        if not taken:
            return StreamFigures(repeated=self._repeated)
        return StreamFigures(
            count=len(taken),
            rate_per_s=(len(taken) - 1) * SECOND_NS / lasted_ns if lasted_ns else 0.0,
            p50_us=quantile(taken, 0.5) / 1e3,
            p99_us=quantile(taken, 0.99) / 1e3,
            repeated=self._repeated,
        )


def content(number: int, size: int) -> str:
    """Return a text of so many bytes that says its number and when it was made."""
    return f"{number} {time.monotonic_ns()} ".ljust(size, "x")


class Pace(NamedTuple):
    """How a stream is sent.

    Attributes:
        rate_per_s: 0: as fast as it goes.
        most: So many messages at most.
    """

    size: int
    rate_per_s: float
    seconds: float
    most: int

    def due_s(self, number: int) -> float:
        """Return how long after the first a message is sent."""
        return number / self.rate_per_s if self.rate_per_s else 0.0


def pace_of(words: list[str]) -> Pace:
    """Read a pace: SIZE RATE SECONDS COUNT."""
    size, rate, seconds, most = words
    return Pace(int(size), float(rate), float(seconds), int(most))


def tell(word: str, value: object = None) -> None:
    """Say one line."""
    said = "" if value is None else msgspec.json.encode(value).decode()
    sys.stdout.write(f"{word} {said}\n")
    sys.stdout.flush()


class BenchNode:
    """A node that hears one topic and publishes to another."""

    def __init__(self, hears: str, publishes: str) -> None:
        self._ros = load_ros()
        text = self._ros.qos.QoSProfile(depth=DEPTH)
        self._type: RosObject = import_module("std_msgs.msg").String
        self._ros.rclpy.init()
        self._node = self._ros.node.Node("bench")
        self.arrivals = MessageTimes()
        self._heard = self._node.create_subscription(self._type, hears, self._take, text, raw=True)
        self._publisher = self._node.create_publisher(self._type, publishes, text)
        self._executor = self._ros.executors.SingleThreadedExecutor()
        self._executor.add_node(self._node)

    def _take(self, raw: bytes) -> None:
        self.arrivals.note(raw[HEAD])
        # What waits is taken at once: an executor's turn for each would be what is measured.
        while (more := self._heard.handle.take_message(self._type, True)) is not None:
            self.arrivals.note(more[0][HEAD])

    def spin(self, within_s: float) -> None:
        """Take what comes."""
        self._executor.spin_once(timeout_sec=within_s)

    def report(self, count: int) -> StreamFigures:
        """Wait until so many were heard, or nothing comes any more."""
        end_s, seen, since_s = time.monotonic() + AT_MOST_S, -1, time.monotonic()
        while len(self.arrivals) < count and time.monotonic() < end_s:
            self.spin(0.1)
            if len(self.arrivals) != seen:
                seen, since_s = len(self.arrivals), time.monotonic()
            elif time.monotonic() - since_s > QUIET_S:
                break
        return self.arrivals.figures()

    def publish(self, pace: Pace) -> int:
        """Publish at a pace, once somebody hears. Return how many."""
        end_s = time.monotonic() + MATCHED_WITHIN_S
        while self._publisher.get_subscription_count() == 0 and time.monotonic() < end_s:
            self.spin(0.05)
        begun_s = time.monotonic()
        for number in range(pace.most):
            due_s = begun_s + pace.due_s(number)
            if due_s > begun_s + pace.seconds or time.monotonic() > begun_s + pace.seconds:
                return number
            while (left_s := due_s - time.monotonic()) > 0:
                time.sleep(left_s)
            self._publisher.publish(self._type(data=content(number, pace.size)))
        return pace.most

    def hello(self) -> None:
        """Publish what does not count, so that the other side knows that it hears."""
        self._publisher.publish(self._type(data=content(HELLO, 64)))


def main() -> None:
    """Do what the lines say, until they end."""
    node = BenchNode(*sys.argv[1:3])
    lines: queue.SimpleQueue[str] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(lines,), daemon=True).start()
    tell("ready")
    while True:
        node.spin(0.02)
        try:
            word, *rest = lines.get_nowait().split()
        except queue.Empty:
            continue
        if word == "end":
            return
        _do(node, word, rest)


def _do(node: BenchNode, word: str, rest: list[str]) -> None:
    if word == "clear":
        node.arrivals.clear()
        tell("cleared")
    elif word == "heard":
        tell("heard", node.arrivals.said_hello)
    elif word == "report":
        tell("seen", node.report(int(rest[0])))
    elif word == "hello":
        node.hello()
    elif word == "publish":
        tell("published", node.publish(pace_of(rest)))


def _read(lines: queue.SimpleQueue[str]) -> None:
    for line in sys.stdin:
        lines.put(line)
    lines.put("end")


if __name__ == "__main__":
    main()
