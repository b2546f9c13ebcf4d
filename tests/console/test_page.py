"""The page in a real browser: signed in by one's chat, driven, stopped, cut off, and back."""

from __future__ import annotations

import asyncio
import re
import time
from typing import TYPE_CHECKING

import pytest
from playwright.async_api import expect

from rosic.api.page_messenger import FILES_KEPT
from rosic.core.message import Attachment
from tests.console.browser import DESK, PHONE, WALL, opened
from tests.console.robots import CUT, RESTLESS, SILENT, STOPPED_AT
from tests.pace import patience

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from playwright.async_api import Browser

    from tests.api.served import ServedGateway
    from tests.console.browser import OpenPage

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.limit(300)]
HANDED_WITHIN_S = 0.1
SAID_WITHIN_S = 2.0
SIZES = pytest.mark.parametrize("there", [DESK, PHONE], ids=["desk", "phone"], indirect=True)


@SIZES
async def test_somebody_signs_in_by_their_chat_and_orders_by_form_and_by_line(
    there: OpenPage, place: ServedGateway
) -> None:
    name = "desk" if there.page.viewport_size == DESK else "phone"
    page = there.page
    await page.goto(place.url)
    await expect(page.get_by_text("Write /signin to ROSIC in your own chat.")).to_be_visible()
    assert await there.violations() == []
    await page.get_by_label("Code").fill("NONE-SUCH")
    await page.get_by_role("button", name="Sign in", exact=True).click()
    await expect(page.get_by_role("alert")).to_contain_text("That code is not good")
    await there.picture(f"sign-in-{name}")
    await page.get_by_label("Code").fill(place.code("Ada"))
    await page.get_by_role("button", name="Sign in", exact=True).click()
    await there.connected()
    await there.go("drive/omni")
    form = page.get_by_role("form", name="Move in a straight line")
    await form.get_by_label("Distance").fill("0.3")
    await form.get_by_label("Direction").select_option("left")
    await form.get_by_role("button", name="Check only").click()
    await expect(form.get_by_role("status")).to_have_text("This would be sent: move, 0.30 m left")
    await expect(page.get_by_text("Nothing was sent yet.")).to_be_visible()
    await form.get_by_role("button", name="Give the order").click()
    await expect(form.get_by_role("status")).to_have_text("Given: move, 0.30 m left")
    row = page.locator("table.orders tbody tr").first
    await expect(row.locator(".received")).to_contain_text("move, 0.30 m left")
    await expect(row).to_contain_text("done")
    await there.say("omni turn left 20")
    await expect(page.locator(".messages")).to_contain_text("turn, 20 deg left")
    await expect(page.locator("table.orders tbody tr").first).to_contain_text("done")
    await there.picture(f"drive-{name}", whole=there.page.viewport_size == DESK)
    assert await there.violations() == []


@SIZES
async def test_a_link_signs_in_and_its_code_stays_nowhere(
    there: OpenPage, place: ServedGateway
) -> None:
    await there.page.goto(f"{place.url}/#code={place.code('Bo')}")
    await there.connected()
    assert "code" not in there.page.url
    assert await there.page.evaluate("history.length") <= 2


async def test_a_code_that_is_none_shows_where_to_sign_in(
    there: OpenPage, place: ServedGateway
) -> None:
    await there.page.goto(f"{place.url}/#code=%")
    await expect(there.page.get_by_label("Code")).to_have_value("%")
    assert "code" not in there.page.url


@SIZES
async def test_stop_is_handed_over_at_once_and_true_when_it_says_at_rest(
    there: OpenPage, place: ServedGateway
) -> None:
    page = there.page
    await there.sign_in()
    await page.evaluate(
        "addEventListener('keydown', () => { window.pressed = Date.now(); }, true);"
        "addEventListener('pointerdown', () => { window.pressed = Date.now(); }, true);"
    )
    for part in ("live", "drive/omni"):
        await there.go(part)
        STOPPED_AT.clear()
        button = page.locator("button.stop")
        await expect(button).to_be_in_viewport(ratio=1)
        if there.page.viewport_size == DESK:
            await page.locator("#main-part").focus()
            await page.keyboard.press("Space")
        else:
            await button.tap()
        await place.until(lambda: len(STOPPED_AT) >= 6)
        await expect(page.locator(".stop-said strong")).to_have_text("At rest")
        pressed_s = await page.evaluate("window.pressed") / 1000
        assert {robot for robot, _ in STOPPED_AT} >= {"omni", "kuka1", "yumi", "cf1"}
        first_s = max(at for _, at in STOPPED_AT[:6]) - pressed_s
        assert first_s < HANDED_WITHIN_S * patience()
    assert await there.violations() == []


