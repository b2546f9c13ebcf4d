"""In a browser: whoever reads German reads German on every tab, where there is a word for it."""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta
from functools import cache
from typing import TYPE_CHECKING, Final

import pytest
from playwright.async_api import expect

from rosic.app.demo import fleet
from rosic.config.plugins import catalogue
from rosic.core.robot.profile import RobotId
from tests.api.served import served
from tests.console.browser import DESK, PHONE, opened
from tests.console.robots import DRAINED, SILENT, noting
from tests.texts import templates

if TYPE_CHECKING:
    from collections.abc import Iterator

    from playwright.async_api import Browser

    from tests.api.served import ServedGateway
    from tests.console.browser import OpenPage

pytestmark = pytest.mark.limit(300)
FIELD: Final = re.compile(r"\\\{[^}]*\\\}")
LETTERS_LEAST: Final = 5
"""A template with fewer of its own says too little to be recognised beside what fills it."""
SIZES: Final = (PHONE, {"width": 1280, "height": 800}, {"width": 1920, "height": 1080}, DESK)
TABS: Final = {
    "live": ".view img",
    "drive/omni": "form.skill",
    "drive/cf1": "form.skill",
    "drive/kuka1": "form.skill",
    "times/kuka1": ".booked.own",
    "people": ".requests li",
    "fleet": ".busy tbody tr",
    "alerts": ".alert",
    "files": ".stacked tbody tr",
    "history": ".stacked tbody tr",
    "health": ".figures tbody tr",
}
"""Every tab, and what stands there once all of it has come."""
SHOWN: Final = """() => {
  for (const each of document.querySelectorAll("details")) each.open = true;
  const found = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const { parentElement, textContent } = walk.currentNode;
    if (!parentElement.closest("script, noscript, .own .text")) found.push(textContent);
  }
  for (const name of ["aria-label", "alt", "placeholder", "title"]) {
    for (const each of document.querySelectorAll(`[${name}]`)) found.push(each.getAttribute(name));
  }
  return [...new Set(found.flatMap((text) => text.split("\\n")).map((text) => text.trim()))];
}"""
"""Whatever is read or read aloud there, but for what the reader wrote."""


def _titles() -> Iterator[str]:
    for profile in fleet():
        for skill in profile.skills.values():
            titled = [(skill.title, skill.titles)]
            titled += [(each.title, each.titles) for each in skill.parameters.values()]
            yield from (title for title, others in titled if others.get("de", title) != title)


@cache
def english() -> tuple[frozenset[str], tuple[re.Pattern[str], ...]]:
    """Return whatever has another text in German: as it stands, and with fields."""
    german = catalogue("de")
    assert german is not None
    said = [one for form in templates() for one in (form if isinstance(form, tuple) else (form,))]
    other = [text for text in said if german.gettext(text) != text]
    forms = [re.escape(text) for text in other if "{" in text]
    return frozenset((*(text for text in other if "{" not in text), *_titles())), tuple(
        re.compile(FIELD.sub(".+", form), re.DOTALL)
        for form in forms
        if len(re.findall("[a-z]", FIELD.sub("", form))) >= LETTERS_LEAST
    )


def left_in_english(texts: list[str]) -> list[str]:
    words, forms = english()
    return [t for t in texts if t.strip(" :·") in words or any(form.fullmatch(t) for form in forms)]


async def content(place: ServedGateway) -> None:
    """Have something on every tab."""
    ada, bo, vi = [await place.person(name) for name in ("Ada", "Bo", "Vi")]
    await ada.post("/v1/chat", json={"text": "/language de"})
    day = (datetime.now(UTC) + timedelta(days=1)).replace(hour=9, minute=0, second=0, microsecond=0)
    if day.weekday() == 0:  # of the week that is shown
        day -= timedelta(days=1)
    booking = {"robot": "kuka1", "start": day.replace(hour=23).isoformat(), "minutes": 30}
    assert (await ada.post("/v1/bookings", json=booking)).status_code == 201
    file = {"Content-Type": "application/octet-stream"}
    assert (await ada.post("/v1/files?name=a.txt", content=b"a", headers=file)).is_success
    asked = {"robot": "yumi", "right": "home", "minutes": 30}
    assert (await vi.post("/v1/access-requests", json=asked)).status_code == 201
    assert (await ada.post("/v1/invitations", json={"rights": "viewer"})).status_code == 201
    await ada.post("/v1/tasks", json={"on": "omni", "steps": ["move 5 m forward"]})
    SILENT.add("cf2")
    for line in ("cf2 takeoff 1 m", "kuka1 grasp force=20", "omni arm carry", "kuka1 move joint"):
        await ada.post("/v1/chat", json={"text": line, "wait_s": 0})
    await bo.post("/v1/robots/kuka1/queue", json={})
    await ada.post("/v1/chat", json={"text": "/grant Bo admin", "wait_s": 1})


async def shown(there: OpenPage, tab: str) -> list[str]:
    await there.go(tab)
    await expect(there.page.locator(TABS[tab]).first).to_be_visible()
    await expect(there.page.locator("main")).not_to_contain_text("Einen Moment")
    found: list[str] = await there.page.evaluate(SHOWN)
    return found


@pytest.mark.asyncio(loop_scope="module")
async def test_every_tab_speaks_german_and_has_room_for_its_longer_words(browser: Browser) -> None:
    DRAINED.add("omni")
    async with served(robots_of=noting) as place:
        await content(place)
        alerts = place.gateway.kernel.shared.alerts.find()
        assert alerts is not None
        await place.until(lambda: alerts.open_now({RobotId("omni")}))
        async with opened(browser, place, DESK, locale="de-DE") as there:
            await there.page.goto(f"{place.url}/#code={place.code('Ada')}")
            await expect(there.page.get_by_text("Gateway verbunden")).to_be_visible()
            for tab in TABS:
                assert left_in_english(await shown(there, tab)) == [], tab
                for size in SIZES:
                    assert await there.sticking_out(size) == [], (tab, size)
            told = " ".join(await shown(there, "drive/omni"))
            assert "Grundstellung" in told
            assert "carry" not in told


def test_what_is_left_in_english_is_found() -> None:
    texts = ["Held by", "Bei:", "2 found", "omni", "Off straight behind, to its left", "Name"]
    assert left_in_english(texts) == ["Held by", "2 found", "Off straight behind, to its left"]
