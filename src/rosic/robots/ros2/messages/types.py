"""The types that profiles name, and no others."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from rosic.robots.ros2.client.rclpy_import import load_ros
from rosic.robots.ros2.errors import BadName
from rosic.robots.ros2.messages.names import did_you_mean, parse_type_name

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.messages.names import Kind, TypeName

MAX_TYPES = 1024


class TypeRegistry:
    """Turns names of types into classes.

    Closed: a name that was not declared when the profiles were read is refused, so no text that
    arrives later can have a module imported.
    """

    def __init__(self, names: Iterable[str]) -> None:
        """Declare the names.

        Raises:
            BadName: One of them is not the name of a type, or there are too many.
        """
        self._declared = {str(name): name for name in map(parse_type_name, names)}
        if len(self._declared) > MAX_TYPES:
            raise BadName(f"The profiles name more than {MAX_TYPES} ROS types.")
        self._loaded: dict[str, RosObject] = {}

    def message(self, name: str) -> RosObject:
        """Return a message class.

        Raises:
            BadName: Not declared, not a message, or not installed.
            RosMissing: There is no ROS 2 here.
        """
        return self._load(name, "msg")

    def service(self, name: str) -> RosObject:
        """Return a service class, with ``Request`` and ``Response``. Raises as `message` does."""
        return self._load(name, "srv")

    def action(self, name: str) -> RosObject:
        """Return an action class: ``Goal``, ``Result``, ``Feedback``. Raises as `message` does."""
        return self._load(name, "action")

    def _load(self, name: str, kind: Kind) -> RosObject:
        found = self._loaded.get(name)
        if found is not None and self._declared[name].kind == kind:
            return found
        wanted = parse_type_name(name, kind)
        if name not in self._declared:
            raise BadName(
                f"{name} is not named by any profile; {did_you_mean(name, self._declared)}"
            )
        load_ros()
        self._loaded[name] = _import(wanted)
        return self._loaded[name]


def _import(name: TypeName) -> RosObject:
    try:
        module = importlib.import_module(f"{name.package}.{name.kind}")
    except ImportError as error:
        raise BadName(
            f"The ROS package {name.package} is not installed here, and {name} belongs to it.",
            hint=f"Install {name.package} for your distribution, or source the workspace it is in.",
        ) from error
    found = getattr(module, name.name, None)
    if not isinstance(found, type):
        known = [entry for entry in vars(module) if entry[0].isupper() and "_" not in entry]
        raise BadName(
            f"{name.package} has no {name.kind} named {name.name}; {did_you_mean(name.name, known)}"
        )
    return found
