"""A real gateway that is killed while the API is asked for something, and begun again."""

from __future__ import annotations

import asyncio
import re
import signal
import socket
import time
from datetime import UTC, datetime, timedelta
from http import HTTPStatus
from typing import TYPE_CHECKING, Any

import httpx
import pytest

from tests.cli.programs import key_of
from tests.cli.running import CONFIG, gateway, write_config
from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

    from tests.cli.running import Gateway

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


PATH = "/v1/robots/omni/orders"
ORDER = {"skill": "move", "arguments": {"distance": 0.1, "direction": "left"}}
CARE = '[[care]]\nscopes = ["omni:*"]\nconfirm = true\n'
ANSWER = re.compile(r"Your code for the page: (\S+)|Again in 1 s\.")


def browser_at(url: str) -> httpx.AsyncClient:
    return httpx.AsyncClient(base_url=url, headers={"Origin": url}, timeout=60 * pace())


async def sign_in(browser: httpx.AsyncClient, running: Gateway) -> None:
    """Sign in as Ada, who sits at the terminal: after a kill, not before her limit fills again."""
    end_s = time.monotonic() + 60 * pace()
    asked, answers = 0, [""]
    while not answers[-1]:
        await asyncio.sleep(1.0 if asked else 0.0)  # as she is told
        running.say("/signin")
        asked += 1
        while len(answers := ANSWER.findall(running.out())) < asked:
            assert time.monotonic() < end_s, running.out()
            await asyncio.sleep(0.02)
    made = await browser.post("/v1/sessions", json={"code": answers[-1]})
    assert made.status_code == 201, made.text


async def placed_by(browser: httpx.AsyncClient, *keys: str) -> dict[str, Any]:
    """Place the order under a key, as soon as her limit has room for it.

    A key that met the limit is answered the same again: each try takes the next one.
    """
    found: dict[str, Any] = {}
    for key in keys:
        answer = await browser.post(PATH, json=ORDER, headers={"Idempotency-Key": key})
        found = answer.json()
        if answer.status_code != HTTPStatus.TOO_MANY_REQUESTS:
            break
        await asyncio.sleep(1.0)  # the limit of the chat says when in its sentence alone
    return found


async def confirmed(browser: httpx.AsyncClient) -> None:
    """Tap that it is meant, under what was asked last."""
    shown = (await browser.get("/v1/chat")).json()[-1]
    tapped = {"message": shown["id"], "button": shown["buttons"][0][0]["nonce"]}
    await browser.post("/v1/chat", json=tapped | {"wait_s": 0})


@pytest.mark.limit(300)
async def test_a_key_of_a_person_on_the_page_is_one_order_over_a_kill(tmp_path: Path) -> None:
    config, url = place(tmp_path, CARE)
    with gateway(config) as running:
        async with browser_at(url) as ada:
            await sign_in(ada, running)
            placed = await placed_by(ada, "g1")
            assert placed["state"] == "asked"
            await confirmed(ada)
            done = (await ada.get(f"/v1/orders/{placed['id']}?wait_s=30")).json()
            assert (done["id"], done["state"], done["n"]) == (placed["id"], "done", 1)
        running.end(signal.SIGKILL)
    with gateway(config) as running:
        async with browser_at(url) as ada:
            await sign_in(ada, running)
            again = await placed_by(ada, "g1")
            # If its end is not on disk, it is in doubt, and not done again either.
            assert (again["id"], again["over"], again["n"]) == (placed["id"], True, 1)
            assert (await ada.get("/v1/orders")).json() == []
            other = await placed_by(ada, *(f"other-{n}" for n in range(60)))
            if again["state"] == "done":
                assert other.get("state") == "asked", other
            else:  # in doubt: the robot stays stopped
                assert other["type"] == "/problems/robot-stopped", other
