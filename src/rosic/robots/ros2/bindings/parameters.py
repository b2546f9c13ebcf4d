"""Skills that set ROS parameters: the node answers, and then they are read back."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said
from rosic.core.order import OrderEnding, Outcome
from rosic.robots.ros2.bindings.answers import note
from rosic.robots.ros2.bindings.binding_call import filled
from rosic.robots.ros2.bindings.parameter_values import (
    SET_PARAMETERS,
    refusals,
    request,
    service_of,
)
from rosic.robots.ros2.bindings.service import ask
from rosic.robots.ros2.messages.names import check_graph_name

if TYPE_CHECKING:
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.bindings.parameter_values import Parameters
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.services import ServiceLink
    from rosic.robots.ros2.profile import ParametersBinding

GET_PARAMETERS = "rcl_interfaces/srv/GetParameters"
# rcl_interfaces/msg/ParameterType to the field of ParameterValue that holds it
_FIELDS = {1: "bool_value", 2: "integer_value", 3: "double_value", 4: "string_value"}


class ParameterSkill:
    """Sets parameters of one node."""

    def __init__(self, binding: ParametersBinding) -> None:
        self._binding = binding
        self._set: ServiceLink | None = None
        self._get: ServiceLink | None = None

    def types(self) -> set[str]:
        """Return the types of the two services."""
        return {SET_PARAMETERS, GET_PARAMETERS}

    async def open(self, runtime: RosRuntime) -> None:
        """Open both services of the node."""
        node = self._binding.node
        self._set = await runtime.service(service_of(node), SET_PARAMETERS)
        self._get = await runtime.service(
            f"{check_graph_name(node)}/get_parameters", GET_PARAMETERS
        )

    async def close(self) -> None:
        """Leave them."""
        links, self._set, self._get = (self._set, self._get), None, None
        for link in links:
            if link is not None:
                await link.close()

    async def carry(self, call: BindingCall) -> Outcome:
        """Set them, then read them back."""
        if self._set is None or self._get is None:
            raise call.offline()
        await call.there(self._set.ready, self._set.name)
        asked: Parameters = filled(self._binding.values, call.order)  # type: ignore[assignment]
        values = request(asked)
        answer = await ask(call, self._set, values, self._binding.timeout_s, leave=True)
        if answer is None:
            return Outcome(OrderEnding.CANCELLED)
        call.received()
        refused = refusals(asked, answer)
        if refused:
            return Outcome(OrderEnding.FAILED, note(" ".join(refused)))
        read = await ask(call, self._get, {"names": list(asked)}, self._binding.timeout_s)
        found = {} if read is None else dict(zip(asked, map(_value, read.values), strict=False))
        wrong = [name for name, value in asked.items() if found.get(name) != value]
        if wrong:
            return Outcome(
                OrderEnding.FAILED, said("{join} reads back differently", join=joined(", ", wrong))
            )
        facts = {n: float(v) for n, v in asked.items() if not isinstance(v, str)}
        return Outcome(OrderEnding.DONE, said("set and read back"), facts)


def _value(entry: RosObject) -> object:
    field = _FIELDS.get(entry.type)
    return None if field is None else getattr(entry, field)
