"""In a browser: what is held, shown or signed in when a connection, a gateway or a right ends."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace
from playwright.async_api import expect

from rosic.api.settings import ApiSettings, HostPort
from rosic.app.demo import fleet
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.stores.memory import MemoryStore
from tests.api.served import served
from tests.console.browser import DESK, opened
from tests.console.cable import cable

if TYPE_CHECKING:
    from playwright.async_api import Browser

    from tests.api.served import ServedGateway
    from tests.console.browser import OpenPage

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.limit(300)]
PAD = """
window.pad = [0, 0];
navigator.getGamepads = () => {
  window.looked += 1;
  return [{ connected: true, axes: window.pad }];
};
"""
"""A gamepad of which a test moves the stick: [to the right, back]."""
AHEAD, FREE = "window.pad = [0, -0.8]", "window.pad = [0, 0]; window.looked = 0"
STILL_S = 0.5


def moves(place: ServedGateway) -> bool:
    return place.gateway.rooms.linker.presence("omni").at_rest is False


async def stays_at_rest(place: ServedGateway) -> None:
    await place.until(lambda: not moves(place))
    for _ in range(10):
        await asyncio.sleep(STILL_S / 10)
        assert not moves(place)


async def test_a_gamepad_steers_and_what_is_held_over_a_break_does_not(
    browser: Browser, place: ServedGateway
) -> None:
    async with (
        cable(place.server.port) as link,
        opened(browser, place, DESK, url=link.url) as there,
    ):
        page = there.page
        await page.add_init_script(PAD + AHEAD)
        await there.sign_in()
        await there.go("drive/omni")
        await expect(page.get_by_role("application")).to_be_visible()
        await stays_at_rest(place)  # it was held before the page was there
        await page.evaluate(FREE)
        await there.becomes("window.looked > 1")
        await page.evaluate(AHEAD)
        await place.until(lambda: moves(place))
        link.whole.clear()
        await place.until(lambda: not moves(place))
        await expect(page.locator(".link")).to_contain_text("No connection to the gateway")
        link.whole.set()
        await there.connected()
        await stays_at_rest(place)
        await page.evaluate(FREE)
        await there.becomes("window.looked > 1")
        await page.evaluate(AHEAD)
        await place.until(lambda: moves(place))
        await page.evaluate(FREE)
        await place.until(lambda: not moves(place))


async def test_a_key_that_repeats_by_itself_is_no_press(
    there: OpenPage, place: ServedGateway
) -> None:
    await there.sign_in()
    await there.go("drive/omni")
    stick = there.page.get_by_role("application")
    await stick.focus()
    await there.page.keyboard.down("ArrowUp")
    await place.until(lambda: moves(place))
    await there.page.evaluate("dispatchEvent(new Event('blur'))")
    await there.page.keyboard.down("ArrowUp")  # again, without being let go: as it repeats
    await stays_at_rest(place)
    await there.page.keyboard.up("ArrowUp")
    await there.page.keyboard.down("ArrowUp")
    await place.until(lambda: moves(place))
    await there.page.keyboard.up("ArrowUp")
    await place.until(lambda: not moves(place))


async def test_a_session_that_ends_in_the_middle_brings_the_robot_to_rest(
    there: OpenPage, place: ServedGateway
) -> None:
    await there.sign_in()
    await there.go("drive/omni")
    await there.page.get_by_role("application").focus()
    await there.page.keyboard.down("ArrowUp")
    await place.until(lambda: moves(place))
    ended = place.gateway.access.page_sessions.end_all(place.principal("Ada"))
    await place.gateway.access.changes.take_away(ended)
    await place.until(lambda: not moves(place))
    await expect(there.page.get_by_label("Code")).to_be_visible()
    await stays_at_rest(place)
    await there.page.keyboard.up("ArrowUp")


async def test_no_other_robot_takes_the_place_of_one_that_is_gone(browser: Browser) -> None:
    roles = DEFAULT_ROLES | {"base": Role(scopes=("omni:*",))}
    async with (
        served(rules=RoleRules(roles=roles)) as place,
        opened(browser, place, DESK) as there,
    ):
        await there.sign_in("Bo")
        await there.go("drive")
        await expect(there.page.locator(".choose select")).to_have_value("kuka1")
        authority, bo = place.gateway.authority, place.principal("Bo")
        authority.grants_book.set_roles(bo, ("base",))
        authority.renew(bo)
        gone = there.page.locator(".gone")
        await expect(gone).to_contain_text("KUKA iiwa is not here any more, or you may not see it.")
        await expect(there.page.get_by_role("application")).to_have_count(0)
        assert await there.violations() == []
        await gone.get_by_role("button", name="omni").click()
        await expect(there.page.locator(".choose select")).to_have_value("omni")


async def test_a_gateway_that_is_restarted_is_come_back_to_with_other_robots(
    browser: Browser,
) -> None:
    store = MemoryStore()
    async with served(store=store) as place:
        port = place.server.port
        context = opened(browser, place, DESK)
        there = await context.__aenter__()
        await there.sign_in()
        await there.go("drive/kuka1")
        await expect(there.page.get_by_role("form").first).to_be_visible()
    await expect(there.page.locator(".link")).to_contain_text("No connection to the gateway")
    others = tuple(
        replace(profile, title="Rolli") if profile.id == "omni" else profile
        for profile in fleet()
        if profile.id != "kuka1"
    )
    listen = ApiSettings(listen=HostPort("127.0.0.1", port))
    async with served(listen, store=store, profiles=others):
        await there.connected()
        await expect(there.page.get_by_text("The gateway was restarted.")).to_be_visible()
        await expect(there.page.locator(".gone")).to_contain_text("KUKA iiwa is not here any more")
        await there.go("live")
        await expect(there.page.locator(".robot").first).to_contain_text("Rolli")
        await expect(there.page.locator(".robot").first).to_contain_text("connected")
        await context.__aexit__(None, None, None)
