"""Answers to what clients ask ``/rosapi``: which topics and services they may use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from rosic.api.rosbridge.orders import ACTION, SERVICE
from rosic.api.rosbridge.topics import absolute, plain_type
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.api.rosbridge.orders import OrderBindings
    from rosic.api.rosbridge.topics import TopicDirectory

PREFIX: Final = "/rosapi/"


class GraphIntrospection:
    """Answers the services of ``rosapi`` that tell what there is; it changes nothing."""

    def __init__(
        self, context: ApiContext, directory: TopicDirectory, bindings: OrderBindings
    ) -> None:
        self._context, self._directory, self._bindings = context, directory, bindings
        self._answers: Mapping[str, Callable[[ApiCaller, Mapping[str, Any]], dict[str, Any]]] = {
            "topics": self._topics,
            "topic_type": self._topic_type,
            "topics_for_type": self._topics_for_type,
            "services": self._services,
            "service_type": self._service_type,
            "services_for_type": self._services_for_type,
            "action_servers": self._action_servers,
            "get_time": self._time,
            "get_ros_version": self._version,
        }

    def answer(
        self, caller: ApiCaller, service: str, request: Mapping[str, Any]
    ) -> dict[str, Any] | None:
        """Return the answer to a call; None: it is no such service."""
        found = self._answers.get(absolute(service).removeprefix(PREFIX))
        return None if found is None else found(caller, request)

    def _topics(self, caller: ApiCaller, _request: Mapping[str, Any]) -> dict[str, Any]:
        found = list(self._directory.all(caller))
        return {"topics": [one.topic for one in found], "types": [one.type for one in found]}

    def _topic_type(self, caller: ApiCaller, request: Mapping[str, Any]) -> dict[str, Any]:
        name = absolute(str(request.get("topic", "")))
        found = (one.type for one in self._directory.all(caller) if one.topic == name)
        return {"type": next(found, "")}

    def _topics_for_type(self, caller: ApiCaller, request: Mapping[str, Any]) -> dict[str, Any]:
        kind = plain_type(str(request.get("type", "")))
        found = self._directory.all(caller)
        return {"topics": [one.topic for one in found if plain_type(one.type) == kind]}

    def _services(self, caller: ApiCaller, _request: Mapping[str, Any]) -> dict[str, Any]:
        return {"services": sorted(self._types(caller, SERVICE))}

    def _service_type(self, caller: ApiCaller, request: Mapping[str, Any]) -> dict[str, Any]:
        name = absolute(str(request.get("service", "")))
        return {"type": self._types(caller).get(name, "")}

    def _services_for_type(self, caller: ApiCaller, request: Mapping[str, Any]) -> dict[str, Any]:
        kind = plain_type(str(request.get("type", "")))
        found = self._types(caller).items()
        return {"services": sorted(name for name, each in found if plain_type(each) == kind)}

    def _action_servers(self, caller: ApiCaller, _request: Mapping[str, Any]) -> dict[str, Any]:
        return {"action_servers": sorted(self._types(caller, ACTION))}

    def _types(self, caller: ApiCaller, kind: str = "") -> dict[str, str]:
        """Return what somebody may call, and of which type it is; of one kind alone, or of all."""
        stops = {} if kind == ACTION else self._bindings.stop_services(caller)
        skills = (one for one in self._bindings.all(caller) if kind in {"", one.kind})
        return stops | {one.name: one.type for one in skills}

    def _time(self, _caller: ApiCaller, _request: Mapping[str, Any]) -> dict[str, Any]:
        sec, rest = divmod(self._context.kernel.machine_clock.wall_ns(), SECOND_NS)
        return {"time": {"sec": sec, "nanosec": rest, "secs": sec, "nsecs": rest}}

    def _version(self, _caller: ApiCaller, _request: Mapping[str, Any]) -> dict[str, Any]:
        return {"version": 2, "distro": ""}