async def test_a_space_that_is_typed_stops_nothing(there: OpenPage) -> None:
    await there.sign_in()
    await there.go("drive/omni")
    await there.page.get_by_label("Message").press_sequentially("omni turn left 20")
    assert await there.page.get_by_label("Message").input_value() == "omni turn left 20"
    assert STOPPED_AT == []


async def test_a_stop_that_was_not_confirmed_says_so(there: OpenPage) -> None:
    RESTLESS.add("omni")
    await there.sign_in()
    await expect(there.page.locator(".robot")).to_have_count(6)
    await there.page.locator("button.stop").click()
    said = there.page.locator(".stop-said")
    await expect(said.locator("strong")).to_have_text("Not confirmed: look!")
    await expect(said).to_contain_text("omni")
    await there.picture("stop-not-confirmed")


async def test_a_stop_reaches_the_gateway_also_without_the_connection(
    there: OpenPage, place: ServedGateway
) -> None:
    await there.page.add_init_script("window.WebSocket = class { close() {} send() {} };")
    await there.page.goto(f"{place.url}/#code={place.code('Ada')}")
    button = there.page.locator("button.stop")
    await button.click()
    await expect(there.page.locator(".stop-said strong")).to_have_text("At rest")
    assert STOPPED_AT != []


async def test_what_was_sent_and_not_received_stands_out(there: OpenPage) -> None:
    SILENT.add("omni")
    await there.sign_in()
    await there.go("drive/omni")
    await there.say("omni move 0.3 m left")
    row = there.page.locator("table.orders tbody tr").first
    await expect(row.locator(".received")).to_contain_text("waiting for the robot")
    await expect(row).to_have_class("mismatch")
    await expect(row.locator(".received")).to_contain_text("sent, and not received")
    await there.say("kuka1 grasp force=20")
    await there.go("live")
    await expect(there.page.locator("table.orders")).to_contain_text("grasp, 20 N")
    await expect(there.page.locator(".view")).to_contain_text("Taken at")
    await there.picture("mismatch")
    assert await there.violations() == []


def push_out_files(place: ServedGateway) -> None:
    """Have newer files kept in Ada's conversation than those that are there."""
    said = place.server.context.page.conversation(place.principal("Ada"))
    for number in range(FILES_KEPT):
        said.keep_file(f"newer {number}", Attachment("a.txt", "text/plain", b"a"))


@SIZES
async def test_a_picture_in_the_conversation_is_seen_and_a_file_is_saved(  # noqa: PLR0915 - one way
    there: OpenPage, place: ServedGateway
) -> None:
    page = there.page
    await there.sign_in()
    await there.go("drive/omni")
    picture = page.locator(".message-file img")
    busy = page.get_by_text("Try again in a moment")
    await there.say("picture omni")
    while not await picture.count():  # whoever looked before may still be drawn for
        asked = await busy.count()
        await expect(picture.or_(busy.nth(asked)).first).to_be_visible()
        if await busy.count() > asked:
            await there.say("picture omni")
    seen = "document.querySelector('.message-file img')"
    await there.becomes(f"{seen}.complete && {seen}.naturalWidth > 100")
    box = await picture.bounding_box()
    assert box is not None
    assert box["height"] < 300
    await there.say("/record omni 3 s")
    link = page.get_by_role("link", name=re.compile(r"Save omni.*\.mcap"))
    await expect(link).to_be_visible()
    assert await page.locator(".messages").evaluate(
        "e => e.scrollTop + e.clientHeight >= e.scrollHeight - 1"
    )
    async with page.expect_download() as saved:
        await link.click()
    download = await saved.value
    assert download.suggested_filename == await link.inner_text()
    assert (await download.path()).read_bytes().startswith(b"\x89MCAP")
    assert (
        await there.sticking_out(
            DESK if (page.viewport_size or PHONE)["width"] == DESK["width"] else PHONE
        )
        == []
    )
    assert await there.violations() == []
    push_out_files(place)
    await link.click()
    await expect(page.get_by_text(re.compile(r"\.mcap is not kept any more\."))).to_be_visible()
    await page.reload()
    await expect(link).to_be_visible()
    await page.locator(".messages").evaluate("e => e.scrollTo(0, 0)")
    await expect(page.get_by_text("omni.jpg is not kept any more.")).to_be_visible()
    await expect(picture).to_have_count(0)


