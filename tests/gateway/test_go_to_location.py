"""A location asks whether a robot is to go there, and moves nothing by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.message import Chat, ChatKind, GeoPoint, MessageValidity
from rosic.core.robot.geography import GeographicFrame
from rosic.core.robot.skill import Parameter, Skill
from rosic.gateway.unverified_messages import MAY_LOOK
from tests.gateway.place import ADA, BO, FLEET, VI, Place

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile

HERE = GeographicFrame(latitude=47.0, longitude=15.0)
METRES = Parameter(unit="m", min=-100, max=100)
GOTO = Skill(id="goto", title="Go to a place", parameters={"x": METRES, "y": METRES})
NORTH = GeoPoint(47.0005, 15.0)  # 55.6 m
NOT_OWN = [s for s in MessageValidity if s.value not in {"fresh", "unverified"}]


def located(profile: Profile) -> Profile:
    return replace(profile, frame=HERE, go_to="goto x y", skills={**profile.skills, "goto": GOTO})


ONE = (located(FLEET[0]), *FLEET[1:])
TWO = (located(FLEET[0]), located(FLEET[1]), *FLEET[2:])


async def send(
    place: Place,
    spot: GeoPoint = NORTH,
    *,
    account: str = ADA,
    kind: ChatKind = ChatKind.PRIVATE,
    standing: MessageValidity = MessageValidity.FRESH,
    answers: str = "",
) -> str:
    before = len(place.chat.told)
    chat = Chat("memory", account if kind is ChatKind.PRIVATE else "g", kind)
    inbound = place.chat._inbound(account, chat, None, None)
    reply = {"answers": answers, "answers_us": answers.startswith("ours-")}
    place.chat.deliver(replace(inbound, place=spot, standing=standing, **reply))
    await place.quiet()
    return "\n".join(told.outbound.text for told in list(place.chat.told)[before:])


async def test_a_place_asks_and_a_tap_goes() -> None:
    async with Place(fleet=ONE).open() as place:
        assert await send(place) == "omni: go to 55.6 m, 0.0 m?"
        assert place.acted() == 0
        button, under = place.button("Do it")
        await place.tap(button, under)
        assert place.acted() == 1
        assert "omni: goto, x 55.59 m, y 0.00 m" in place.last()[1].text


@pytest.mark.parametrize("standing", NOT_OWN)
async def test_what_is_not_somebodys_own_asks_nothing(standing: MessageValidity) -> None:
    async with Place(fleet=ONE).open() as place:
        assert await send(place, standing=standing) == ""


async def test_what_somebody_else_may_have_sent_asks_nothing_and_its_author_is_told() -> None:
    async with Place(fleet=ONE).open() as place:
        assert await send(place, standing=MessageValidity.UNVERIFIED) == MAY_LOOK
        assert not place.last()[1].buttons


async def test_a_group_asks_nothing() -> None:
    async with Place(fleet=ONE).open() as place:
        assert await send(place, kind=ChatKind.GROUP) == ""


async def test_what_is_out_of_bounds_is_refused() -> None:
    async with Place(fleet=ONE).open() as place:
        said = await send(place, GeoPoint(47.002, 15.0))
        assert "222.3 m, 0.0 m" in said
        assert "goes from -100 m to 100 m" in said
        assert "more than 10 km" in await send(place, GeoPoint(48.0, 15.0))
        with pytest.raises(AssertionError):
            place.button("Do it")


async def test_whoever_may_not_send_it_asks_nothing() -> None:
    async with Place(fleet=ONE).open() as place:
        assert "No robot that you may send" in await send(place, account=VI)


async def test_of_several_the_chosen_one_goes() -> None:
    async with Place(fleet=TWO).open() as place:
        assert "Several robots can go there" in await send(place, account=BO)
        await place.say("use kuka1", account=BO, chat=BO)
        assert "kuka1: go to" in await send(place, account=BO)
        await place.say("use cf1", account=BO, chat=BO)
        assert "cf1 cannot be sent" in await send(place, account=BO)


async def test_in_reply_to_what_a_robot_did_that_one_goes() -> None:
    async with Place(fleet=TWO).open() as place:
        await place.say("kuka1 wave", account=BO, chat=BO)
        told, _ = place.last()
        await place.say("use omni", account=BO, chat=BO)
        assert "omni: go to" in await send(place, account=BO)
        assert "kuka1: go to" in await send(place, account=BO, answers=told)
        assert "omni: go to" in await send(place, account=BO, answers="m-of-nobody")
        forgotten = await send(place, account=BO, answers="ours-forgotten")
        assert "Several robots can go there" in forgotten
