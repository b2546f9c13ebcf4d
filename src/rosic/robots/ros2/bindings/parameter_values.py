"""Setting the parameters of a node: an ordinary service, whose request takes some building."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias

from rosic.robots.ros2.errors import BadValue
from rosic.robots.ros2.messages.coerce import kind_of
from rosic.robots.ros2.messages.names import check_graph_name

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.messages.encode import Values

Parameters: TypeAlias = Mapping[str, bool | int | float | str]

# To be declared in the `TypeRegistry` of whoever sets parameters.
SET_PARAMETERS = "rcl_interfaces/srv/SetParameters"

# rcl_interfaces/msg/ParameterType, and the field of ParameterValue that it fills
_FIELDS: dict[type, tuple[int, str]] = {
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
    if type(value) not in _FIELDS:
        raise BadValue(f"The parameter {name} cannot be {kind_of(value)}.")
    number, field = _FIELDS[type(value)]
    return {"name": name, "value.type": number, f"value.{field}": value}
