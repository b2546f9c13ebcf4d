"""A base and the gateway's side, each a process of its own: to be frozen, killed, and back."""

from __future__ import annotations

import signal
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rosic.testing.ros2.graph import RosGraph, RosProcess

HERE = Path(__file__).parent
FREEZE, GO_ON = signal.SIGSTOP, signal.SIGCONT
ENDED_WITHIN_S = 30.0


class Velocity(NamedTuple):
    """One that was not zero: when it was sent, and when the robot took it; wall clock."""

    sent_ns: int
    taken_ns: int
    m_s: float


def velocities_in(file: Path) -> list[Velocity]:
    """Return what a base has written down."""
    lines = file.read_text().splitlines() if file.exists() else []
    each = [line.split() for line in lines]
    return [Velocity(int(one[0]), int(one[1]), float(one[2])) for one in each if len(one) == 3]


class Site:
    """A base and the gateway's side.

    Args:
        graph: What they are on.
        folder: For what the base writes down.
        within_s: How old what shows its rest may be.
    """

    driver = "tests.real.ros2.stream_driver"

    def __init__(self, graph: RosGraph, folder: Path, within_s: float = 1.0) -> None:
        self._graph = graph
        self._file = folder / "velocities"
        self._seen = 0
        self.base = self.begin_base()
        self.gateway = graph.start("-m", self.driver, str(within_s))

    def begin_base(self) -> RosProcess:
        """Start the robot's side, anew."""
        self.base = self._graph.start(HERE / "base_node.py", self._file, "base")
        return self.base

    def heir(self) -> RosProcess:
        """Return one that is ready to take the robot's side's place, once told to begin."""
        return self._graph.start(HERE / "base_node.py", self._file, "base", "standby")

    def velocities(self, since_ns: int = 0) -> list[Velocity]:
        """Return those that the robot has taken since a time."""
        return [velocity for velocity in velocities_in(self._file) if velocity.taken_ns >= since_ns]

    def drive(self, seconds: float, before_s: float) -> None:
        """Drive, and return so many seconds after it was measured to move."""
        self.tell(f"drive {seconds}")
        self.told("driving")
        time.sleep(before_s)

    def tell(self, line: str) -> None:
        """Tell the gateway; what it says from now on is the answer."""
        self._seen = len(self.gateway.lines)
        self.gateway.say(line)

    def told(self, beginning: str) -> str:
        """Return what the gateway said, or says soon, that begins so; in whatever order."""
        end_s = time.monotonic() + ENDED_WITHIN_S
        while time.monotonic() < end_s:
            for line in list(self.gateway.lines)[self._seen :]:
                if line.startswith(beginning):
                    return line.removeprefix(beginning).strip()
            time.sleep(0.01)
        raise AssertionError(f"nothing began with {beginning!r}: {list(self.gateway.lines)[-9:]}")

    def ended(self) -> str:
        """Return how the drive ended."""
        return self.told("ended")

    def measure_again(self) -> None:
        """Let the robot tell where it is, and return once the gateway has heard it."""
        self.base.say("odometry on")
        self.told_after("presence", "online True at_rest True")

    def told_after(self, line: str, wanted: str) -> None:
        """Ask again and again until the gateway says so."""
        end_s = time.monotonic() + ENDED_WITHIN_S
        self.tell(line)
        while not any(seen == wanted for seen in list(self.gateway.lines)[self._seen :]):
            assert time.monotonic() < end_s, list(self.gateway.lines)[-9:]
            time.sleep(0.1)
            self.gateway.say(line)

    def frozen(self, process: RosProcess, seconds: float) -> int:
        """Freeze a process for a while. Return when it goes on."""
        process.process.send_signal(FREEZE)
        time.sleep(seconds)
        now_ns = time.time_ns()
        process.process.send_signal(GO_ON)
        return now_ns
