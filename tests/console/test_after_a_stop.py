"""What stands on the page is true of now: after a stop, after a resume, and in a tab left open."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import pytest
from playwright.async_api import expect

from tests.api.served import served
from tests.console.browser import DESK, PHONE, opened
from tests.console.robots import RESTLESS

if TYPE_CHECKING:
    from playwright.async_api import Browser

    from tests.api.served import ServedGateway
    from tests.console.browser import OpenPage

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.limit(300)]
ON_A_PHONE = pytest.mark.parametrize("there", [PHONE], ids=["phone"], indirect=True)


async def test_a_robot_goes_on_by_its_own_button_and_what_was_said_of_the_stop_goes(
    there: OpenPage, place: ServedGateway
) -> None:
    page = there.page
    await there.sign_in()
    await there.go("drive/omni")
    rest = page.locator(".stop-said strong")
    status = page.get_by_label("Robot", exact=True).get_by_role("button", name="Resume omni")
    await page.locator("button.stop").click()
    await expect(rest).to_have_text("At rest")
    await expect(page.locator(".stop-said time")).to_be_visible()
    form = page.get_by_role("form", name="Move in a straight line")
    await form.get_by_label("Distance").fill("0.3")
    await form.get_by_role("button", name="Give the order").click()
    await expect(form.get_by_role("status")).to_contain_text("omni is stopped")
    await status.click()
    await expect(page.locator(".messages")).to_contain_text("omni is ready again")
    await expect(rest).to_have_count(0)
    await expect(form.locator(".said")).to_have_text("")
    await expect(status).to_have_count(0)
    assert not place.gateway.rooms.stops["omni"].latched
    used = page.locator(".messages").get_by_role("button", name="Resume omni").first
    await used.click()
    await expect(page.locator(".chat")).to_contain_text("Nothing is stopped there")
    await there.go("live")
    card = page.locator(".robot", has_text="KUKA iiwa")
    await card.get_by_role("button", name="Resume KUKA iiwa").click()
    await expect(card.get_by_role("button", name="Resume")).to_have_count(0)
    assert not place.gateway.rooms.stops["kuka1"].latched
    assert await there.violations() == []


COVERED = """() => {
  const said = document.querySelector(".stop-said").getBoundingClientRect();
  const within = (one, place) => ({
    left: Math.max(one.left, place.left), right: Math.min(one.right, place.right),
    top: Math.max(one.top, place.top), bottom: Math.min(one.bottom, place.bottom),
  });
  const shown = (each) => {
    const place = each.closest(".messages, .scroll, nav");
    const own = each.getBoundingClientRect();
    return place ? within(own, place.getBoundingClientRect()) : own;
  };
  const over = ({ left, right, top, bottom }) => left < right && top < bottom;
  return [...document.querySelectorAll("button, a, input, select, summary")]
    .filter((each) => each.checkVisibility() && !each.closest(".stop-said, .skip"))
    .filter((each) => over(within(shown(each), said)))
    .map((each) => `${each.textContent} at ${each.getBoundingClientRect().top}`);
}"""
"""What can be tapped and lies under what is said of a stop."""


@pytest.mark.parametrize("there", [DESK, PHONE], ids=["desk", "phone"], indirect=True)
async def test_what_is_said_of_a_stop_covers_nothing_and_is_dismissed_once_all_are_at_rest(
    there: OpenPage,
) -> None:
    page = there.page
    size = DESK if (page.viewport_size or PHONE)["width"] == DESK["width"] else PHONE
    await there.sign_in()
    await expect(page.locator(".robot")).to_have_count(6)
    rest, dismiss = page.locator(".stop-said strong"), page.locator(".stop-said button")
    for part in ("live", "drive/omni"):
        await there.go(part)
        await page.evaluate("scrollTo(0, 0)")
        await page.locator("button.stop").click()
        await expect(rest).to_have_text("At rest")
        await expect(page.get_by_role("button", name="Resume omni").first).to_be_visible()
        assert await page.evaluate(COVERED) == []
        assert await there.sticking_out(size) == []
        assert await there.violations() == []
        last = page.locator("main .panel").last
        await page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
        box, bar = await last.bounding_box(), await page.locator(".stopbar").bounding_box()
        assert box is not None
        assert bar is not None
        assert box["y"] + box["height"] <= (bar["y"] if bar["y"] > 0 else size["height"])
        await expect(rest).to_be_in_viewport(ratio=1)
        await dismiss.click()
        await expect(rest).to_have_count(0)
    RESTLESS.add("omni")
    await page.locator("button.stop").click()
    await expect(rest).to_have_text("Not confirmed: look!")
    await expect(dismiss).to_have_count(0)
    assert await page.evaluate(COVERED) == []


async def test_that_there_is_no_robot_is_said_once_one_would_have_been_heard_of(
    there: OpenPage,
) -> None:
    await there.page.add_init_script(WITHOUT_ROBOTS)
    await there.sign_in()
    await expect(there.page.get_by_text("You may see no robot here.")).to_be_visible()
    assert await there.page.evaluate("window.read") == [
        "One moment …",
        "You may see no robot here.",
    ]


WITHOUT_ROBOTS = """
const parse = JSON.parse;
JSON.parse = (text) => {
  const found = parse(text);
  return found?.event === "robot" ? { event: "pong" } : found;
};
window.read = [];
new MutationObserver(() => {
  const said = document.querySelector("section.robots .quiet")?.textContent;
  if (said && window.read.at(-1) !== said) window.read.push(said);
}).observe(document, { childList: true, subtree: true, characterData: true });
"""
"""Nothing is heard of robots, and what stands in their place is noted."""


async def test_the_chosen_tab_stays_in_view_in_a_window_that_becomes_narrow(
    there: OpenPage,
) -> None:
    await there.sign_in()
    await there.go("health")
    chosen = there.page.locator("nav a[aria-current]")
    await expect(chosen).to_be_in_viewport(ratio=1)
    await there.page.set_viewport_size(PHONE)  # type: ignore[arg-type]
    await expect(chosen).to_be_in_viewport(ratio=1)


async def test_the_map_waits_for_the_first_robot_that_says_where_it_is(there: OpenPage) -> None:
    await there.page.add_init_script(WITHOUT_PLACES)
    await there.sign_in()
    await expect(there.page.locator(".robot")).to_have_count(6)
    await expect(there.page.get_by_text("No robot says where it is.")).to_be_visible()


WITHOUT_PLACES = """
const parse = JSON.parse;
JSON.parse = (text) => {
  const found = parse(text);
  if (found?.event === "robot") found.robot.presence.pose = null;
  return found;
};
"""


@pytest.mark.parametrize("x_m", ["1e17", "found.robot.id.length * 1e9"])
async def test_robots_that_say_a_place_beyond_all_maps_leave_the_page_alive(
    there: OpenPage, x_m: str
) -> None:
    """Where the next place beside another is the same number, there is none; nor are lines drawn
    for each metre between robots that are a million kilometres apart."""
    pose = "found.robot.presence.pose"
    far = f"{pose} && {{ ...{pose}, x_m: {x_m}, y_m: -1e17 }}"
    await there.page.add_init_script(WITHOUT_PLACES.replace("null", far))
    await there.sign_in()
    await expect(there.page.locator("figure.map")).to_be_visible()
    await there.go("fleet")
    await expect(there.page.locator("#h-busy")).to_be_visible()


async def test_what_is_said_of_a_stop_goes_when_somebody_elsewhere_resumes(
    there: OpenPage, place: ServedGateway
) -> None:
    await there.sign_in("Bo")
    await there.page.locator("button.stop").click()
    await expect(there.page.locator(".stop-said strong")).to_have_text("At rest")
    omni = there.page.locator(".robot", has_text="omni")
    await expect(omni.locator(".robot-stopped")).to_be_visible()  # seen, before it goes on
    ada = await place.person("Ada")
    await ada.post("/v1/chat", json={"text": "resume omni"})
    await expect(there.page.locator(".stop-said strong")).to_have_count(0)


async def test_a_link_that_is_opened_where_signing_in_stands_already_signs_in(
    there: OpenPage, place: ServedGateway
) -> None:
    await there.page.goto(place.url)
    await expect(there.page.get_by_label("Code")).to_be_visible()
    await there.go(f"code={place.code('Ada')}")
    await there.connected()
    assert "code" not in there.page.url


@ON_A_PHONE
async def test_on_a_phone_a_code_is_on_one_line_and_another_tab_begins_at_its_top(
    there: OpenPage,
) -> None:
    page = there.page
    await there.sign_in()
    await there.go("people")
    form = page.get_by_role("form", name="Invite somebody")
    await form.get_by_role("button", name="Invite", exact=True).click()
    code = page.locator(".new-invitation .code")
    await expect(code).to_be_visible()
    lines = await code.evaluate("e => e.getClientRects().length && e.offsetHeight / 24")
    assert lines < 2 * 1.45
    inside = await code.evaluate("e => e.scrollWidth <= e.parentElement.clientWidth")
    assert inside
    await page.evaluate("scrollTo(0, 2000)")
    assert await page.evaluate("scrollY") > 0
    await there.go("live")
    await expect(page.locator(".robot").first).to_be_in_viewport()
    assert await page.evaluate("scrollY") == 0


async def test_a_gateway_without_passkeys_says_so_in_one_sentence(
    browser: Browser, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rosic.api.passkey_routes", None)  # as without the extra
    async with served() as place, opened(browser, place, DESK) as there:
        await there.sign_in()
        await there.go("people")
        passkeys = there.page.get_by_role("region", name="My passkeys")
        await expect(passkeys).to_contain_text("Passkeys are not installed on this gateway.")
        await expect(there.page.get_by_text("There is nothing at this address.")).to_have_count(0)
        await expect(passkeys.get_by_role("button")).to_have_count(0)


async def test_who_may_not_drive_is_told_so_and_not_that_the_robot_cannot(there: OpenPage) -> None:
    await there.sign_in("Vi")
    await there.go("drive/omni")
    jog = there.page.get_by_role("region", name="Live control")
    await expect(jog).to_contain_text("You may not drive omni live.")
    await there.go("drive/yumi")
    await expect(jog).to_contain_text("YuMi cannot be driven live.")


async def test_a_german_browser_is_spoken_to_in_german_until_somebody_chooses(
    browser: Browser, place: ServedGateway
) -> None:
    async with opened(browser, place, DESK, locale="de-DE") as there:
        page = there.page
        # As a terminal says that nobody has set.
        place.gateway.languages.hear(place.principal("Bo"), "C")
        await page.goto(f"{place.url}/#code={place.code('Bo')}")
        await expect(page.get_by_text("Gateway verbunden")).to_be_visible()
        await there.go("drive/omni")
        await expect(page.get_by_role("form", name="Ein Stück fahren")).to_contain_text("Richtung")
        await page.get_by_label("Nachricht").fill("/language en")
        await page.get_by_role("button", name="Senden").click()
        await there.connected()
