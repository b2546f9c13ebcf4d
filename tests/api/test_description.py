"""The API does what its description says, whatever it is sent (schemathesis)."""

from __future__ import annotations

import asyncio
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from jsonschema import Draft202012Validator
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from rosic.api.settings import ApiSettings, ServingLimits
from rosic.core.rate_limit import RateLimit
from tests.api.served import ANYWHERE, served
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Mapping

CHECKS = [
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_schema_conformance,
]
OFTEN = ApiSettings(listen=ANYWHERE, limits=ServingLimits(reads=RateLimit(burst=1e6, per_s=1e6)))
OF_PEOPLE = frozenset({"people", "health"})
A_FEW, MANY = 5, 300
SHORT_S, LONG_S = 40.0, 1_800.0


class Callers(NamedTuple):
    """What shows who asks: a program for all but what is for whoever looks after people."""

    program: Mapping[str, str]
    admin: Mapping[str, str]

    def shown(self, operation: Mapping[str, Any]) -> Mapping[str, str]:
        return self.program if OF_PEOPLE.isdisjoint(operation["tags"]) else self.admin


def ask(
    url: str, described: dict[str, Any], callers: Callers, examples: int, within_s: float
) -> list[str]:
    """Ask every operation with so many generated requests. Return those that were asked."""
    asked, until_s = [], monotonic() + within_s * pace()
    for found in schemathesis.openapi.from_dict(described).get_all_operations():
        operation: Any = found.ok()  # type: ignore[union-attr]
        if monotonic() > until_s:
            break
        ask_one(url, operation, callers.shown(operation.definition.raw), examples)
        asked.append(operation.label)
    return asked


def ask_one(url: str, operation: Any, shown: Mapping[str, str], examples: int) -> None:  # noqa: ANN401 - untyped there
    """Ask one operation as somebody, with so many generated requests."""

    @settings(
        max_examples=examples,
        phases=[Phase.explicit, Phase.generate],
        derandomize=True,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(case=operation.as_strategy())
    def one(case: Any) -> None:  # noqa: ANN401 - untyped there
        answer = case.call(base_url=url, headers=dict(shown), timeout=90 * pace())
        case.validate_response(answer, checks=CHECKS)

    one()


async def run(examples: int, within_s: float) -> None:
    async with served(OFTEN) as place:
        hal, ada = await place.program("senior"), await place.person("Ada")
        described = (await hal.get("/v1/openapi/openapi.json")).json()
        cookie = "; ".join(f"{name}={value}" for name, value in ada.cookies.items())
        callers = Callers(
            {"Authorization": hal.headers["authorization"]}, {"Cookie": cookie, "Origin": place.url}
        )
        asked = await asyncio.to_thread(ask, place.url, described, callers, examples, within_s)
        every = sum(len(path) for path in described["paths"].values())
        assert len(asked) == every


async def test_it_answers_whatever_it_is_sent_as_its_description_says() -> None:
    await run(A_FEW, SHORT_S)


async def test_what_is_said_and_answered_is_as_it_is_described() -> None:
    """Of requests that work: the generated ones of the other tests hardly ever do."""
    async with served(OFTEN) as place:
        hal = await place.program("operator")
        whole = (await hal.get("/v1/openapi/openapi.json")).json()

        def fits(name: str, value: object) -> bool:
            schema = {"$ref": f"#/components/schemas/{name}", "components": whole["components"]}
            return bool(Draft202012Validator(schema).is_valid(value))

        assert fits("StopIn", {"robots": ["omni"]})
        assert not fits("StopIn", {"robots": [42]})
        asked = {"skill": "move", "arguments": {"direction": "left", "distance": 1.0}}
        assert fits("OrderIn", asked)
        order = (await hal.post("/v1/robots/omni/orders", json=asked)).json()
        assert order["arguments"]["distance"] == 1.0
        assert fits("OrderOut", order)
        every = [one for path in whole["paths"].values() for one in path.values()]
        assert [one["operationId"] for one in every if "description" not in one] == []


@pytest.mark.campaign
async def test_it_answers_much_more_as_its_description_says() -> None:
    await run(MANY, LONG_S)


async def test_every_route_says_how_it_refuses() -> None:
    async with served() as place:
        described = (await place.http.get("/v1/openapi/openapi.json")).json()
        assert described["openapi"].startswith("3.1")
        for path, operations in described["paths"].items():
            for method, operation in operations.items():
                refused = {s for s in operation["responses"] if s.startswith(("4", "5"))}
                assert {"400", "401", "403", "404", "409", "413", "422", "429", "503"} <= refused
                for status in refused:
                    content = operation["responses"][status]["content"]
                    assert list(content) == ["application/problem+json"], (path, method)
