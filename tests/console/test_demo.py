"""The page of the demonstration, as whoever tries ROSIC first sees it."""

from __future__ import annotations

import asyncio
import re
import socket
from contextlib import suppress
from typing import TYPE_CHECKING

import pytest
from playwright.async_api import expect

from rosic.api.settings import LISTEN, parse_listen
from tests.cli.running import ROSIC, environment
from tests.pace import patience

if TYPE_CHECKING:
    from playwright.async_api import Browser

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.limit(300)]
LINK = re.compile(rb"http://\S+#code=\S+")


async def test_its_link_leads_to_robots_also_where_the_usual_port_is_taken(
    browser: Browser,
) -> None:
    with socket.socket() as other:
        with suppress(OSError):  # then somebody else has it: it is taken
            other.bind((parse_listen(LISTEN).host, parse_listen(LISTEN).port))
            other.listen()
        demo = await asyncio.create_subprocess_exec(
            *ROSIC,
            "demo",
            "--console",
            "--plain",
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            env=environment(),
        )
        page = await browser.new_page(locale="en-GB")
        try:
            assert demo.stdout is not None
            async with asyncio.timeout(60 * patience()):
                while (link := LINK.search(await demo.stdout.readline())) is None:
                    assert not demo.stdout.at_eof()
            await page.goto(link[0].decode())
            await expect(page.get_by_text("Gateway connected")).to_be_visible()
            await expect(page.locator(".robot")).to_have_count(6)
            await expect(page.locator(".me")).to_contain_text("Guest")
            explained = await page.evaluate(
                """fetch("/v1/rights/check", {method: "POST", headers: {"Content-Type":
                "application/json"}, body: JSON.stringify({person: "Guest", line: "kuka1 home"})})
                .then((answer) => answer.status)"""
            )
            assert explained == 200
        finally:
            await page.close()
            demo.kill()
            await demo.wait()
