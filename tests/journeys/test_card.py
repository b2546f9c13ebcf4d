"""The live card within Telegram's limits: it follows a motion, and goes on after a kill."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from rosic.features.dashboard.dashboard import PRIVATE
from rosic.features.dashboard.dashboards import LOOK_S
from rosic.testing.telegram.newcomer import BOT
from rosic.testing.telegram.transcript import TranscriptView, transcript
from tests.journeys.lab import Lab, lab
from tests.journeys.pictures import check_picture
from tests.pace import patience

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

OMNI = ('[[robot]]\nprofile = "omni"\nlink = "simulated"',)
STAMP = re.compile(r"updated (\d\d):(\d\d):(\d\d), next by (\d\d):(\d\d):(\d\d)")
DAY_S = 86_400
# From looking to the server's record of it, on a busy machine; and a stamp has whole seconds.
ON_ITS_WAY_S = 3.0

PICTURED = re.compile(r"picture of omni: \d\d:\d\d:\d\d, renewed until \d\d:\d\d:\d\d\nupdated ")


def stamps(text: str) -> tuple[int, int]:
    """Return when a card says it was so, and by when it will say something new; of the day."""
    found = STAMP.search(text)
    assert found is not None, text
    numbers = [int(number) for number in found.groups()]
    return tuple(h * 3600 + m * 60 + s for h, m, s in (numbers[:3], numbers[3:]))  # type: ignore[return-value]


async def card(place: Lab, chat: int) -> dict[str, Any]:
    """Return the one card of a chat, with every form it had."""
    shown = await place.control.messages(chat, by_bot=True)
    [found] = [one for one in shown if STAMP.search(one["text"] or "")]
    return await place.control.message(chat, found["message_id"])


async def says(place: Lab, chat: int, text: str) -> dict[str, Any]:
    """Wait until the card says something; return it."""

    async def look() -> dict[str, Any] | None:
        found = await card(place, chat)
        return found if text in found["text"] else None

    found: dict[str, Any] | None = await place.until(look)
    assert found is not None, f"never {text!r}: {(await card(place, chat))['text']}"
    return found


def check_forms(forms: list[dict[str, Any]]) -> None:
    """See that a card was edited seldom, and that each form was true when it arrived."""
    times = [form["received_s"] for form in forms]
    gaps = [later - sooner for sooner, later in pairwise(times)]
    slow = patience()
    assert all(gap >= PRIVATE.between_s - 0.5 * slow for gap in gaps), gaps
    for form in forms:
        stamp_s, next_s = stamps(form["text"])
        assert 0 <= (form["received_s"] - stamp_s) % DAY_S <= ON_ITS_WAY_S * slow + 1
        assert (next_s - stamp_s) % DAY_S >= PRIVATE.promise_s


async def test_it_follows_a_motion_and_goes_on_after_a_kill(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher, robots=OMNI, options=("--no-privacy",)) as place:
        gateway = await place.start()
        await place.say(place.bo, "/card pin omni")
        await place.reads(place.bo, "omni: free")
        first = await card(place, place.bo)
        life = await place.ask(place.bo, "omni move 2 m", "done ")
        done = await says(place, place.bo, "now: done")
        life = await place.control.message(place.bo, life["message_id"])

        forms = done["versions"]
        late_s = forms[-1]["received_s"] - life["versions"][-1]["received_s"]
        assert late_s <= PRIVATE.between_s + LOOK_S + ON_ITS_WAY_S * patience()
        check_forms(forms)
        assert any("sent " in form["text"] and "%" in form["text"] for form in forms[1:-1]), forms
        assert any("omni: Bo · " in form["text"] for form in forms)
        await pinned_quietly(place, done)
        draw(await place.control.messages(place.bo), place.bo)

        gateway.kill()
        await place.start()
        again = await newer(place, len(forms))
        assert again["message_id"] == first["message_id"]
        assert again["pinned"]
        await place.ask(place.bo, "omni move 0.2 m back", "done ")
        await says(place, place.bo, "  received ")
        check_forms((await card(place, place.bo))["versions"][len(forms) :])

        await place.ask(place.bo, "/card off", "The card has ended.")
        await place.reads(place.bo, "This card has ended.")
        calls = await place.control.calls()
        assert not [call for call in calls if call["code"] == 429]
        assert await place.control.violations() == []


async def test_it_shows_the_last_picture_in_place(tmp_path: Path, launcher: Launcher) -> None:
    async with lab(tmp_path, launcher, robots=OMNI) as place:
        gateway = await place.start()
        await place.say(place.bo, "/card omni")
        await place.reads(place.bo, "omni: free")
        shown = await card(place, place.bo)
        assert [[b["text"] for b in row] for row in shown["buttons"]] == [["Picture"], ["STOP"]]
        pictured = shown
        for tap in (True, True, False):  # while somebody looks, the next one comes by itself
            before = len((await card(place, place.bo))["versions"])
            if tap:
                await place.control.tap(place.bo, place.bo, shown["message_id"], "Picture")
            pictured = await newer_picture(place, before)
        assert PICTURED.search(pictured["text"])
        assert pictured["message_id"] == shown["message_id"]
        assert len(await place.control.messages(place.bo, by_bot=True)) == 1
        assert {v["photo"][0]["file_id"] for v in pictured["versions"] if v["photo"]}

        gateway.kill()
        await place.start()
        again = await newer(place, len(pictured["versions"]))
        assert again["photo"] == pictured["photo"], "an edit of the words leaves the picture"
        assert "picture of omni: " in again["text"]
        edits = [c for c in await place.control.calls() if c["method"] == "editMessageMedia"]
        assert {c["code"] for c in edits} == {200}
        assert await place.control.violations() == []


async def newer_picture(place: Lab, than: int) -> dict[str, Any]:
    """Wait until the card shows another picture than before."""

    async def look() -> dict[str, Any] | None:
        found = await card(place, place.bo)
        earlier = [v["photo"] for v in found["versions"][:than]]
        return found if found["photo"] and found["photo"] not in earlier else None

    found: dict[str, Any] | None = await place.until(look, 30.0)
    assert found is not None, "no picture on the card"
    return found


async def newer(place: Lab, than: int) -> dict[str, Any]:
    """Wait for one more form of the card."""

    async def look() -> dict[str, Any] | None:
        found = await card(place, place.bo)
        return found if len(found["versions"]) > than else None

    found: dict[str, Any] | None = await place.until(look)
    assert found is not None, "after a restart the card stays as it was"
    return found


async def pinned_quietly(place: Lab, shown: dict[str, Any]) -> None:
    """See that it is pinned, once, and that nobody's phone rang."""
    pins = [c for c in await place.control.calls() if c["method"] == "pinChatMessage"]
    assert [pin["parameters"]["disable_notification"] for pin in pins] == ["true"]
    assert shown["pinned"]


def draw(messages: list[dict[str, Any]], reader: int) -> None:
    """Compare what the phone shows now, without what the card said before, with the picture."""
    now = [
        one | {"versions": one["versions"][-1:]} if STAMP.search(one["text"] or "") else one
        for one in messages
    ]
    check_picture(
        "card", transcript(now, [], TranscriptView(title=BOT, reader=reader, below="bot"))
    )
