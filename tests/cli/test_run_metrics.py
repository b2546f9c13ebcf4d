"""`rosic run` with `[metrics]`: what monitoring is told, while what it needs is there and away."""

from __future__ import annotations

import asyncio
import socket
from typing import TYPE_CHECKING

import httpx
import pytest

from rosic.testing.telegram import FakeTelegram
from tests.cli.running import TELEGRAM, gateway, write_config
from tests.pace import pace

if TYPE_CHECKING:
    from pathlib import Path

OF_ADA = f"""{TELEGRAM}
[[principal]]
name = "Ada"
address = "telegram:{{ada}}"
role = "admin"

[metrics]
listen = "127.0.0.1:{{port}}"
"""


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port: int = taken.getsockname()[1]
        return port


async def answers(client: httpx.AsyncClient, path: str, status: int, text: str) -> None:
    """Wait until this is what is answered."""
    found = "nothing"
    async with asyncio.timeout(60 * pace()):
        while True:
            try:
                answer = await client.get(path)
                found = f"{answer.status_code} {answer.text}"
                if answer.status_code == status and text in answer.text:
                    return
            except httpx.TransportError as error:
                found = repr(error)
            await asyncio.sleep(0.05)
    raise AssertionError(found)


@pytest.mark.limit(300)
async def test_it_is_ready_while_it_can_write_down_and_hear_and_says_what_is_away(
    tmp_path: Path,
) -> None:
    server = FakeTelegram(limits=None)
    await server.start()
    await server.stop()  # from here on its port is known, and nobody is there
    ada, port = str(server.create_user("Ada")), str(free_port())
    config = write_config(tmp_path, OF_ADA, api_base=server.api_base, ada=ada, port=port)
    url = f"http://127.0.0.1:{port}"
    env = {"LAB_TOKEN": server.token}
    with gateway(config, env=env, ready=False) as running:
        async with httpx.AsyncClient(base_url=url, timeout=30 * pace()) as client:
            await answers(client, "/readyz", 503, "no messenger is connected")
            await asyncio.to_thread(running.wait_for, "ready in", log=True)
            await answers(client, "/livez", 200, "ok")
            await answers(client, "/metrics", 200, 'rosic_messenger_up{messenger="telegram"} 0')
            async with server:
                await answers(client, "/readyz", 200, "ok")
                await answers(client, "/metrics", 200, "rosic_ready 1")
                await answers(client, "/metrics", 200, 'rosic_messenger_up{messenger="telegram"} 1')
                await answers(client, "/metrics", 200, 'rosic_robot_up{robot="omni"} 1')

                mark = tmp_path / "rosic-data" / "record.mark"
                kept = mark.rename(tmp_path / "record.mark")
                await answers(client, "/readyz", 503, "record.mark of the record is not there")
                await answers(client, "/livez", 200, "ok")
                kept.rename(mark)
                await answers(client, "/readyz", 200, "ok")
            await answers(client, "/readyz", 503, "no messenger is connected")
            await answers(client, "/metrics", 200, "rosic_ready 0")
            assert await asyncio.to_thread(running.end) == 0
