"""In a browser: what comes from outside is text, and a restarted gateway is come back to."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace
from playwright.async_api import expect

from rosic.api.settings import ApiSettings, HostPort
from rosic.app.demo import fleet
from rosic.stores.memory import MemoryStore
from tests.api.served import served
from tests.console.browser import DESK, chromium, opened

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile

pytestmark = pytest.mark.limit(300)
MARKS = (
    "<script>window.ran=1</script>",
    "<img src=x onerror=window.ran=1>",
    "<svg onload=window.ran=1>",
    '"><script>window.ran=1</script>',
    "'-window.ran=1-'",
    "javascript:window.ran=1",
    "${window.ran=1}",
    "{{constructor.constructor('window.ran=1')()}}",
    "<iframe srcdoc='<script>parent.ran=1</script>'>",
    "<a href=javascript:window.ran=1>x</a>",
    "</title><script>window.ran=1</script>",
    "<details open ontoggle=window.ran=1>",
    "<style>@import'//x'</style>",
    "\u202e<b onmouseover=window.ran=1>x",
)
TIMES = 36
"""So often each is written, with another end: five hundred in all."""


def hostile_fleet() -> tuple[Profile, ...]:
    return tuple(
        replace(profile, title=MARKS[number % len(MARKS)]) for number, profile in enumerate(fleet())
    )


async def test_five_hundred_payloads_are_shown_and_none_runs() -> None:
    async with (
        served(profiles=hostile_fleet()) as place,
        chromium() as browser,
        opened(browser, place, DESK) as there,
    ):
        page = there.page
        await there.sign_in()
        await expect(page.locator(".robot").first).to_contain_text(MARKS[0])
        await there.go("drive/omni")
        account = place.principal("Ada")
        messenger = place.server.context.page
        shown = messenger.conversation(account)
        await there.say("help")
        await expect(page.locator(".messages li.theirs").first).to_be_visible()
        before = shown.all()[-1]
        for number in range(TIMES):
            for kind, mark in enumerate(MARKS):
                text = f"{mark} {number}"
                buttons = tuple(
                    tuple(replace(button, label=text) for button in row) for row in before.buttons
                )
                messenger._put(
                    account,
                    replace(before, id=f"hostile {number} {kind}", text=text, buttons=buttons),
                )
            await asyncio.sleep(0.02)
        last = f"{MARKS[-1]} {TIMES - 1}"
        await expect(page.locator(".messages .text").last).to_have_text(last)
        found = await page.evaluate(
            "[window.ran || 0, document.querySelectorAll("
            "'#page script, #page iframe, #page style, #page [onerror], #page [onload]').length,"
            " document.querySelectorAll('.messages a, .messages img, .messages b').length]"
        )
        assert found == [0, 0, 0]


async def test_a_gateway_that_is_restarted_is_come_back_to() -> None:
    store = MemoryStore()
    async with chromium() as browser:
        async with served(store=store) as place:
            port = place.server.port
            context = opened(browser, place, DESK)
            there = await context.__aenter__()
            await there.sign_in()
            await expect(there.page.locator(".robot").first).to_contain_text("connected")
        lost = there.page.locator(".link")
        await expect(lost).to_contain_text("No connection to the gateway")
        listen = HostPort("127.0.0.1", port)
        async with served(ApiSettings(listen=listen), store=store):
            await there.connected()
            await expect(there.page.get_by_text("The gateway was restarted.")).to_be_visible()
            await expect(there.page.locator(".robot").first).to_contain_text("connected")
            await context.__aexit__(None, None, None)
