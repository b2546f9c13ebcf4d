"""While somebody looks at the picture on a live card it is renewed by itself, and bearably so."""

from __future__ import annotations

import asyncio
import re
from itertools import pairwise
from typing import TYPE_CHECKING

from rosic.core.message import ChatKind
from rosic.core.robot.view import ViewKind
from rosic.features.dashboard.dashboard import LOOKING_S, PRIVATE, RENEWED_S
from rosic.features.media import MediaFeature
from rosic.stores.memory import MemoryStore
from tests.features.dashboard.test_camera_preview import (
    Pictures,
    begins,
    button,
    opened,
    put,
    until,
)
from tests.features.media.media_gateway import FRAME, Booth, Sketcher, booth
from tests.gateway.place import ADA, BO

if TYPE_CHECKING:
    from rosic.messengers.memory import ShownMessage

RENEWED = re.compile(r"\npicture of The omni: 12:00:00, renewed until 12:00:00\nupdated ")


async def pass_s(place: Booth, seconds: float) -> list[float]:
    """Let time pass, a second at a time; return after how long the card showed another picture."""
    shown_s: list[float] = []
    for second in range(1, int(seconds) + 1):
        before = len(put(place))
        await place.clock.advance(1.0)
        await place.quiet()
        for _ in range(30_000):  # a thread draws it
            if place.gateway.features.get(MediaFeature).render_queue.quiet:
                break
            await asyncio.sleep(0.001)
        await place.quiet()
        shown_s += [float(second)] * (len(put(place)) - before)
    return shown_s


async def looks(place: Booth, card: str, account: str = ADA) -> None:
    """Tap for a picture, and see it."""
    before = len(put(place))
    await place.tap(button(place, card, "Picture"), card, account)
    await until(place, lambda: len(put(place)) > before)


def edits(place: Booth, card: str) -> list[ShownMessage]:
    return [told for told in place.chat.told if told.message == card and told.edited]


async def test_after_a_tap_newer_ones_come_by_themselves_for_a_while() -> None:
    async with opened() as place:
        card = await begins(place, "/card omni")
        assert await pass_s(place, 60) == [], "nobody has looked yet"
        await looks(place, card)
        assert RENEWED.search(place.chat.shown(card).text)
        came_s = await pass_s(place, LOOKING_S + 5)
        every_s = RENEWED_S[ChatKind.PRIVATE]
        assert len(came_s) in range(12, int(LOOKING_S / every_s) + 1)
        gaps = [later - sooner for sooner, later in pairwise(came_s)]
        assert min(gaps) >= every_s - 1
        assert await pass_s(place, 60) == [], "nobody looks any more"
        assert "picture of The omni: 12:00:00\nupdated " in place.chat.shown(card).text
        assert len(set(put(place))) == 1, "one message all the time"
        await looks(place, card)
        assert len(await pass_s(place, 40)) in {3, 4}, "another tap, another while"


async def test_it_goes_with_the_edits_of_the_card_never_closer_than_those() -> None:
    async with opened() as place:
        card = await begins(place, "/card omni")
        await looks(place, card)
        await pass_s(place, 5)
        place.robot("omni").work_s = 200.0
        await place.say("omni move 1 m")
        before, begun_ns = len(edits(place, card)), place.clock.monotonic_ns()
        for percent in range(80, 20, -1):  # something new each second
            place.robot("omni").values["battery"] = float(percent)
            await pass_s(place, 1)
        past_s = (place.clock.monotonic_ns() - begun_ns) / 1e9
        made = len(edits(place, card)) - before
        assert len(put(place)) >= 5
        assert made <= past_s / PRIVATE.between_s + 2, "pictures cost no edits of their own"


async def test_in_a_group_they_come_more_seldom() -> None:
    async with opened() as place:
        card = await begins(place, "/card omni", chat="-7", kind=ChatKind.GROUP)
        pressed = button(place, card, "Picture")
        place.chat.tap(pressed, under=card, account=ADA)
        await until(place, lambda: put(place))
        came_s = await pass_s(place, LOOKING_S)
        assert len(came_s) in range(3, int(LOOKING_S / RENEWED_S[ChatKind.GROUP]) + 1)


async def test_one_that_cannot_be_had_is_not_talked_of_and_the_next_is_tried() -> None:
    async with opened() as place:
        card = await begins(place, "/card omni")
        await looks(place, card)
        place.robot("omni").shows.clear()
        told = [one for one in place.chat.told if not one.edited]
        assert await pass_s(place, 40) == []
        assert [one for one in place.chat.told if not one.edited] == told, "nobody asked for them"
        place.robot("omni").shows[ViewKind.PICTURE] = FRAME
        assert len(await pass_s(place, 15)) == 1


async def test_whoever_asks_comes_first_and_has_as_many_as_ever() -> None:
    async with opened() as place:
        card = await begins(place, "/card omni")
        await looks(place, card)
        await pass_s(place, LOOKING_S)
        for _ in range(5):
            before = len(place.renderer.drawn)
            await place.say("picture cf1")
            await until(place, lambda so=before: len(place.renderer.drawn) > so)  # type: ignore[misc]
        await looks(place, card)
        place.renderer.wait.clear()
        try:
            for line in ("picture cf1", "chart omni battery"):
                await place.say(line, account=BO, chat=BO)
            for _ in range(30):
                await place.clock.advance(1.0)
                await place.quiet()
            assert len(place.gateway.features.get(MediaFeature).render_queue._tasks) == 2, (
                "half of the places are left"
            )
        finally:
            place.renderer.wait.set()


async def test_after_a_restart_nobody_is_taken_to_look() -> None:
    store = MemoryStore()
    async with opened(store=store) as first:
        card = await begins(first, "/card omni")
        await looks(first, card)
    second = booth(Sketcher(), store=store)
    second.chat.__class__ = Pictures
    second.chat._shown, second.chat._serial = first.chat._shown, 100
    async with second.open():
        second.prepare()
        assert await pass_s(second, 60) == []
        text = second.chat.shown(card).text
        assert "picture of The omni: 12:00:00\n" in text
        assert second.renderer.drawn == []


async def test_with_the_card_it_ends() -> None:
    async with opened() as place:
        card = await begins(place, "/card omni")
        await looks(place, card)
        await place.say("/card off")
        drawn = len(place.renderer.drawn)
        assert await pass_s(place, 60) == []
        assert len(place.renderer.drawn) == drawn, "and nobody looks through the camera"
