"""The tabs beside Live and Drive, in a real browser: what there is, and what to do about it."""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, NamedTuple

import pytest
import pytest_asyncio
from msgspec.structs import replace
from playwright.async_api import expect

from rosic.api.settings import ApiSettings, HostPort
from tests.api.served import ANYWHERE, served
from tests.console.browser import DESK, PHONE, opened
from tests.console.robots import DRAINED, noting
from tests.pace import patience

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import Browser, Locator

    from tests.api.served import ServedGateway
    from tests.console.browser import OpenPage

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.limit(300)]
LOCAL_ZONE = "UTC"
TO = "\u2013"


class Site(NamedTuple):
    """A gateway, and Ada's page."""

    place: ServedGateway
    there: OpenPage


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def site(browser: Browser) -> AsyncIterator[Site]:
    DRAINED.add("omni")  # an alarm takes its time, and comes while others are tested
    async with (
        served(robots_of=noting) as place,
        opened(browser, place, DESK, timezone_id=LOCAL_ZONE) as there,
    ):
        await there.sign_in()
        yield Site(place, there)


async def column(there: OpenPage, hours: float) -> tuple[float, float]:
    """Return where a time of tomorrow is on the calendar, scrolled into view."""
    days = there.page.locator(".days")
    morning = "week => { week.scrollTop = week.scrollHeight * 7 / 24; }"
    await there.page.locator(".week").evaluate(morning)
    box = await days.bounding_box()
    assert box is not None
    day = (datetime.now(UTC) + timedelta(days=1)).weekday()
    return box["x"] + box["width"] * (day + 0.5) / 7, box["y"] + box["height"] * hours / 24


async def week_of_tomorrow(there: OpenPage) -> None:
    await there.go("times/kuka1")
    await expect(there.page.locator(".week")).to_be_visible()
    await there.page.get_by_role("button", name="Today").click()
    if datetime.now(UTC).weekday() == 6:
        await there.page.get_by_role("button", name="Later").click()


def own(there: OpenPage) -> Locator:
    return there.page.locator(".booked.own")


async def test_a_time_is_booked_by_dragging_moved_and_given_back(site: Site) -> None:
    place, there = site
    page = there.page
    bo = await place.person("Bo")
    start = (datetime.now(UTC) + timedelta(days=1)).replace(
        hour=9, minute=0, second=0, microsecond=0
    )
    other = {"robot": "kuka1", "start": start.isoformat(), "minutes": 90}
    assert (await bo.post("/v1/bookings", json=other)).status_code == 201
    await week_of_tomorrow(there)
    await expect(page.locator(".booked.others")).to_contain_text(f"09:00{TO}10:30 Bo")
    await page.mouse.move(*await column(there, 11.02))
    await page.mouse.down()
    await page.mouse.move(*await column(there, 12.0))
    await page.mouse.move(*await column(there, 12.51))
    await page.mouse.up()
    await expect(page.locator(".chosen-time")).to_contain_text(f"11:00{TO}12:30")
    await page.get_by_role("button", name="Book KUKA iiwa").click()
    await expect(own(there)).to_contain_text(f"11:00{TO}12:30 Ada")
    await expect(page.locator(".time-form .said")).to_contain_text("KUKA iiwa is yours:")
    # Chosen again, it is moved by its block, and the old time is free.
    await own(there).get_by_role("button").click()
    await page.mouse.move(*await column(there, 11.5))
    await page.mouse.down()
    await page.mouse.move(*await column(there, 13.0))
    await page.mouse.move(*await column(there, 14.5))
    await page.mouse.up()
    await expect(page.locator(".chosen-time")).to_contain_text(f"14:00{TO}15:30")
    await there.fits("times")
    await page.get_by_role("button", name="Move it here").click()
    await expect(own(there)).to_have_count(1)
    await expect(own(there)).to_contain_text(f"14:00{TO}15:30 Ada")
    await page.get_by_role("button", name=re.compile("^Give KUKA iiwa back")).click()
    await expect(own(there)).to_have_count(0)


