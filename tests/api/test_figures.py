"""How busy robots were, and what is measured of the gateway, for people to read."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from rosic.api.figure_routes import FigureOut, shown
from rosic.api.metrics.exposition import COUNTER, GAUGE, HISTOGRAM, Histogram, Metric, Sample, page
from rosic.app.admin.api import AdminVerb
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from tests.api.served import problem, served
from tests.gateway.place import ask_as_operator

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from tests.api.served import ServedGateway

in_one_loop = pytest.mark.asyncio(loop_scope="module")


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def place() -> AsyncIterator[ServedGateway]:
    rules = RoleRules(roles={**DEFAULT_ROLES, "lookout": Role(scopes=("omni:read",))})
    async with served(rules=rules) as place:
        yield place


@in_one_loop
async def test_how_busy_robots_were_counts_orders_and_shows_whom_one_may_see(
    place: ServedGateway,
) -> None:
    bo = await place.person("Bo")
    before = (await bo.get("/v1/utilisation")).json()
    assert {each["robot"] for each in before} == set(place.gateway.rooms.profiles)
    body = {"skill": "move", "arguments": {"distance": 0.1}, "wait_s": 20}
    done = await bo.post("/v1/robots/omni/orders", json=body)
    assert done.json()["state"] == "done", done.text
    found = {each["robot"]: each for each in (await bo.get("/v1/utilisation")).json()}
    for time in (found["omni"]["today"], found["omni"]["week"]):
        assert time["worked_s"] > 0
        assert 0 < time["share"] <= 1
    assert not found["omni"]["at_work"]
    assert found["yumi"]["week"] == {"worked_s": 0.0, "share": 0.0}
    one = await place.program("lookout")
    assert [each["robot"] for each in (await one.get("/v1/utilisation")).json()] == ["omni"]


@in_one_loop
async def test_what_is_measured_is_for_whoever_looks_after_people(place: ServedGateway) -> None:
    ada, bo = await place.person("Ada"), await place.person("Bo")
    await bo.post("/v1/robots/omni/orders", json={"skill": "move", "arguments": {"distance": 9e9}})
    body = {"skill": "move", "arguments": {"distance": 0.1}, "wait_s": 20}
    await bo.post("/v1/robots/omni/orders", json=body)
    found = {each["name"]: each for each in (await ada.get("/v1/metrics")).json()}
    ended = found["rosic_orders_total"]
    assert ended["kind"] == "counter"
    assert {"robot": "omni", "outcome": "done"} in [each["labels"] for each in ended["figures"]]
    hops = {each["labels"]["hop"]: each for each in found["rosic_order_hop_seconds"]["figures"]}
    assert hops["accepted-ended"]["count"] >= 1
    assert hops["accepted-ended"]["value"] > 0
    assert [each["value"] for each in found["rosic_robot_up"]["figures"]] == [1] * 6
    assert problem(await bo.get("/v1/metrics"))[:2] == (403, "not-permitted")

    assert [each["value"] for each in found["rosic_ready"]["figures"]] == [1]
    lost = ["record.mark of the record is not there as it was"]
    place.gateway.kernel.shared.not_ready.provide(lambda: lost)
    found = {each["name"]: each for each in (await ada.get("/v1/metrics")).json()}
    assert [each["value"] for each in found["rosic_ready"]["figures"]] == [0]
    lost.clear()


def test_one_metric_is_told_to_a_monitoring_and_to_people() -> None:
    times, none = Histogram((0.1, 1.0)), Histogram((1.0,))
    for seconds in (0.05, 0.15):
        times.observe(seconds)
    odd = 'say "hi" \\ there\nnow'
    metrics = (
        Metric("a", GAUGE, "About a.", (Sample({"robot": odd, "way": "x"}, 2.5),)),
        Metric("b", HISTOGRAM, "Times.", (Sample({"hop": "h"}, times), Sample({"hop": "i"}, none))),
        Metric("c", HISTOGRAM, "None.", (Sample({}, none),)),
        Metric("d", COUNTER, "Bare.", (Sample({}, 7),)),
        Metric("e", COUNTER, "Nothing.", ()),
    )
    gauge, histogram, bare = shown(metrics)
    assert (gauge.name, gauge.kind, gauge.about) == ("a", "gauge", "About a.")
    assert gauge.figures == (FigureOut({"robot": odd, "way": "x"}, 2.5, None),)
    [mean] = histogram.figures
    assert (mean.labels, mean.count) == ({"hop": "h"}, 2)
    assert mean.value == pytest.approx(0.1)
    assert bare.figures == (FigureOut({}, 7, None),)
    told = page(metrics).decode().splitlines()
    assert r'a{robot="say \"hi\" \\ there\nnow",way="x"} 2.5' in told
    assert [line for line in told if line.startswith("# TYPE")] == [
        "# TYPE a gauge",
        "# TYPE b histogram",
        "# TYPE c histogram",
        "# TYPE d counter",
    ]
    assert {'b_sum{hop="h"} 0.2', 'b_count{hop="h"} 2', "c_count 0", "d 7"} <= set(told)


async def test_an_admin_who_is_locked_out_is_shown_nothing_that_is_for_admins() -> None:
    async with served() as place:
        ada = await place.person("Ada")
        assert (await ada.get("/v1/metrics")).status_code == 200
        await ask_as_operator(place.gateway, AdminVerb.LOCK, "Ada")
        for path in ("/v1/metrics", "/v1/people", "/v1/health"):
            assert (await ada.get(path)).status_code in {401, 403}, path
