"""What comes from outside, in processes of their own: robots that report, people who command.

Started by `rosic.bench.scaling_process` as ``python -m rosic.bench.load_generator WHO SOCKET ...``.
It says on its standard output what it sent and what that cost, which is nobody's but its own.
"""

from __future__ import annotations

import socket
import sys
import time
from contextlib import suppress
from functools import partial
from itertools import count
from typing import TYPE_CHECKING, TypeAlias

import msgspec

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    Make: TypeAlias = Callable[[int], tuple[bytes, int]]

BEATS_PER_S = 5
TICK_S = 0.01
TICKS_PER_S = 100
CONNECTING_S = 20.0


class RobotHeartbeat(msgspec.Struct, array_like=True, tag=0, frozen=True, gc=False):
    """A robot says that it is there."""

    robot: str


class ReportedValues(msgspec.Struct, array_like=True, tag=1, frozen=True, gc=False):
    """What a robot reports of itself."""

    robot: str
    battery: float
    x_m: float
    y_m: float


class FeedRequest(msgspec.Struct, array_like=True, tag=2, frozen=True, gc=False):
    """What a person sends.

    Attributes:
        sent_ns: When it was due, on the clock of ``perf_counter_ns``, which all processes of a
            machine share. Whoever cannot send in time waits, and that counts (open loop).
        spent_ns: What the gateway's process has had of processors until then.
    """

    number: int
    person: int
    robot: str
    sent_ns: int
    spent_ns: int


class SendFigures(msgspec.Struct, frozen=True):
    """What was sent, and what that cost the process that did.

    Attributes:
        late_s: By how much it was behind at worst.
    """

    messages: int
    seconds: float
    cpu_s: float
    late_s: float


_encode = msgspec.msgpack.Encoder().encode


def frame(said: RobotHeartbeat | ReportedValues | FeedRequest) -> bytes:
    """Return one message as it goes over the line: its length in two bytes, then itself."""
    body = _encode(said)
    return len(body).to_bytes(2, "big") + body


def robot_name(number: int) -> str:
    """Return what the robot of a number is called."""
    return f"robot{number}"


def reports(number: int, round_: int) -> bytes:
    """Return what a robot says of itself in its round."""
    along = (number * 7 + round_) % 1_000 / 10
    return frame(ReportedValues(robot_name(number), 40.0 + along / 2, along, number % 100))


def ticks(robots: int) -> list[tuple[list[bytes], list[int]]]:
    """Return who says what in each hundredth of a second: robots are spread over it evenly.

    Returns:
        Heartbeats, and the numbers of robots that report.
    """
    every = TICKS_PER_S // BEATS_PER_S
    found: list[tuple[list[bytes], list[int]]] = [([], []) for _ in range(TICKS_PER_S)]
    for number in range(robots):
        phase = number * TICKS_PER_S // robots
        found[phase][1].append(number)
        beat = frame(RobotHeartbeat(robot_name(number)))
        for at in range(phase % every, TICKS_PER_S, every):
            found[at][0].append(beat)
    return found


def _robots(robots: int) -> Iterator[tuple[float, Make]]:
    """Yield when robots say something, and what makes their words, and counts them."""
    spread = ticks(robots)
    for tick in count():
        beats, reporting = spread[tick % TICKS_PER_S]
        if beats or reporting:
            yield tick * TICK_S, partial(_tick, beats, reporting, tick // TICKS_PER_S)


def _tick(beats: list[bytes], reporting: list[int], round_: int, _due_ns: int) -> tuple[bytes, int]:
    said = b"".join((*beats, *(reports(number, round_) for number in reporting)))
    return said, len(beats) + len(reporting)


def _people(people: int, robots: int, per_s: int, gateway: int) -> Iterator[tuple[float, Make]]:
    """Yield when people send something, in turns to robots in turns."""
    spent = (~gateway << 3) | 2  # the clock of a process, as clock_getcpuclockid(3) makes it
    for number in count():
        robot = robot_name(number % robots)
        yield number / per_s, partial(_wish, number, number % people, robot, spent)


def _wish(number: int, person: int, robot: str, spent: int, due_ns: int) -> tuple[bytes, int]:
    spent_ns = time.clock_gettime_ns(spent)
    return frame(FeedRequest(number, person, robot, due_ns, spent_ns)), 1


def send(path: str, said: Iterator[tuple[float, Make]]) -> SendFigures:
    """Send each when it is time, until the other side has heard enough."""
    messages, late_s = 0, 0.0
    with socket.socket(socket.AF_UNIX) as line:
        line.settimeout(CONNECTING_S)
        line.connect(path)
        line.recv(1)  # the other side says when to begin
        began, cpu_s = time.perf_counter(), time.process_time()
        with suppress(OSError):  # the other side has heard enough
            for due_s, make in said:
                wait_s = began + due_s - time.perf_counter()
                if wait_s > 0:
                    time.sleep(wait_s)
                late_s = max(late_s, -wait_s)
                words, number = make(int((began + due_s) * 1e9))
                line.sendall(words)
                messages += number
    return SendFigures(messages, time.perf_counter() - began, time.process_time() - cpu_s, late_s)


def main(who: str, path: str, *numbers: str) -> None:
    """Be the robots, or the people."""
    some = map(int, numbers)
    sent = send(path, _robots(*some) if who == "robots" else _people(*some))
    sys.stdout.write(msgspec.json.encode(sent).decode() + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