async def test_a_finger_taps_an_hour_drags_it_and_scrolls_the_rest(
    site: Site, browser: Browser
) -> None:
    async with opened(browser, site.place, PHONE, timezone_id=LOCAL_ZONE) as there:
        await there.sign_in("Bo")
        await there.go("times/yumi")
        page, week = there.page, there.page.locator(".week")
        await expect(week).to_be_visible()
        await week.evaluate("week => week.scrollIntoView({ block: 'start' })")
        await page.evaluate("scrollBy(0, -160)")  # from under what stays in view above
        await week.evaluate("week => { week.scrollTop = week.scrollHeight * 10 / 24; }")
        hand = await page.context.new_cdp_session(page)

        async def at(hours: float) -> dict[str, float]:
            box = await page.locator(".days").bounding_box()
            assert box is not None
            return {
                "x": box["x"] + box["width"] / 2,  # tomorrow, of three days
                "y": box["y"] + box["height"] * hours / 24,
            }

        async def finger(*way: dict[str, float]) -> None:
            for number, point in enumerate(way):
                kind = "touchMove" if number else "touchStart"
                await hand.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [point]})
            await hand.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})

        await finger(await at(11.2))
        chosen = page.locator(".chosen-time")
        await expect(chosen).to_contain_text(f"11:00{TO}12:00")
        await finger(await at(11.4), await at(11.9), await at(12.4), await at(12.9))
        await expect(chosen).to_contain_text(f"12:30{TO}13:30")
        await finger(await at(13.45), await at(13.7), await at(14.0))
        await expect(chosen).to_contain_text(f"12:30{TO}14:00")
        before = await week.evaluate("week => week.scrollTop")
        await finger(*[await at(11.5 - step / 4) for step in range(6)])
        await expect(chosen).to_contain_text(f"12:30{TO}14:00")
        await there.becomes(f"document.querySelector('.week').scrollTop !== {before}")
        await page.get_by_role("button", name="Book YuMi").click()
        await expect(own(there)).to_contain_text(f"12:30{TO}14:00 Bo")


async def test_a_time_is_booked_by_the_keyboard_alone_and_a_refusal_says_why(site: Site) -> None:
    _, there = site
    page = there.page
    await week_of_tomorrow(there)
    await page.get_by_role("group", name="Choose a time").focus()
    await page.keyboard.press("ArrowDown")
    await page.keyboard.press("ArrowRight")
    for _ in range(2):
        await page.keyboard.press("Shift+ArrowDown")
    chosen = await page.locator(".chosen-time").inner_text()
    await page.keyboard.press("Enter")
    await expect(own(there)).to_contain_text(f"{chosen.strip()} Ada")
    await expect(page.locator(".chosen-time")).to_have_count(0)
    await own(there).get_by_role("button").focus()
    await page.keyboard.press("Delete")
    await expect(own(there)).to_have_count(0)
    form = page.get_by_role("form", name="Book a time")
    await page.mouse.click(*await column(there, 9.6))
    await expect(page.locator(".chosen-time")).to_have_count(0)
    await page.mouse.click(*await column(there, 8.6))
    await form.get_by_role("button", name="Book KUKA iiwa").click()
    await expect(form.locator(".said")).to_contain_text("is taken by Bo")


async def test_people_are_listed_given_rights_and_locked_out(site: Site) -> None:
    place, there = site
    page = there.page
    await there.go("people")
    row = page.get_by_role("row", name=re.compile("^Vi "))
    await expect(row).to_contain_text("viewer")
    form = page.get_by_role("form", name="Give a right")
    await form.get_by_role("combobox", name="To whom").select_option("Vi")
    await form.get_by_role("combobox", name="Robot").select_option("omni")
    await form.get_by_role("button", name="Give the right").click()
    await expect(form.locator(".said")).to_have_class("said good")
    await row.get_by_role("button", name="Lock out").click()
    await expect(row).to_contain_text("locked out")
    assert place.principal("Vi") in place.gateway.rooms.organiser.locked
    await row.get_by_role("button", name="Let in again").click()
    await expect(row).to_contain_text("let in")
    await there.fits("people")


