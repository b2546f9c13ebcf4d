"""A stop is given, however it is asked for: by REST, over the events, by `rosic stop`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from tests.api.served import served
from tests.api.test_events import told

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    import httpx

    from tests.api.served import ServedGateway

pytestmark = pytest.mark.asyncio(loop_scope="module")


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def place() -> AsyncIterator[ServedGateway]:
    async with served() as place:
        yield place


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def hal(place: ServedGateway) -> httpx.AsyncClient:
    return await place.program("operator")


def generations(place: ServedGateway) -> dict[str, int]:
    return {robot: stop.generation for robot, stop in place.gateway.rooms.stops.items()}


def stopped(place: ServedGateway, before: dict[str, int]) -> set[str]:
    return {robot for robot, number in generations(place).items() if number > before[robot]}


@pytest.mark.parametrize(
    ("body", "alone"),
    [
        (b"", False),
        (b"{", False),
        (b"stop", False),
        (b"\xff", False),
        (b"null", False),
        (b"[" * 10_000, False),
        (b'{"robots": "omni"}', False),
        (b'{"robot": "omni"}', False),
        (b'{"robots": ["omni", 7]}', False),
        (b'{"robots": [""]}', False),
        (b'{"robots": ["%s"]}' % (b"x" * 70), False),
        (b'{"robots": ["omni"], "wait_s": 120}', True),
        (b'{"robots": ["omni"], "wait_s": -1}', True),
        (b'{"robots": ["omni"], "wait_s": 1e400}', False),
        (b'{"robots": ["omni"], "wait_s": "long"}', True),
        (b'{"robots": ["omni"], "id": "1"}', True),
        (b" " * 300_000, False),
    ],
    ids=lambda each: repr(each)[:40],
)
async def test_a_stop_is_given_whatever_its_body_is(
    place: ServedGateway, hal: httpx.AsyncClient, body: bytes, alone: bool
) -> None:
    before = generations(place)
    answer = await hal.post("/v1/stop", content=body)
    assert answer.status_code == 200, answer.text
    await place.until(lambda: stopped(place, before) == ({"omni"} if alone else set(before)))


@pytest.mark.parametrize(
    "message",
    [
        '{"op": "stop", "robots": ["omni"], "id": "7"}',
        '{"op": "stop", "robots": ["nobody"], "id": "7"}',
        '{"op": "stop", "more": 1, "id": "7"}',
        '{"op": "stop", "robots": 7}',
        '{"op": "stop", "robots": [',
        b'{"op": "stop", "robots": ["omni"]}',
        b"\xff stop",
        "stop",
        "STOP!",
        "{'op': 'stop'}",
        "{op: stop}",
        '{"op": "STOP"}',
        '{"op": "stop", "more": ' + "[" * 10_000,
    ],
    ids=lambda message: repr(message)[:40],
)
async def test_a_stop_is_given_however_badly_it_is_written(
    place: ServedGateway, hal: httpx.AsyncClient, message: str | bytes
) -> None:
    stop = place.gateway.rooms.stops["omni"]
    before = stop.generation
    async with place.listening(hal) as connection:
        await connection.send(message)
        stopped = await told(connection, "stop")
        assert stopped["stop"]["at_rest"] is True
        assert stop.latched
        assert stop.generation > before
