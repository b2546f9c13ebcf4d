"""The last picture on a live card: whose, of when, in place, and gone with the right to see it."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.message import ChatKind
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.features.dashboard.rendering import CAPTION_UNITS
from rosic.messengers.memory import MemoryMessenger
from rosic.stores.memory import MemoryStore
from tests.features.media.media_gateway import ROBOTS, Booth, Sketcher, booth
from tests.gateway.place import ADA, BO, FLEET

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from rosic.core.message import Button, Chat, Outbound

NARROW = RoleRules(roles={**DEFAULT_ROLES, "narrow": Role(scopes=("kuka1:*",), priority=5)})


class Pictures(MemoryMessenger):
    """A messenger on which a message can be made to show a picture, and be taken away."""

    async def put_picture(self, message: str, outbound: Outbound) -> None:
        assert outbound.attachment is not None
        self.put = [*getattr(self, "put", []), message]
        await self.edit(message, outbound)

    async def retract(self, chat: Chat, message: str) -> None:
        self.retracted = [*getattr(self, "retracted", []), message]
        del chat


@asynccontextmanager
async def opened(**how: object) -> AsyncIterator[Booth]:
    place = booth(Sketcher(), **how)
    place.chat.__class__ = Pictures
    async with place.open():
        place.prepare()
        yield place


async def begins(place: Booth, line: str, account: str = ADA, **how: object) -> str:
    """Ask for a card; return its message."""
    how.setdefault("chat", account)
    await place.say(line, account=account, **how)
    return newest(place)


def newest(place: Booth) -> str:
    """Return the newest message that is a card."""
    return [t for t in place.chat.told if not t.edited and "updated" in t.outbound.text][-1].message


async def until(place: Booth, condition: Callable[[], object]) -> None:
    for _ in range(2_000):
        if condition():
            return
        await place.clock.advance(0.05)
        await asyncio.sleep(0.001)
    raise AssertionError("it did not happen")


def labels(place: Booth, card: str) -> list[str]:
    return [button.label for row in place.chat.shown(card).buttons for button in row]


def button(place: Booth, card: str, label: str) -> Button:
    shown = place.chat.shown(card)
    return next(b for row in shown.buttons for b in row if b.label == label)


def put(place: Booth) -> list[str]:
    found: list[str] = getattr(place.chat, "put", [])
    return found


async def test_a_tap_shows_the_picture_on_the_card_and_says_of_when() -> None:
    async with opened() as place:
        card = await begins(place, "/card omni")
        assert labels(place, card) == ["Picture", "STOP"]
        for times in (1, 2):
            await place.tap(button(place, card, "Picture"), card)
            await until(place, lambda count=times: len(put(place)) == count)  # type: ignore[misc]
        shown = place.chat.shown(card)
        assert "\npicture of The omni: 12:00:00, renewed until 12:00:00\nupdated " in shown.text
        assert [low for _, low in place.renderer.drawn] == [True, True]
        before = len(place.chat.told)
        await place.say("omni wave")
        await until(place, lambda: "sent" in place.chat.shown(card).text)
        assert len(put(place)) == 2, "only a new picture is sent"
        told = [t.outbound for t in list(place.chat.told)[before:] if t.message == card]
        assert all(one.attachment is None for one in told)


async def test_robots_without_a_camera_and_messengers_without_pictures_have_no_button() -> None:
    async with opened() as place:
        card = await begins(place, "/card kuka1")
        assert labels(place, card) == ["STOP"]
        assert "no camera" in await place.say("/card picture kuka1")
        card = await begins(place, "/card")
        assert labels(place, card) == ["Picture of cf1", "Picture of omni", "STOP"]
        assert "There is no robot and no group called" in await place.say("/card picture nobody")
    async with booth(Sketcher()).open() as plain:
        await plain.say("/card omni")
        assert [b.label for row in plain.last()[1].buttons for b in row] == ["STOP"]
    async with booth(None).open() as unpainted:
        unpainted.chat.__class__ = Pictures
        await unpainted.say("/card omni")
        assert [b.label for row in unpainted.last()[1].buttons for b in row] == ["STOP"]


async def test_in_a_group_only_whose_card_it_is_asks_for_a_picture() -> None:
    async with opened() as place:
        card = await begins(place, "/card omni", chat="-7", kind=ChatKind.GROUP)
        pressed = button(place, card, "Picture")
        place.chat.tap(pressed, under=card, account=BO)
        await place.quiet()
        assert place.chat.answers[-1][1] == "This question was asked of somebody else."
        assert place.renderer.drawn == []


async def test_with_the_right_the_picture_goes() -> None:
    place = booth(Sketcher())
    people = tuple(
        replace(one, roles=("narrow",)) if one.name == "Bo" else one
        for one in place.gateway._settings.people
    )
    place.gateway._settings = replace(place.gateway._settings, rulebook=NARROW, people=people)
    place.chat.__class__ = Pictures
    async with place.open():
        place.prepare()
        assert "Bo" in await place.say("/grant Bo operator omni for 10 min")
        card = await begins(place, "/card", account=BO)
        await place.tap(button(place, card, "Picture"), card, BO)
        await until(place, lambda: put(place))
        await place.clock.advance(600.0)
        await until(place, lambda: getattr(place.chat, "retracted", []) == [card])
        await until(place, lambda: newest(place) != card)
        shown = place.chat.shown(newest(place))
        assert "omni" not in shown.text
        assert "kuka1" in shown.text


async def test_beneath_a_picture_the_words_fit_and_over_a_restart_it_is_known() -> None:
    store, many = MemoryStore(), "A robot with a name that is rather long, number "
    fleet = (
        *(replace(one, title=f"{many}{one.id}") for one in ROBOTS),
        *(replace(FLEET[0], id=f"r{n}", title=f"{many}{n}" * 3) for n in range(9)),
    )

    def made() -> Booth:
        place = booth(Sketcher(), store=store)
        place.gateway._settings = replace(place.gateway._settings, profiles=fleet)
        place.chat.__class__ = Pictures
        return place

    first, second = made(), made()
    async with first.open():
        first.prepare()
        card = await begins(first, "/card")
        assert len(first.chat.shown(card).text) > CAPTION_UNITS
        await first.tap(button(first, card, "Picture of omni"), card)
        await until(first, lambda: put(first))
        beneath(first, card)
    second.chat._shown, second.chat._serial = first.chat._shown, 100
    async with second.open():
        await until(second, lambda: second.chat.told)
        beneath(second, card)


def beneath(place: Booth, card: str) -> None:
    """See that a card's words fit under its picture, and say what they leave out."""
    text = place.chat.shown(card).text
    assert len(text) <= CAPTION_UNITS
    assert "more: /card and their names shows them" in text
    assert "picture of " in text
