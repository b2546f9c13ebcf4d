"""I17: what nobody can be sure of may look and stop; it changes nothing, not even a choice."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.language import hears_cancel
from rosic.core.message import Chat, ChatKind, GeoPoint, MessageValidity
from rosic.core.policy.roles import DEFAULT_ROLES, Assurance, RoleRules, SkillPrecondition
from rosic.core.rate_limit import RateLimit
from rosic.errors import Unverified
from rosic.gateway.unverified_messages import MAY_LOOK
from tests.gateway.place import ADA, Place
from tests.gateway.test_linked_accounts import BO_TOO, TwoMessengers, heard_of

if TYPE_CHECKING:
    from rosic.core.message import Inbound

UNVERIFIED = MessageValidity.UNVERIFIED
REMEDY = "Say: /verify"


async def unsure(place: Place, text: str, **more: object) -> str:
    """Say something in Ada's name that somebody else may have written; return what was told."""
    return await place.say(text, standing=UNVERIFIED, **more)


def heard(lab: Place, text: str, **more: object) -> Inbound:
    """Return what a messenger delivers that tells of each message what it is worth."""
    inbound = lab.chat._inbound(ADA, Chat("memory", ADA), None, None)
    return replace(inbound, text=text, **more)


async def test_it_may_look() -> None:
    async with Place().open() as place:
        assert "omni" in await unsure(place, "status")
        assert "omni" in await unsure(place, "robots")
        assert await unsure(place, "help")
        assert "Ada" in await unsure(place, "/me")
        await unsure(place, "omni look")
        assert place.acted() == 1


@pytest.mark.parametrize(
    "text",
    [
        "omni move 1 m",
        "status\nomni move 1 m",
        "use omni",
        "resume omni",
        "/lock Bo",
        "/invite viewer",
        "again",
        "/start omni",
        "take over omni",
    ],
)
async def test_it_changes_nothing(text: str) -> None:
    async with Place().open() as place:
        assert MAY_LOOK in await unsure(place, text)
        assert place.acted() == 0
        assert place.gateway.rooms.container.selected("ada", heard(place, "").chat) == ""


async def test_every_command_is_refused_that_is_not_known_to_show_only() -> None:
    async with Place().open() as place:
        commands = place.gateway.rooms.vocabulary.commands
        for name in sorted(commands.words):
            command = commands.find(name)
            if command is None or hears_cancel(f"/{name} omni") is not None:
                continue  # whoever ends what moves is as welcome as whoever stops it
            told = await unsure(place, f"/{name} omni")
            assert (MAY_LOOK in told) is not command.observes, (name, told)


async def test_its_author_reads_what_to_do() -> None:
    async with Place().open() as place:
        inbound = heard(place, "omni move 1 m", standing=UNVERIFIED, remedy=REMEDY)
        place.chat.deliver(inbound)
        await place.quiet()
        outbound = place.last()[1]
        assert outbound.text == f"{MAY_LOOK} {REMEDY}"
        assert outbound.code == Unverified.code


async def test_it_stops() -> None:
    async with Place().open() as place:
        await unsure(place, "stop omni")
        assert place.robot("omni").gate.latched


async def test_a_tap_that_nobody_is_sure_of_leaves_the_button_good() -> None:
    async with Place().open() as place:
        await place.say("omni mvoe 1 m")
        button, under = place.button("omni move 1 m")
        tap = {"nonce": button.nonce, "tap": "t", "under": under, "standing": UNVERIFIED}
        place.chat.deliver(heard(place, "", **tap))
        await place.quiet()
        assert MAY_LOOK in place.last()[1].text
        assert place.acted() == 0

        await place.tap(button, under)
        assert place.acted() == 1


async def test_a_file_and_a_place_are_not_taken() -> None:
    async with Place().open() as place:
        place.chat.enclose("map.pgm", b"P5 1 1 255 \0", standing=UNVERIFIED)
        await place.quiet()
        assert MAY_LOOK in place.last()[1].text
        inbound = heard(place, "", standing=UNVERIFIED, place=GeoPoint(53.0, 8.8))
        place.chat.deliver(inbound)
        await place.quiet()
        assert MAY_LOOK in place.last()[1].text


async def test_people_who_talk_in_a_group_are_left_alone() -> None:
    async with Place().open() as place:
        assert await unsure(place, "good weather", chat="-5", kind=ChatKind.GROUP) == ""
        told = await unsure(place, "omni move 1 m", chat="-5", kind=ChatKind.GROUP)
        assert MAY_LOOK in told


async def test_nobody_is_locked_out_by_what_others_write_in_their_name() -> None:
    async with Place().open() as place:
        for _ in range(100):
            await unsure(place, "kuka1 mvoe 1 m")
            await unsure(place, "omni move 1 m")
        assert MAY_LOOK not in await place.say("omni move 1 m")
        assert place.acted() == 1


class Cautious(Place):
    """A robot here moves only by what came encrypted, from a verified device."""

    rulebook = RoleRules(
        roles=DEFAULT_ROLES,
        care=(SkillPrecondition(scopes=("omni:move",), assurance="e2ee-verified"),),
    )


@pytest.mark.parametrize("assurance", list(Assurance))
async def test_each_message_is_worth_what_its_messenger_says_of_it(assurance: Assurance) -> None:
    async with Cautious().open() as place:
        place.chat.deliver(heard(place, "omni move 1 m", assurance=assurance))
        await place.quiet()
        enough = assurance >= Assurance.E2EE_VERIFIED
        assert place.acted() == enough
        told = place.last()[1].text
        assert ("keys" in told) is not enough
        assert ("/verify" in told) is (assurance is Assurance.E2EE_UNVERIFIED), "it helps there"

        place.chat.deliver(heard(place, "stop omni", assurance=assurance))
        await place.quiet()
        assert place.robot("omni").gate.latched


async def test_nothing_is_learnt_from_it_of_whom_it_names() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m")
        moved = place.acted()
        followers = place.gateway.pipeline.followers
        before = [chat.id for _, chat in followers.of("omni")]

        for number in range(20):
            await unsure(place, "omni look", chat=f"made up {number}")

        assert [chat.id for _, chat in followers.of("omni")] == before
        looked = place.acted()
        assert looked > moved
        assert "omni: move" in await place.say("again")


async def test_it_is_counted_apart_from_what_they_say_themselves() -> None:
    async with Place(limit=RateLimit(burst=5, per_s=0.01)).open() as place:
        for _ in range(20):
            await unsure(place, "status")
        assert await unsure(place, "status") == "", "it was answered without end"

        assert "done" in await place.say("omni move 1 m")


async def test_no_notice_follows_it() -> None:
    place = TwoMessengers()
    async with place.open():
        await place.link()
        await place.here("status")
        forged = place.other._inbound(BO_TOO, Chat("other", BO_TOO), None, None)
        place.other.deliver(replace(forged, text="status", standing=UNVERIFIED))
        await place.quiet()

        assert await heard_of(place, "your turn") == ["memory"]
