"""`rosic doctor` looks at webhooks: whether they are there, who could read along, the secret."""

from __future__ import annotations

import asyncio
import base64
import ssl
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest

from rosic.api.webhooks.settings import WebhookSettings
from rosic.app.setup.diagnostics_checks import FindingVerdict
from rosic.app.setup.webhook_checks import examine_webhooks
from rosic.core.secret import Secret
from tests.api.test_client import certificate
from tests.cli.running import CONFIG, rosic, write_config
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from rosic.app.setup.diagnostics_checks import DiagnosticFinding

RANDOM = Secret(f"whsec_{base64.b64encode(bytes(range(60, 92))).decode()}")
GUESSED = Secret(f"whsec_{base64.b64encode(b'hunter2!' * 4).decode()}")
GOOD, LOOK = FindingVerdict.GOOD, FindingVerdict.LOOK


@asynccontextmanager
async def listening(
    context: ssl.SSLContext | None = None,
) -> AsyncIterator[tuple[int, list[bytes]]]:
    """Yield the port of something that listens, and what was said to it."""
    heard: list[bytes] = []

    async def hear(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            heard.append(await reader.read())
        except OSError:
            heard.append(b"")
        finally:
            writer.transport.abort()

    server = await asyncio.start_server(hear, "127.0.0.1", 0, ssl=context)
    async with server:
        yield server.sockets[0].getsockname()[1], heard


async def looked_at(
    url: str, *, private: bool = True, secret: Secret = RANDOM
) -> DiagnosticFinding:
    settings = WebhookSettings(url=url, secret=secret, private=private)
    [found] = [one async for one in examine_webhooks([settings], 30 * pace())]
    assert found.about == "webhook"
    return found


async def test_one_that_is_there_is_good_and_is_posted_nothing() -> None:
    async with listening() as (port, heard):
        found = await looked_at(f"http://127.0.0.1:{port}/hook/of-ours")
        async with asyncio.timeout(30 * pace()):
            while not heard:  # noqa: ASYNC110 - nobody is told
                await asyncio.sleep(0.01)
    assert found.verdict is GOOD, found
    assert found.text == (
        f"127.0.0.1:{port} answers, without TLS, in a private network, as is said; what is posted "
        "is signed with its secret"
    )
    assert heard == [b""]


async def test_what_is_private_and_not_said_to_be_is_not_asked() -> None:
    async with listening() as (port, heard):
        found = await looked_at(f"http://127.0.0.1:{port}/hook", private=False)
    assert found.verdict is LOOK
    assert found.text == (
        f"127.0.0.1:{port} is in a private network, so nothing is posted there: say private = true "
        "if that is meant"
    )
    assert heard == []


async def test_a_secret_that_somebody_made_up_is_pointed_out_and_not_shown() -> None:
    async with listening() as (port, _):
        found = await looked_at(f"http://127.0.0.1:{port}/hook", secret=GUESSED)
    assert found.verdict is LOOK
    assert "its secret is easily guessed" in found.text
    assert "hunter2" not in found.text
    assert GUESSED.reveal() not in found.text


async def test_a_certificate_that_nobody_trusts_is_pointed_out(tmp_path: Path) -> None:
    crt, key = certificate(tmp_path)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(crt, key)
    async with listening(context) as (port, _):
        found = await looked_at(f"https://127.0.0.1:{port}/hook")
    assert found.verdict is LOOK
    assert found.text.startswith(f"the certificate of 127.0.0.1:{port} is not trusted here: self")
    async with listening() as (port, _):
        other = await looked_at(f"https://localhost:{port}/hook?token=of-ours")
    assert "of-ours" not in other.text


@pytest.mark.parametrize(
    ("url", "why"),
    [
        ("http://127.0.0.1:9/hook", "127.0.0.1:9 cannot be reached (Conn"),
        ("http://nowhere.invalid/hook", "nowhere.invalid cannot be reached ("),
        (f"http://{'x' * 70}.example/hook", "is no name that can be looked up"),
    ],
)
async def test_what_is_not_there_is_said(url: str, why: str) -> None:
    found = await looked_at(url)
    assert found.verdict is LOOK
    assert why in found.text, found


async def test_one_that_keeps_silent_costs_the_doctor_no_longer_than_it_says() -> None:
    async def keep_silent(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            await reader.read()
        finally:
            writer.transport.abort()

    server = await asyncio.start_server(keep_silent, "127.0.0.1", 0)
    async with server:
        url = f"https://127.0.0.1:{server.sockets[0].getsockname()[1]}/hook"
        settings = WebhookSettings(url=url, secret=RANDOM, private=True)
        [found] = [one async for one in examine_webhooks([settings], 0.2)]
    assert "does not answer within 0.2 s" in found.text


def test_the_doctor_looks_at_those_of_its_configuration(tmp_path: Path) -> None:
    table = f'\n[[webhook]]\nurl = "http://localhost:9/hook"\nsecret = "{RANDOM.reveal()}"\n'
    ran = rosic("doctor", "-c", write_config(tmp_path, CONFIG + table))
    assert ran.status == 1
    assert "webhook    look at this: localhost:9 is in a private network" in ran.out
    assert RANDOM.reveal() not in ran.out + ran.err
