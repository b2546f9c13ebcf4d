"""The simulated omni as a ROS 2 node that can be told to fail. Usage: untrue_omni.py FILE.

FILE takes a line whenever it acts. Lines on standard input are answered by ``ok`` and, for
``moves``, whether it does:

    reset     it rests, and is honest again; orders that it ignored are turned down
    silent    it tells nothing of itself and of its goals any more; it still hears
    ignore    it takes no goal and answers none; its odometry goes on
    at X      it says once that so much of its goal is done
    done      it says that its goal is done, and goes on moving
"""

from __future__ import annotations

import queue
import sys
import threading
import time
from pathlib import Path

from rosic.robots.ros2.client.rclpy_import import find_own_interfaces, load_ros, make_executor
from rosic_sim.robots.machines.activity import ActivityState
from rosic_sim.robots.machines.world import build_world
from rosic_sim.ros2.endpoints import ActuationLog
from rosic_sim.ros2.machine_node import NODE_NAME, LinkWatchdog, MachineNode
from rosic_sim.ros2.waiting_clock import WaitingClock

OMNI = "omni"
TURN_S = 0.01
IGNORED_TURNS = 50
END = "end"


class UntrueOmni(MachineNode):
    """Honest until it is told otherwise.

    Attributes:
        silent: It tells nothing.
        ignores: Nothing that is sent to it is looked at.
    """

    silent = False
    ignores = False

    def turn(self) -> None:
        """Step, and tell what there is to tell unless it is silent."""
        if self.silent:
            self.machine.step(self.now_s())
        else:
            super().turn()

    def obey(self, line: str) -> bool | None:
        """Do what stands on a line."""
        word, _, value = line.partition(" ")
        activity = self.machine.activity
        if word == "silent":
            self.silent = True
        elif word == "ignore":
            self.ignores = True
        elif word == "at" and activity is not None:
            activity.fraction = float(value)
        elif word == "done" and activity is not None:
            activity.end(ActivityState.DONE, "")
        return not self.machine.at_rest() if word == "moves" else None


class Site:
    """The node and whoever turns it: all on one thread."""

    def __init__(self, actuations: Path) -> None:
        ros = load_ros()
        self._context = ros.rclpy.Context()
        ros.rclpy.init(
            context=self._context, signal_handler_options=ros.signals.SignalHandlerOptions.NO
        )
        self._executor = make_executor(ros, self._context)
        node = ros.node.Node(
            NODE_NAME, namespace=f"/{OMNI}", context=self._context, use_global_arguments=False
        )
        self._executor.add_node(node)
        self._log = ActuationLog(actuations)
        self.omni = UntrueOmni(
            node,
            OMNI,
            build_world(),
            WaitingClock(),
            self._log,
            starts=ActuationLog(None),
            watch=LinkWatchdog(),
        )

    def turn(self) -> None:
        """Hear what comes for a moment, unless it ignores that; let the robot have its turn."""
        if self.omni.ignores:
            time.sleep(TURN_S)
        else:
            self._executor.spin_once(timeout_sec=TURN_S)
        self.omni.turn()

    def reset(self) -> None:
        """Turn down what was ignored, and come to rest."""
        omni = self.omni
        omni.silent = omni.ignores = omni.linked = False
        for _ in range(IGNORED_TURNS):
            self.turn()
        omni.linked = True
        omni.machine.halt(omni.now_s())
        while omni.machine.moving:
            self.turn()

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self.omni.close()
        self._context.try_shutdown()
        self._log.close()


def main() -> None:
    lines: queue.Queue[str] = queue.Queue()

    def listen() -> None:
        for line in sys.stdin:
            lines.put(line.strip())
        lines.put(END)

    find_own_interfaces()
    site, line = Site(Path(sys.argv[1])), ""
    threading.Thread(target=listen, daemon=True).start()
    tell("ready")
    while line != END:
        site.turn()
        line = "" if lines.empty() else lines.get()
        if line == "reset":
            site.reset()
        if line:
            tell(f"ok {site.omni.obey(line)}")
    site.close()


def tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