async def test_of_two_who_share_a_name_the_one_in_the_row_is_locked_out_and_given_rights(
    site: Site,
) -> None:
    place, there = site
    page, gateway = there.page, place.gateway
    directory = gateway.rooms.authoriser.directory
    bo, vi = (directory.person(place.principal(name)) for name in ("Bo", "Vi"))
    assert bo is not None
    assert vi is not None
    directory.enrol(replace(vi, name="Bo"))
    try:
        await there.go("live")
        await there.go("people")
        row = page.get_by_role("row", name=re.compile("^Bo .*viewer"))
        await row.get_by_role("button", name="Lock out").click()
        await expect(row).to_contain_text("locked out")
        assert set(gateway.rooms.organiser.locked) == {vi.id}
        await row.get_by_role("button", name="Let in again").click()
        await expect(row).to_contain_text("let in")
        form = page.get_by_role("form", name="Give a right")
        whom = form.get_by_role("combobox", name="To whom")
        await whom.select_option(label=f"Bo (viewer, {vi.id})")
        await form.get_by_role("combobox", name="Robot").select_option("omni")
        await form.get_by_role("button", name="Give the right").click()
        await expect(form.locator(".said")).to_have_class("said good")
        now_ns = place.gateway.kernel.clock.wall_ns()
        held = gateway.rooms.organiser.rights.grants(vi.id)
        assert any("omni" in grant.robots and now_ns < (grant.expires_ns or 0) for grant in held)
    finally:
        directory.enrol(vi)


async def test_every_right_is_taken_once_the_question_on_the_tab_is_answered(site: Site) -> None:
    place, there = site
    page, directory = there.page, site.place.gateway.rooms.authoriser.directory
    await place.key("operator", name="Hal")
    hal = place.principal("Hal")
    await there.go("live")
    await there.go("people")
    row, questions = page.get_by_role("row", name=re.compile("^Hal ")), page.locator(".questions")
    for answer in ("Leave it", "Revoke"):
        assert directory.has_good_key(hal)
        await row.get_by_role("button", name="Take rights away").click()
        await row.get_by_role("button", name="Take every right of Hal").click()
        await expect(page.locator(".known .said")).to_have_class("said warn")
        await expect(questions).to_contain_text("Hal")
        await questions.get_by_role("button", name=answer).click()
        await expect(questions.get_by_role("button")).to_have_count(0)
    await place.until(lambda: not directory.has_good_key(hal))
    await expect(questions.locator(".said")).not_to_have_text("")
    await there.go("fleet")
    await expect(page.locator("#h-busy")).to_be_visible()
    await expect(questions).to_have_count(0)  # what came of it stands where it was done


async def test_who_looks_after_nobody_reads_why(site: Site, browser: Browser) -> None:
    async with opened(browser, site.place, DESK) as there:
        await there.sign_in("Bo")
        await there.go("people")
        await expect(there.page.locator(".known")).to_contain_text("whoever looks after people")
        await expect(there.page.get_by_role("form", name="Give a right")).to_have_count(0)


async def test_an_alarm_shows_on_the_tab_and_is_seen(site: Site) -> None:
    _, there = site
    page = there.page
    await there.go("alerts")
    alarm = page.locator(".alert")
    await expect(alarm).to_contain_text("7", timeout=60_000 * patience())
    await there.fits("alerts")
    await alarm.get_by_role("button", name="I have seen it").click()
    await expect(alarm).to_contain_text("seen by Ada")
    DRAINED.clear()


