"""A real gateway that is killed while the API is asked for something, and begun again."""

from __future__ import annotations

import asyncio
import signal
import socket
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING

import httpx
import pytest

from tests.cli.programs import key_of
from tests.cli.running import CONFIG, gateway, write_config
from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

KILLS = 6


def free_port() -> int:
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        port = listening.getsockname()[1]
        assert isinstance(port, int)
        return port


def place(folder: Path, more: str = "") -> tuple[Path, str]:
    """Return the configuration of a gateway with an API, and where that listens."""
    port = free_port()
    path = write_config(folder, f'{CONFIG}\n[api]\nlisten = "127.0.0.1:{port}"\n{more}')
    return path, f"http://127.0.0.1:{port}"


def program(url: str, secret: str) -> httpx.AsyncClient:
    headers = {"Authorization": f"Bearer {secret}"}
    return httpx.AsyncClient(base_url=url, headers=headers, timeout=60 * pace())


def at(hours: int) -> str:
    whole = datetime.now(UTC).replace(minute=0, second=0, microsecond=0)
    return (whole + timedelta(hours=hours)).isoformat()


def written(folder: Path) -> list[tuple[int, int]]:
    """Return what changes with each write of the record."""
    found = (each.stat() for each in folder.rglob("*.db-wal"))
    return [(each.st_mtime_ns, each.st_size) for each in found]


async def asked_until_written(asking: asyncio.Task[httpx.Response], folder: Path) -> None:
    """Wait until something was written because of it, or it is answered."""
    before = written(folder)
    assert before
    while written(folder) == before and not asking.done():  # noqa: ASYNC110 - a file tells nobody
        await asyncio.sleep(0)


@pytest.mark.limit(300)
async def test_a_booking_that_is_moved_while_the_gateway_is_killed_is_there_once(
    tmp_path: Path,
) -> None:
    config, url = place(tmp_path)
    times = [at(24), at(48)]
    with gateway(config):
        secret = key_of("Hal", config)
        async with program(url, secret) as hal:
            body = {"robot": "omni", "start": times[0], "minutes": 60}
            booked = (await hal.post("/v1/bookings", json=body)).json()
    for number in range(KILLS):
        there = times[(number + 1) % 2]
        with gateway(config) as running:
            async with program(url, secret) as hal:
                body = {"start": there, "minutes": 60}
                asking = asyncio.create_task(hal.patch(f"/v1/bookings/{booked['id']}", json=body))
                await asked_until_written(asking, tmp_path)
                running.end(signal.SIGKILL)
                await asyncio.gather(asking, return_exceptions=True)
        with gateway(config):
            async with program(url, secret) as hal:
                span = {"from": at(0), "to": at(72)}
                [found] = (await hal.get("/v1/bookings", params=span)).json()
                assert found["id"] == booked["id"]
                assert found["start"][:16] in {each[:16] for each in times}
