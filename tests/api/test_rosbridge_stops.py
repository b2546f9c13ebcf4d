"""The stop service of a robot, called by a client of rosbridge: it stops, whatever it is told."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING

from tests.api.bridge_client import bridge
from tests.api.served import served

if TYPE_CHECKING:
    import pytest


class ReleasedGraph:
    """What stands for a graph whose stop service takes a release, too."""

    stop_service, stop_service_type = "/omni/stop", "std_srvs/srv/SetBool"
    releases_by = MappingProxyType({"data": False})
    reported = MappingProxyType[str, str]({})


async def test_whoever_would_let_a_robot_go_on_by_its_stop_service_is_told_that_it_only_stops(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with served() as place, bridge(place, await place.key("operator")) as client:
        graph = {"omni": ReleasedGraph()}
        monkeypatch.setattr(place.gateway.rooms.linker, "graph_topics", graph.get)
        for service, args, found in (
            ("services", {}, {"services": ["/omni/stop"]}),
            ("service_type", {"service": "omni/stop"}, {"type": "std_srvs/srv/SetBool"}),
            ("services_for_type", {"type": "std_srvs/SetBool"}, {"services": ["/omni/stop"]}),
        ):
            await client.say("call_service", service=f"/rosapi/{service}", args=args)
            values = (await client.op("service_response"))["values"]
            assert values == found or found["services"][0] in values["services"]
        told: list[str] = []
        for data, good in ((True, True), (False, False)):
            await client.say("call_service", service="/omni/stop", args={"data": data})
            answer = (await client.op("service_response"))["values"]
            assert answer["success"] is good
            assert place.gateway.rooms.stops["omni"].latched
            told.append(answer["message"])
        only = "is stopped: this service only stops. Whoever may lets it go on by: resume omni"
        assert told[-1].endswith(only)