async def test_a_file_is_saved_as_it_is_and_deleted_once_one_is_sure(site: Site) -> None:
    _, there = site
    page = there.page
    await there.go("files")
    await expect(page.get_by_text("You keep no files here yet.")).to_be_visible()
    content = {"name": "notes.txt", "mimeType": "text/plain", "buffer": b"one two three"}
    await page.locator("input[type=file]").set_input_files(content)  # type: ignore[arg-type]
    await expect(page.get_by_text("notes.txt is kept.")).to_be_visible()
    row = page.get_by_role("row", name=re.compile("notes.txt"))
    await expect(row).to_contain_text("13 B")
    async with page.expect_download() as download:
        await row.get_by_role("link", name="Save notes.txt").click()
    saved = await (await download.value).path()
    assert saved.read_bytes() == b"one two three"
    await there.fits("files")
    await row.get_by_role("button", name="Delete notes.txt").click()
    await row.get_by_role("button", name="Delete it for good").click()
    await expect(page.get_by_text("notes.txt is deleted, for good.")).to_be_visible()
    await expect(row).to_have_count(0)


async def test_the_past_is_searched_and_saved(site: Site) -> None:
    place, there = site
    page = there.page
    ada = await place.person("Ada")
    for angle in (10, 20):
        body = {"skill": "turn", "arguments": {"angle": angle}, "wait_s": 30}
        await ada.post("/v1/robots/omni/orders", json=body)
    await ada.post("/v1/robots/kuka1/orders", json={"skill": "grasp", "arguments": {"force": 900}})
    await there.go("history")
    rows = page.locator("table.stacked tbody tr")
    await expect(rows.first).to_be_visible()
    before = await rows.count()
    await page.get_by_label("Search").fill("turn")
    await expect(rows).to_have_count(2)
    assert before > 2
    await expect(page.get_by_text("2 found")).to_be_visible()
    async with page.expect_download() as download:
        await page.get_by_role("link", name="Save as a table").click()
    text = (await (await download.value).path()).read_text()
    assert text.splitlines()[0].startswith("at,who,kind,robot,skill")
    assert text.count(",omni,turn,") == 2
    await page.get_by_label("Search").fill("")
    await there.fits("history")


async def test_somebody_is_invited_by_a_code_that_is_shown_once_and_taken_back(site: Site) -> None:
    place, there = site
    page = there.page
    await there.go("people")
    form = page.get_by_role("form", name="Invite somebody")
    await form.get_by_role("textbox", name="Role").fill("viewer")
    await form.get_by_role("textbox", name="Name").fill("Eve")
    await form.get_by_role("button", name="Invite").click()
    made = page.get_by_role("group", name="The new invitation")
    await expect(made.get_by_role("img")).to_be_visible()
    wide = await made.get_by_role("img").evaluate("picture => picture.naturalWidth")
    assert wide > 100
    code = await made.locator(".code").inner_text()
    await there.fits("invite")
    await made.get_by_role("button", name="I have it").click()
    open_ones = page.get_by_role("list", name="Open invitations")
    await expect(open_ones).to_contain_text("viewer")
    assert len(place.gateway.access.enrolment.invitations.open()) == 1
    assert code.replace("-", "") not in await page.content()
    await open_ones.get_by_role("button", name="Take it back").click()
    await expect(open_ones).to_have_count(0)
    assert place.gateway.access.enrolment.invitations.open() == ()


async def test_a_request_is_allowed(site: Site) -> None:
    place, there = site
    page = there.page
    vi = await place.person("Vi")
    body = {"robot": "kuka1", "right": "grasp", "minutes": 30}
    asked = await vi.post("/v1/access-requests", json=body)
    assert asked.status_code == 201, asked.text
    await there.go("live")
    await there.go("people")
    waiting = page.locator(".requests li", has_text="Vi")
    await expect(waiting).to_contain_text("asks for a right")
    await there.fits("requests")
    await waiting.get_by_role("button", name="Allow Vi").click()
    await expect(waiting).to_have_count(0)
    skills = (await vi.get("/v1/robots/kuka1/skills")).json()
    assert "grasp" in {skill["id"] for skill in skills}


