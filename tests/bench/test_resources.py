"""What a soak judges: a leak that is planted is found, what is level is not, orders count."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from random import Random
from typing import TYPE_CHECKING

import pytest

from rosic.bench import resources
from rosic.bench.report import as_text
from rosic.bench.resources import ResourceProbe, ResourceRun, ResourceSample, report_of
from rosic.bench.soak import PlacedOrders, Soak, SoakPerson, SoakPlace, is_told
from rosic.bench.trend import FALLS, GROWS, LEVEL, trend_of
from rosic.testing.telegram import Control
from rosic.testing.telegram.server import DEFAULT_TOKEN, FakeTelegram
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from rosic.testing.telegram.state import JsonObject

SOAK_S = 7_200.0
LEAKS = """
import asyncio, os, sys
held = []
async def leak():
    while True:
        held.append(os.open(os.devnull, os.O_RDONLY))
        print(len(held), flush=True)
        await asyncio.sleep(0.005)
asyncio.run(leak())
"""


# ---- slopes ----


def series(make: Callable[[int, Random], float], seed: int = 1) -> tuple[list[float], list[float]]:
    chance = Random(seed)  # noqa: S311 - a seed makes it repeatable
    return [float(s) for s in range(6_600)], [make(s, chance) for s in range(6_600)]


def test_what_is_level_is_not_said_to_grow_and_a_leak_is_found() -> None:
    for seed in range(20):
        level = trend_of(*series(lambda _s, chance: 100 + chance.gauss(0, 1), seed))
        leak = trend_of(*series(lambda s, chance: 100 + chance.gauss(0, 1) + s / 3600, seed))
        assert level.verdict == LEVEL
        assert leak.verdict == GROWS
        assert leak.low < 1.0 < leak.high
        assert leak.per_hour == pytest.approx(1.0, abs=0.2)


def test_one_descriptor_in_half_an_hour_grows_and_what_comes_and_goes_does_not() -> None:
    assert trend_of(*series(lambda s, _chance: 26 + s // 1_800)).verdict == GROWS
    assert trend_of(*series(lambda s, _chance: 26 + (s % 30 < 3))).verdict == LEVEL
    assert trend_of(*series(lambda s, _chance: 26 - s // 1_800)).verdict == FALLS
    assert trend_of(*series(lambda _s, _chance: 26)).verdict == LEVEL


def test_what_neighbours_have_in_common_is_no_growth() -> None:
    stepped = [
        trend_of(*series(lambda s, chance: 100 + chance.gauss(0, 0.2) + 2 * (s > 3_300), seed))
        for seed in range(20)
    ]
    assert sum(one.verdict == LEVEL for one in stepped) >= 15


@pytest.mark.parametrize(
    "leaked",
    [
        lambda s: 10.0 * (s > 3_300),
        lambda s: max(0, s - 4_400) / 220,
        lambda s: max(0, s - 3_300) / 330,
    ],
    ids=["at once", "from two thirds on", "from half time on"],
)
def test_what_begins_late_or_comes_at_once_grows(leaked: Callable[[int], float]) -> None:
    """Of a hundred and more, a tenth: a slope over all of it is within its bounds."""
    for seed in range(10):
        trend = trend_of(*series(lambda s, chance: 100 + chance.gauss(0, 1) + leaked(s), seed))
        assert trend.verdict == GROWS


def test_too_few_samples_are_no_trend() -> None:
    with pytest.raises(ValueError, match="5 samples are too few"):
        trend_of([1.0] * 5, [1.0] * 5)


# ---- what a process uses ----


def test_descriptors_that_a_process_leaks_are_seen_and_judged() -> None:
    with subprocess.Popen(  # noqa: S603 - our own interpreter
        (sys.executable, "-c", LEAKS), stdout=subprocess.PIPE
    ) as process:
        try:
            probe = ResourceProbe(process.pid)
            assert process.stdout is not None
            for _ in range(60):
                process.stdout.readline()
                probe.look()
        finally:
            process.kill()

    judged = [one._replace(at_s=60.0 * n, passed={}) for n, one in enumerate(probe.samples)]
    _, failures = resources.resource_table(judged, judged)

    assert [one for one in failures if one.startswith("file descriptors grows by ")]
    assert judged[-1].descriptors - judged[0].descriptors >= 50
    assert judged[-1].resident_mib > 1

    late = [one._replace(descriptors=30 + 20 * (n >= 40)) for n, one in enumerate(judged)]
    _, failures = resources.resource_table(late, late)
    assert "file descriptors rose: its last quarter lies above its first." in failures


# ---- what people are told ----


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("omni: move, 0.10 m forward\nsent 14:07:09 · received by the robot 14:07:09", False),
        ("omni: move\nsent 14:07:09\ndriving 50 %", False),
        ("omni: move\nsent 14:07:09\ndone 14:07:10: moved 0.10 m forward", True),
        ("omni: move\nsent 14:07:09\nstopped before it ended 14:07:10", True),
        ("omni: move\nsent 14:07:09\nnot known whether it was carried out (14:07:10).", True),
        ("omni is stopped. Say: resume omni", True),
        ("cf1: takeoff\nsent 14:07:09\nalready flying. Nothing was done.", True),
    ],
)
def test_an_end_is_told_or_not(text: str, told: bool) -> None:
    assert is_told(text) is told


class ServerPlace:
    """The stand-in, and a bot of the test that answers as it likes."""

    def __init__(self, server: FakeTelegram, control: Control) -> None:
        self.server, self.control = server, control

    async def bot(self, method: str, **parameters: object) -> JsonObject:
        import httpx  # noqa: PLC0415 - only here

        async with httpx.AsyncClient(timeout=30 * pace()) as client:
            answer = await client.post(
                f"{self.server.url}/bot{DEFAULT_TOKEN}/{method}", json=parameters
            )
        found: JsonObject = answer.json()["result"]
        return found

    async def reply(self, chat: int, to: int, text: str) -> int:
        sent = await self.bot(
            "sendMessage", chat_id=chat, text=text, reply_parameters={"message_id": to}
        )
        return int(sent["message_id"])


@pytest.fixture
async def place() -> AsyncIterator[ServerPlace]:
    async with FakeTelegram(limits=None) as server, Control(server.url) as control:
        yield ServerPlace(server, control)


async def test_an_order_that_nobody_ends_is_lost_and_others_are_told_once(
    place: ServerPlace,
) -> None:
    orders = PlacedOrders(place.control)
    bo = await place.control.create_user("Bo")
    for _ in range(4):
        await orders.place(bo, "omni move 0.1 m")
    first, second, third, _fourth = [one["message_id"] for one in await place.control.messages(bo)]
    await place.reply(bo, first, "omni: move\nsent 14:07:09\ndone 14:07:10")
    alive = await place.reply(bo, second, "omni: move\nsent 14:07:09")
    assert await orders.look() == 3

    text = "omni: move\nsent 14:07:09\ndone 14:07:11"
    await place.bot("editMessageText", chat_id=bo, message_id=alive, text=text)
    assert await orders.look() == 2

    summary = "While I could not listen, 1 command came in here. It was not carried out."
    told = await place.bot("sendMessage", chat_id=bo, text=summary)
    assert await orders.look() == 1
    assert await orders.look() == 1  # a summary counts once
    assert (orders.placed, len(orders.told_ns), orders.summed, orders.lost) == (4, 2, 1, 1)

    await place.bot(
        "editMessageText",
        chat_id=bo,
        message_id=told["message_id"],
        text="While I could not listen, 2 commands came in here. None of them was carried out.",
    )
    assert await orders.look() == 0
    assert orders.told_ns[0] > 0
    assert third


def sample(at_s: float, tasks: int = 90) -> ResourceSample:
    passed = {"telegram sent bytes": 100 * at_s}
    return ResourceSample(at_s, 0.1, 110.0, 97.0, 26, 7, tasks, passed)


async def test_a_report_fails_by_what_grows_and_by_what_is_lost(place: ServerPlace) -> None:
    soak = Soak(SoakPlace(place.control, 0, 0, 0, 0), [], faulty=True)
    bo = await place.control.create_user("Bo")
    await soak.orders.place(bo, "omni move 0.1 m")
    seconds = range(0, int(SOAK_S), 10)

    level = report_of([sample(s) for s in seconds], soak, SOAK_S)
    tasks = report_of([sample(s, tasks=90 + s // 900) for s in seconds], soak, SOAK_S)
    early = report_of([sample(s, tasks=90 + min(s, 600) // 60) for s in seconds], soak, SOAK_S)
    broken_off = report_of([sample(s) for s in seconds], soak, SOAK_S, over=False)

    lost = "1 of 1 orders were not told how they ended."
    assert level.failures == early.failures == (lost,)
    assert [one[:14] for one in tasks.failures] == ["tasks grows by", lost[:14]]
    assert broken_off.failures == ()
    assert "telegram" in as_text(level)
    assert [chart.name for chart in level.charts][-1] == "resources-bytes"
    assert level.charts[-1].series[0].y[0] == pytest.approx(100.0)


async def test_orders_are_given_when_they_are_due_and_waited_for(
    place: ServerPlace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rosic.bench.soak.SETTLES_S", 0.1)
    monkeypatch.setattr("rosic.bench.soak.LOOK_S", 0.02)
    people = [
        SoakPerson(await place.control.create_user(name), ("omni home", "omni move 1 m"), 0.1)
        for name in ("Bo", "Cy")
    ]
    soak = Soak(SoakPlace(place.control, 0, 0, 0, 0), people, faulty=False)

    await soak.run(0.45)

    assert soak.orders.placed in range(8, 11)
    assert soak.orders.lost == soak.orders.placed  # nobody answers
    said = [one["text"] for one in await place.control.messages(people[0].account)]
    assert said[:3] == ["omni home", "omni move 1 m", "omni home"]


# ---- the bench itself ----


@pytest.mark.campaign
def test_half_an_hour_of_faults_loses_nothing_and_nothing_grows() -> None:
    seen = ResourceRun(1_800.0, faulty=True)
    asyncio.run(seen.run())
    assert seen.report().failures == ()
