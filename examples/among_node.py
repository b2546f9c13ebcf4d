"""Services for a robot's own nodes: share, read what others share, call for help.

A plain rclpy node that needs nothing of ROSIC: copy it into a package of the robot's own, and let
it run beside the others, on the robot, in the robot's namespace:

    python3 among_node.py --ros-args -r __ns:=/omni

    ros2 service call /omni/among/share rcl_interfaces/srv/SetParameters \
        "{parameters: [{name: road, value: {type: 4, string_value: wet}}]}"
    ros2 service call /omni/among/get rcl_interfaces/srv/GetParameters \
        "{names: [cf1.road, cf1.road.age_s]}"
    ros2 service call /omni/among/help std_srvs/srv/Trigger
"""

from __future__ import annotations

import json
import time
from uuid import uuid4

import rclpy
from rcl_interfaces.msg import ParameterType, ParameterValue, SetParametersResult
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import Trigger

ANSWER_WITHIN_S = 5.0
ABOUT = ("age_s", "at_s", "id")
NO_ANSWER = {"ok": False, "why": "ROSIC did not answer in time."}
NOT_FINITE = {"ok": False, "why": "A number that is not finite cannot be shared."}


class AmongNode(Node):
    """Says on ``among/say`` what it is asked, and answers with what ``among/hear`` brings back.

    A callback that waits is a coroutine, and in a group of callbacks that may overlap: so what it
    waits for is heard meanwhile, and one thread is enough.
    """

    def __init__(self) -> None:
        super().__init__("among")
        self._waiting: dict[str, tuple[float, Future]] = {}
        self._voice = self.create_publisher(String, "among/say", 10)
        self.create_subscription(String, "among/hear", self._heard, 50)
        self.create_timer(0.5, self._give_up)
        self.declare_parameter("help", "It cannot go on by itself.")
        waits = ReentrantCallbackGroup()
        self.create_service(SetParameters, "among/share", self._share, callback_group=waits)
        self.create_service(GetParameters, "among/get", self._get, callback_group=waits)
        self.create_service(Trigger, "among/help", self._help, callback_group=waits)

    # ---- the two topics ----

    def _say(self, kind: str, **said: object) -> Future:
        """Say something; the future has what became of it."""
        ref, answer = uuid4().hex, Future()
        try:
            words = json.dumps({"kind": kind, "ref": ref, **said}, allow_nan=False)
        except ValueError:
            answer.set_result(NOT_FINITE)
        else:
            self._waiting[ref] = (time.monotonic() + ANSWER_WITHIN_S, answer)
            self._voice.publish(String(data=words))
        return answer

    def _heard(self, message: String) -> None:
        heard = json.loads(message.data)
        if heard["kind"] == "result" and heard["ref"] in self._waiting:
            self._waiting.pop(heard["ref"])[1].set_result(heard)

    def _give_up(self) -> None:
        for ref, (until_s, answer) in tuple(self._waiting.items()):
            if time.monotonic() > until_s:
                del self._waiting[ref]
                answer.set_result(NO_ANSWER)

    # ---- the services ----

    async def _share(
        self, request: SetParameters.Request, response: SetParameters.Response
    ) -> SetParameters.Response:
        """Share each parameter: its name is the topic; a text that is JSON is shared as that."""
        for parameter in request.parameters:
            data = from_ros(parameter.value)
            answer = await self._say("share", topic=parameter.name, data=data)
            result = SetParametersResult(successful=answer["ok"], reason=answer.get("why", ""))
            response.results.append(result)
        return response

    async def _get(
        self, request: GetParameters.Request, response: GetParameters.Response
    ) -> GetParameters.Response:
        """Return what is shared, by names such as cf1, cf1.road, cf1.road.age_s; else not set."""
        for name in request.names:
            robot, _, rest = name.partition(".")
            topic, _, about = rest.partition(".")
            answer = await self._say("get", robot=robot, topic=topic)
            if not answer["ok"]:
                self.get_logger().warning(f"{name}: {answer['why']}")
            known = answer.get("found", False) and about in ("", *ABOUT)
            value = to_ros(answer[about or "data"]) if known else ParameterValue()
            response.values.append(value)
        return response

    async def _help(
        self, _request: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        """Call for help, with the words of the parameter ``help``; the message is the call's id."""
        what = self.get_parameter("help").get_parameter_value().string_value
        answer = await self._say("help", what=what)
        response.success = answer["ok"]
        response.message = answer["id"] if answer["ok"] else answer["why"]
        return response


def from_ros(value: ParameterValue) -> object:
    """Return what a parameter says, for JSON."""
    held = parameter_value_to_python(value)
    if value.type != ParameterType.PARAMETER_STRING:
        return list(held) if hasattr(held, "__len__") else held
    try:
        found = json.loads(held)
    except ValueError:
        return held
    return found if isinstance(found, dict | list) else held


def to_ros(data: object) -> ParameterValue:
    """Return the parameter that says the same; what no parameter can hold is JSON in a text."""
    plain = isinstance(data, bool | int | float | str) or (
        isinstance(data, list) and data and len({type(one) for one in data}) == 1
    )
    try:
        if plain:
            return Parameter("shared", value=data).get_parameter_value()
    except (TypeError, ValueError, AssertionError):
        pass
    return Parameter("shared", value=json.dumps(data)).get_parameter_value()


def main() -> None:
    """Run until it is ended."""
    rclpy.init()
    try:
        rclpy.spin(AmongNode())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
