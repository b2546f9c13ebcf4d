"""In a browser: what comes from outside is text, wherever it is shown."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace
from playwright.async_api import expect

from rosic.app.demo import fleet
from tests.api.served import served
from tests.console.browser import DESK, opened
from tests.console.robots import SAYING, noting

if TYPE_CHECKING:
    from playwright.async_api import Browser

    from rosic.core.robot.profile import Profile
    from tests.console.browser import OpenPage

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.limit(300)]
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
FILES_AT_ONCE = 10
"""So many are taken in of one person at a time."""


def hostile_fleet() -> tuple[Profile, ...]:
    return tuple(
        replace(profile, title=MARKS[number % len(MARKS)]) for number, profile in enumerate(fleet())
    )


async def test_five_hundred_payloads_are_shown_and_none_runs(browser: Browser) -> None:
    async with (
        served(profiles=hostile_fleet()) as place,
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
        await nothing_ran(there)


async def nothing_ran(there: OpenPage) -> None:
    """See that no payload ran, and that none of them is anything but text."""
    found = await there.page.evaluate(
        "[window.ran || 0, document.querySelectorAll("
        "'#page script, #page iframe, #page style, #page [onerror], #page [onload],"
        " #page [ontoggle], #page [onmouseover], #page a[href^=javascript]').length,"
        " document.querySelectorAll('.messages a, .messages img, .messages b').length]"
    )
    assert found == [0, 0, 0]


async def test_telemetry_people_and_files_with_payloads_for_names_are_text(
    browser: Browser,
) -> None:
    texts = [f"{mark} {number}" for number in range(TIMES) for mark in MARKS]
    SAYING.clear()
    async with (
        served(robots_of=noting) as place,
        opened(browser, place, DESK) as there,
    ):
        page, ada = there.page, place.principal("Ada")
        await there.sign_in()
        for mark in MARKS[:FILES_AT_ONCE]:
            place.chat.enclose(f"{mark}.txt", b"x", account="ada", chat="ada")
        SAYING.update({text: text for text in texts} | {"battery": 50.0})
        telemetry = page.locator(".telemetry .facts > div")
        await expect(telemetry).to_have_count(len(texts))
        await expect(telemetry.first).to_contain_text(MARKS[0])
        await nothing_ran(there)
        SAYING.clear()
        directory = place.gateway.rooms.authoriser.directory
        for number, mark in enumerate(MARKS):
            await place.key("viewer", name=f"{number} {mark}")
        shown = [one.name for one in directory.people()]
        await there.go("people")
        await expect(page.locator(".known tbody tr")).to_have_count(len(shown))
        for name in shown:
            await expect(page.locator(".known tbody")).to_contain_text(name)
        await nothing_ran(there)
        containers = place.gateway.kernel.containers
        assert containers is not None
        await place.until(lambda: len(containers.files.of(ada)) == FILES_AT_ONCE)
        await there.go("files")
        await expect(page.locator("table.stacked tbody tr").first).to_be_visible()
        await nothing_ran(there)
        await there.go("history")
        await nothing_ran(there)
        assert await there.violations() == []
