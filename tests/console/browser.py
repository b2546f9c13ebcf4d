"""A real Chromium in front of a page: at a desk, on a phone, on a wall."""

from __future__ import annotations

import asyncio
import json
import os
from contextlib import asynccontextmanager, suppress
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from PIL import Image
from playwright.async_api import Error, async_playwright, expect

from tests.pace import patience
from tests.servers import needed

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import Browser, Page

    from tests.api.served import ServedGateway

DESK: Final = {"width": 1440, "height": 900}
PHONE: Final = {"width": 390, "height": 844}
WALL: Final = {"width": 2560, "height": 1440}
PICTURES: Final = Path(__file__).parents[2] / "docs" / "pictures"
AXE: Final = (files("axe_playwright_python") / "axe.min.js").read_text()
STICKING_OUT: Final = """async () => {
  for (const _ of "12") await new Promise(requestAnimationFrame);  // charts follow their place
  const found = [];
  const named = (each, why) => found.push(`${why}: ${each.outerHTML.slice(0, 100)}`);
  const wide = document.documentElement.scrollWidth;
  if (wide > innerWidth) {
    for (const each of document.querySelectorAll("body *")) {
      if (each.getBoundingClientRect().right >= wide) named(each, `the page is ${wide} wide`);
    }
  }
  for (const each of document.querySelectorAll(".scroll, .panel, .messages")) {
    if (each.scrollWidth > each.clientWidth + 1) named(each, "is scrolled sideways");
  }
  for (const each of document.querySelectorAll(".panel *")) {
    const [own, place] = [each, each.closest(".panel")].map((one) => one.getBoundingClientRect());
    if (own.right > place.right && !each.closest("thead, .hidden")) named(each, "sticks out");
  }
  return found;
}"""
ACTED_MS: Final = 30_000
SEEN_MS: Final = 15_000
"""So long is waited for what somebody does, and for what shall be seen, on a free machine."""
QUIET_EXIT: Final = "Failed to load resource"
"""What Chromium itself says of a status that the page asked for and understood."""


@asynccontextmanager
async def chromium() -> AsyncIterator[Browser]:
    """Yield the distribution's browser."""
    executable = needed("chromium")
    expect.set_options(timeout=SEEN_MS * patience())
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=executable, args=["--no-sandbox", "--disable-gpu"]
        )
        try:
            yield browser
        finally:
            await browser.close()