async def test_a_task_is_given_held_and_ended(site: Site) -> None:
    _, there = site
    page = there.page
    await there.go("fleet")
    await expect(page.get_by_text("No task is open.")).to_be_visible()
    form = page.get_by_role("form", name="Give a task")
    await form.get_by_role("combobox", name="For").select_option("omni")
    await form.get_by_role("textbox").fill("move 3 m forward\nturn 20")
    await form.get_by_role("button", name="Give the task").click()
    task = page.locator("section li", has_text="of 2 steps").first
    await expect(task).to_be_visible()
    busy = page.get_by_role("region", name="How busy robots were").get_by_role("row")
    await expect(busy.filter(has_text="omni").get_by_role("meter", name="today")).to_be_visible()
    await there.fits("fleet")
    await task.get_by_role("button", name="Hold: task").click()
    await expect(task).to_contain_text("held")
    await task.get_by_role("button", name="End: task").click()
    await expect(task).to_have_count(0)


async def test_what_the_doctor_finds_is_shown(site: Site) -> None:
    there = site.there
    await there.go("health")
    findings = there.page.locator(".findings li")
    await expect(findings.filter(has_text="omni").first).to_be_visible()
    assert await findings.count() > 1
    figures = there.page.get_by_role("region", name="What is measured").get_by_role("row")
    await expect(figures.filter(has_text="rosic_robot_up")).to_be_visible()
    assert await figures.count() > 10
    await there.fits("health")


async def test_a_typed_address_that_is_none_shows_the_first_tab(site: Site) -> None:
    there = site.there
    for address in ("constructor", "times/%E0%A4%A", "drive/nobody"):
        await there.go(address)
        await expect(there.page.locator("main section").first).to_be_visible()


async def test_a_passkey_signs_in_instead_of_a_code(browser: Browser) -> None:
    settings = ApiSettings(listen=ANYWHERE, url="http://localhost:1")
    async with served(settings) as probe:
        port = probe.server.port
    named = ApiSettings(listen=HostPort("127.0.0.1", port), url=f"http://localhost:{port}")
    async with (
        served(named) as place,
        opened(browser, place, DESK, url=f"http://localhost:{port}") as there,
    ):
        page = there.page
        cdp = await page.context.new_cdp_session(page)
        await cdp.send("WebAuthn.enable")
        options = {
            "protocol": "ctap2",
            "transport": "internal",
            "hasResidentKey": True,
            "hasUserVerification": True,
            "isUserVerified": True,
            "automaticPresenceSimulation": True,
        }
        await cdp.send("WebAuthn.addVirtualAuthenticator", {"options": options})
        await there.sign_in()
        await there.go("people")
        await page.get_by_label("What to call it").fill("Laptop")
        await page.get_by_role("button", name="Make a passkey").click()
        await expect(page.get_by_text("From now on Laptop signs you in here.")).to_be_visible()
        await there.go("alerts")
        await expect(page.get_by_text("Nothing is wrong, as far as is measured.")).to_be_visible()
        await page.get_by_role("button", name="Sign out").click()
        await page.get_by_role("button", name="Sign in with a passkey").click()
        await there.connected()
        await expect(page.locator(".me")).to_contain_text("Ada")
        await expect(page.locator(".top-notice")).to_have_count(0)
        await there.go("people")
        await page.get_by_role("button", name="Remove Laptop").click()
        await expect(page.get_by_text("Laptop signs nobody in any more.")).to_be_visible()
        await page.get_by_role("button", name="Sign out").click()
        await page.get_by_role("button", name="Sign in with a passkey").click()
        await expect(page.get_by_role("alert")).not_to_be_empty()