async def test_a_pulled_cable_is_said_within_two_seconds(there: OpenPage) -> None:
    await there.sign_in()
    card = there.page.locator(".robot", has_text="omni")
    await expect(card).to_contain_text("connected")
    CUT.add("omni")
    cut_s = time.monotonic()
    await expect(card).to_contain_text("connection lost")
    assert time.monotonic() - cut_s < SAID_WITHIN_S * patience()
    assert await there.violations() == []


async def test_a_cut_link_of_the_page_is_said_within_two_seconds_and_comes_back(
    there: OpenPage,
) -> None:
    page = there.page
    await page.add_init_script(CUTTABLE)
    await there.sign_in()
    card = page.locator(".robot", has_text="omni")
    await expect(card).to_contain_text("connected")
    await page.evaluate("window.cut = true")
    cut_s = time.monotonic()
    await expect(page.locator(".link")).to_contain_text("No connection to the gateway")
    assert time.monotonic() - cut_s < SAID_WITHIN_S * patience()
    await expect(card).to_contain_text("unknown: no connection to the gateway")
    assert await there.violations() == []
    await there.picture("cut-off")
    assert await there.sticking_out(PHONE) == []
    await page.evaluate("window.cut = false")
    await there.connected()
    await expect(page.get_by_text("The connection is back.")).to_be_visible()
    await expect(card).to_contain_text("connected")


CUTTABLE = """
window.cut = false;
const Real = window.WebSocket;
window.WebSocket = class extends Real {
  set onmessage(hear) { super.onmessage = (event) => { if (!window.cut) hear(event); }; }
  send(text) { if (!window.cut) super.send(text); }
};
"""
"""A socket that says nothing and hears nothing, as one whose cable was pulled."""


BROKEN_OFF = re.compile("stood still|fell silent|never said anything|come too late")
"""What ends live control where this machine has no time for the gateway or the page, rightly."""


async def held(
    there: OpenPage,
    place: ServedGateway,
    hold: Callable[[], Awaitable[None]],
    let_go: Callable[[], Awaitable[None]],
) -> None:
    """Hold a control until omni moves; what was broken off is let go, and begun anew."""
    said, presence = there.page.locator(".jogging .said"), place.gateway.rooms.linker.presence
    async with asyncio.timeout(60 * patience()):
        while True:
            await there.go("live")
            await expect(there.page.locator(".robot")).to_have_count(6)
            await there.go("drive/omni")
            await expect(said).to_have_text("")
            await hold()
            while not BROKEN_OFF.search(await said.inner_text()):
                if presence("omni").at_rest is False:
                    return
            await let_go()


async def test_the_stick_drives_while_it_is_held(there: OpenPage, place: ServedGateway) -> None:
    page = there.page
    await there.sign_in()
    stick = page.get_by_role("application")
    presence = place.gateway.rooms.linker.presence
    said = page.locator(".jogging .said")

    async def by_key() -> None:
        await stick.focus()
        await page.keyboard.down("ArrowUp")

    await held(there, place, by_key, lambda: page.keyboard.up("ArrowUp"))
    await expect(said).to_have_text(re.compile(f"Driving live|{BROKEN_OFF.pattern}"))
    await expect(page.locator("table.orders .received").first).to_contain_text("drive, live")
    await there.picture("jog", showing="Driving live. Letting go brings it to rest.")
    await page.keyboard.up("ArrowUp")
    await expect(said).to_have_text(re.compile(f"drove live for|{BROKEN_OFF.pattern}"))
    talk = page.locator(".messages")
    await expect(talk).to_contain_text("drive, live")
    await expect(talk).not_to_contain_text("linear=")
    await expect(talk.get_by_role("button", name="Again")).to_have_count(0)
    await place.until(lambda: presence("omni").at_rest is True)

    async def by_mouse() -> None:
        await stick.hover()
        await page.mouse.down()
        box = await stick.bounding_box()
        assert box is not None
        await page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 4)

    await held(there, place, by_mouse, page.mouse.up)
    await page.keyboard.press("Space")  # a stop, whatever is held
    await expect(page.locator(".stop-said strong")).to_have_text("At rest")
    await page.mouse.up()
    assert presence("omni").at_rest is True


