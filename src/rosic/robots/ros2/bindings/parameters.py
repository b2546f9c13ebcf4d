"""Skills that set ROS parameters: the node answers, and then they are read back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias

from rosic.core.i18n import joined, said
from rosic.core.order import OrderEnding, Outcome
from rosic.robots.ros2.bindings.answers import note
from rosic.robots.ros2.bindings.binding_call import filled
from rosic.robots.ros2.bindings.service import ask
from rosic.robots.ros2.errors import BadValue
from rosic.robots.ros2.messages.coerce import kind_of
from rosic.robots.ros2.messages.names import check_graph_name

if TYPE_CHECKING:
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.services import ServiceLink
    from rosic.robots.ros2.messages.encode import Values
    from rosic.robots.ros2.profile import ParametersBinding


# ---- parameter values ----

# Setting the parameters of a node: an ordinary service, whose request takes some building.

Parameters: TypeAlias = Mapping[str, bool | int | float | str]

# To be declared in the `TypeRegistry` of whoever sets parameters.
SET_PARAMETERS = "rcl_interfaces/srv/SetParameters"

# rcl_interfaces/msg/ParameterType, and the field of ParameterValue that it fills
_VALUE_FIELDS: dict[type, tuple[int, str]] = {
    bool: (1, "bool_value"),
    int: (2, "integer_value"),
    float: (3, "double_value"),
    str: (4, "string_value"),
}


def service_of(node: str) -> str:
    """Return the name of the service that sets a node's parameters.

    Raises:
        BadName: That is no node.
    """
    return f"{check_graph_name(node)}/set_parameters"


def request(parameters: Parameters) -> Values:
    """Return the request that sets them. ROS tells 1 from 1.0: a node refuses the wrong one.

    Raises:
        BadValue: A value is of a type that no parameter has.
    """
    return {"parameters": [_entry(name, value) for name, value in parameters.items()]}


def refusals(asked: Parameters, response: RosObject) -> tuple[str, ...]:
    """Return a sentence for every parameter that was not set, in the node's own words."""
    answers = list(response.results)
    silent = list(asked)[len(answers) :]
    return (
        *(
            f"{name} was not set: {answer.reason or 'no reason given'}"
            for name, answer in zip(asked, answers, strict=False)
            if not answer.successful
        ),
        *(f"{name} was not set: no answer" for name in silent),
    )


def _entry(name: str, value: object) -> Values:
    if type(value) not in _VALUE_FIELDS:
        raise BadValue(f"The parameter {name} cannot be {kind_of(value)}.")
    number, field = _VALUE_FIELDS[type(value)]
    return {"name": name, "value.type": number, f"value.{field}": value}


# ---- parameters ----

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
        await call.there(self._set.sought, self._set.name)
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
