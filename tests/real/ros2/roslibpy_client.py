"""What the official Python client of rosbridge does, in a process of its own: one line for each.

Usage: roslibpy_client.py URL KEY
"""

from __future__ import annotations

import sys
import threading
import time
from importlib import import_module
from typing import Any

roslibpy: Any = import_module("roslibpy")
WITHIN_S = 30.0
MOST = 200


def tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def topics(ros: Any) -> None:  # noqa: ANN401 - roslibpy has no types
    names = ros.get_topics()
    tell(f"topics {'/chatter' in names} {'/omni/odom' in names} {'/secret' in names}")
    tell(f"type {ros.get_topic_type('/omni/odom')}")
    tell(f"time {ros.get_time().to_sec() > 1_700_000_000}")


def chatter(ros: Any) -> None:  # noqa: ANN401 - likewise
    """Publish to a topic and hear it there, through the graph, in order."""
    heard: list[str] = []
    all_there = threading.Event()

    def hear(message: dict[str, str]) -> None:
        heard.append(message["data"])
        if len(heard) == MOST:
            all_there.set()

    topic = roslibpy.Topic(ros, "/chatter", "std_msgs/String")
    topic.subscribe(hear)
    end_s = time.monotonic() + WITHIN_S
    while not heard and time.monotonic() < end_s:
        topic.publish(roslibpy.Message({"data": "first"}))
        time.sleep(0.1)
    time.sleep(0.3)
    heard.clear()
    for number in range(MOST):
        topic.publish(roslibpy.Message({"data": str(number)}))
    all_there.wait(WITHIN_S)
    tell(f"chatter {heard == [str(n) for n in range(MOST)]}")
    topic.unsubscribe()


def drive(ros: Any) -> None:  # noqa: ANN401 - likewise
    """Drive for a second, let go, and see that it has moved, by its own odometry."""
    places: list[float] = []
    odometry = roslibpy.Topic(ros, "/omni/odom", "nav_msgs/Odometry", throttle_rate=50)
    odometry.subscribe(lambda m: places.append(m["pose"]["pose"]["position"]["x"]))
    topic = roslibpy.Topic(ros, "/omni/cmd_vel", "geometry_msgs/Twist")
    end_s = time.monotonic() + WITHIN_S
    while (not places or places[-1] < 0.2) and time.monotonic() < end_s:
        topic.publish(roslibpy.Message({"linear": {"x": 0.3}}))
        time.sleep(0.05)
    topic.publish(roslibpy.Message({"linear": {"x": 0.0}}))
    time.sleep(1.0)
    resting = places[-1]
    time.sleep(0.5)
    tell(f"drive {resting >= 0.2} {abs(places[-1] - resting) < 0.005}")
    odometry.unsubscribe()


def goal(ros: Any) -> None:  # noqa: ANN401 - likewise
    """Send a goal, and hear of it."""
    ended = threading.Event()
    found: list[Any] = []
    feedback: list[Any] = []

    def over(result: Any) -> None:  # noqa: ANN401 - likewise
        found.append(result)
        ended.set()

    client = roslibpy.ActionClient(ros, "/omni/move", "rosic_interfaces/Move")
    asked = {"direction": "back", "distance_m": 0.2, "speed_m_s": 0.3}
    client.send_goal(roslibpy.Goal(asked), over, feedback.append, over)
    ended.wait(WITHIN_S)
    tell(f"goal {found[0]['status'].name} {bool(feedback)}")


def stop(ros: Any) -> None:  # noqa: ANN401 - likewise
    """Call the robot's own stop."""
    service = roslibpy.Service(ros, "/omni/stop", "std_srvs/Trigger")
    tell(f"stop {service.call(roslibpy.ServiceRequest({}))['success']}")


def main() -> None:
    url, key = sys.argv[1:]
    ros = roslibpy.Ros(url, headers={"Authorization": f"Bearer {key}"})
    ros.run()
    for each in (topics, chatter, drive, goal, stop):
        each(ros)
    ros.close()
    tell("over")
    ros.terminate()


if __name__ == "__main__":
    main()