async def test_a_space_on_a_slider_is_a_stop(there: OpenPage, place: ServedGateway) -> None:
    await there.sign_in()
    await there.go("drive/omni")
    await there.page.get_by_role("slider").focus()
    await there.page.keyboard.press("Space")
    await place.until(lambda: STOPPED_AT)


async def test_a_window_that_is_left_lets_go(there: OpenPage, place: ServedGateway) -> None:
    await there.sign_in()
    await there.go("drive/omni")
    await there.page.get_by_role("application").focus()
    await there.page.keyboard.down("ArrowUp")
    presence = place.gateway.rooms.linker.presence
    await place.until(lambda: presence("omni").at_rest is False)
    await there.page.evaluate("dispatchEvent(new Event('blur'))")
    await place.until(lambda: presence("omni").at_rest is True)


async def test_who_signs_out_or_is_signed_out_sees_nothing_more(
    there: OpenPage, place: ServedGateway
) -> None:
    await there.sign_in("Bo")
    ended = place.gateway.access.page_sessions.end_all(place.principal("Bo"))
    await place.gateway.access.changes.take_away(ended)
    await expect(there.page.get_by_text("Sign in first")).to_be_visible()
    await expect(there.page.get_by_label("Code")).to_be_visible()
    assert await there.page.locator(".robot").count() == 0


async def test_in_german_and_in_the_dark_and_on_the_wall(
    browser: Browser, place: ServedGateway
) -> None:
    async with opened(browser, place, WALL, color_scheme="dark") as there:
        page = there.page
        await there.sign_in()
        await there.go("drive/omni")
        await there.say("/language de")
        await expect(page.get_by_text("Gateway verbunden")).to_be_visible()
        assert await page.evaluate("document.documentElement.lang") == "de"
        await expect(page.get_by_role("form", name="Ein Stück fahren")).to_contain_text("Richtung")
        for line in ("omni move 0.5 m links", "cf1 takeoff 1 m", "kuka1 grasp force=20"):
            await page.get_by_label("Nachricht").fill(line)
            await page.get_by_role("button", name="Senden").click()
            await expect(page.locator(".messages .own").last).to_contain_text(line)
        await there.go("live")
        await expect(page.get_by_text("Vom Roboter empfangen")).to_be_visible()
        await expect(page.locator("table.orders tbody tr")).to_have_count(3)
        await expect(page.locator("table.orders tbody tr").last).to_contain_text("fertig")
        await there.picture("live-wall-dark")
        assert await there.violations() == []


async def test_the_live_page_at_the_desk_and_on_the_phone(there: OpenPage) -> None:
    await there.sign_in()
    await there.go("drive/omni")
    for line in ("omni move 1 m left", "cf1 takeoff 1 m", "kuka1 grasp force=20"):
        await there.say(line)
    await expect(there.page.locator("table.orders tbody tr")).to_contain_text(["done"])
    await there.go("live")
    await expect(there.page.locator("table.orders tbody tr")).to_have_count(3)
    camera = there.page.get_by_role("img", name="What omni sees now")
    await expect(camera).to_be_visible()
    await expect(there.page.locator(".view")).to_contain_text("Taken at")
    await there.picture("live-desk", whole=True)
    await there.page.set_viewport_size(PHONE)  # type: ignore[arg-type]
    wide = await there.page.evaluate("document.documentElement.scrollWidth")
    assert wide <= PHONE["width"]
    await there.picture("live-phone")
    assert await there.violations() == []