class OpenPage:
    """A page that somebody looks at.

    Attributes:
        page: As Playwright knows it.
        url: Where it is reached by this browser.
        wrong: What the browser complained of.
        elsewhere: Addresses that were asked for and are not the gateway's.
        pictures: What was seen, by name, to be drawn into the docs once nobody uses the page.
    """

    def __init__(self, page: Page, place: ServedGateway, url: str) -> None:
        self.page, self.place, self.url = page, place, url
        self.wrong: list[str] = []
        self.elsewhere: list[str] = []
        self.pictures: dict[str, bytes] = {}
        page.set_default_timeout(ACTED_MS * patience())
        page.on("pageerror", lambda error: self.wrong.append(str(error)))
        page.on("console", lambda said: self._complained(said.type, said.text))
        page.on("request", lambda asked: self._asked(asked.url))
        page.on("dialog", lambda dialog: self.wrong.append(f"dialog {dialog.message}"))

    def _complained(self, kind: str, text: str) -> None:
        if kind == "error" and QUIET_EXIT not in text and "WebSocket" not in text:
            self.wrong.append(text)

    def _asked(self, url: str) -> None:
        if not url.startswith((self.url, "data:", "blob:")):
            self.elsewhere.append(url)

    async def sign_in(self, name: str = "Ada") -> None:
        """Come in by a code that was typed."""
        await self.page.goto(self.url)
        await self.page.get_by_label("Code").fill(self.place.code(name))
        await self.page.get_by_role("button", name="Sign in", exact=True).click()
        await self.connected()

    async def connected(self) -> None:
        """Wait until the page hears of robots."""
        await expect(self.page.get_by_text("Gateway connected")).to_be_visible()

    async def go(self, part: str) -> None:
        """Look at another part."""
        await self.page.evaluate("part => { location.hash = part; }", part)

    async def say(self, line: str) -> None:
        """Write something into the conversation."""
        await self.page.get_by_label("Message").fill(line)
        await self.page.get_by_role("button", name="Send").click()

    async def becomes(self, holds: str) -> None:
        """Wait until an expression holds; Playwright's own wait is refused by the page's rules."""
        async with asyncio.timeout(ACTED_MS / 1000 * patience()):
            while not await self.page.evaluate(holds):
                pass

    async def kill(self) -> None:
        """End the process that draws it, as a crash would: it can say nothing more."""
        with suppress(Error):
            await self.page.goto("chrome://crash")

    async def violations(self) -> list[str]:
        """Return what axe finds here that is serious or critical."""
        await self.page.evaluate(f"() => {{ {AXE} }}")
        found: dict[str, Any] = await self.page.evaluate("axe.run()")
        return [
            f"{each['id']}: {json.dumps([node['html'][:120] for node in each['nodes']])}"
            for each in found["violations"]
            if each["impact"] in {"serious", "critical"}
        ]

    async def sticking_out(self, size: dict[str, int]) -> list[str]:
        """Return what is wider than its place, or is scrolled sideways, in a window of a size."""
        await self.page.set_viewport_size(size)  # type: ignore[arg-type]
        found: list[str] = await self.page.evaluate(STICKING_OUT)
        return found

    async def fits(self, name: str) -> None:
        """See that a part is good for everybody, at a desk and on a phone, also in the dark.

        Draws both sizes.
        """
        for size, where in ((PHONE, "phone"), (DESK, "desk")):
            assert await self.sticking_out(size) == [], f"{name} on a {where}"
            for scheme in ("dark", "light"):
                await self.page.emulate_media(color_scheme=scheme)
                assert await self.violations() == [], f"{name} on a {where}, {scheme}"
            await self.as_usual()
            await self.picture(f"{name}-{where}")

    async def as_usual(self) -> None:
        """Wait until nothing is left of how long the look took: axe stops a page for a while."""
        await self.connected()
        for notice in await self.page.get_by_role("button", name="Dismiss").all():
            await notice.click()
        await self.page.evaluate("scrollTo(0, 0)")

    async def picture(self, name: str, *, whole: bool = False, showing: str = "") -> None:
        """Keep what is seen for the docs, where they are drawn anew; once a text is shown, too."""
        if os.environ.get("ROSIC_PICTURES") == "draw":
            if showing:
                await expect(self.page.get_by_text(showing, exact=True).first).to_be_visible()
            self.pictures[name] = await self.page.screenshot(full_page=whole)

    def draw(self) -> None:
        """Draw what was kept, in few colours. The gateway beside it stands still meanwhile."""
        for name, seen in self.pictures.items():
            few = Image.open(BytesIO(seen)).convert("RGB").quantize(256, dither=Image.Dither.NONE)
            few.save(PICTURES / f"console-{name}.png", optimize=True)


@asynccontextmanager
async def opened(
    browser: Browser,
    place: ServedGateway,
    size: dict[str, int],
    url: str = "",
    **how: Any,  # noqa: ANN401
) -> AsyncIterator[OpenPage]:
    """Yield a page of somebody of whom the browser knows nothing yet.

    Args:
        url: Where it finds the gateway, if it is not where that listens.
    """
    touch = size is PHONE
    how = {"locale": "en-GB", **how}
    context = await browser.new_context(viewport=size, has_touch=touch, **how)  # type: ignore[arg-type]
    try:
        there = OpenPage(await context.new_page(), place, url or place.url)
        yield there
        assert there.wrong == [], there.wrong
        assert there.elsewhere == []
        there.draw()
    finally:
        await context.close()
