"""`/role`: roles of the place's own, made, used, changed and taken back in a private chat."""

from __future__ import annotations

import logging

import pytest
from msgspec.structs import replace

from rosic.core.message import ChatKind
from rosic.core.policy.roles import Role
from rosic.core.records import Decided, Fact
from rosic.organiser.grants import ROLE
from rosic.testing.clock import ManualClock
from tests.features.access.access_gateway import ADA, BO, EVE, TIM, VI, House, house
from tests.gateway.place import BrokenStore, WritingStore

GUEST = "/role guest may omni:move omni:wave with omni:move distance <= 1 m"
GIVES = "omni:move, omni:wave with omni:move distance <= 1 m"


async def make(place: House, line: str, account: str = ADA) -> str:
    told = await place.line(account, line)
    assert "?" in told, told
    return await place.press(account, "Make it so")


async def give(place: House, name: str, role: str = "guest") -> None:
    await place.line(ADA, f"/grant {name} {role} for 2h")


def own(place: House) -> dict[str, Role]:
    return dict(place.gateway.authority.rolebook.own)


async def test_a_role_is_made_after_a_tap_counts_with_its_limits_and_is_taken_back() -> None:
    async with house() as place:
        epoch = place.gateway.authority.rights.epoch
        assert await place.line(ADA, GUEST) == f"Make the role guest: {GIVES}? Nobody has it now."
        assert not own(place)
        assert place.gateway.authority.rights.epoch == epoch
        told = await place.press(ADA, "Make it so")
        assert told == f"The role guest gives now: {GIVES}."
        assert place.newest(EVE).text == f"Ada made the role guest: {GIVES}."
        assert place.gateway.rooms.linker.epoch == place.gateway.authority.rights.epoch > epoch
        assert f"guest (made in a chat): {GIVES}" in await place.line(ADA, "/role")
        listed = await place.line(ADA, "/role")
        assert "viewer: read on every robot" in listed
        assert "operator: every robot, everything" in listed
        assert "*" not in listed
        assert await place.line(ADA, "/role guest") == f"guest (made in a chat): {GIVES}"
        await give(place, "Vi")
        await place.line(VI, "omni move 2 m")
        assert place.acted() == 0
        await place.line(VI, "omni move 1 m")
        assert place.acted() == 1
        told = await place.line(ADA, "/role guest off")
        assert told.startswith("The role guest is still held by Vi.")
        await place.press(ADA, "Take it back")
        assert await place.line(ADA, "/role guest off") == "There is no role guest any more."
        assert not own(place)


async def test_whoever_invites_in_a_role_that_is_not_there_is_led_to_making_it() -> None:
    async with house() as place:
        told = await place.line(ADA, "/invite student kuka1")
        said, _, how = told.partition("\nTo make such a role, for example: ")
        assert said.startswith('I know no role and no robot called "student".')
        assert (await place.line(ADA, how)).startswith("Make the role student: ")
        await place.line(ADA, "/invite student kuka1")
        assert (await place.press(ADA, "Make the role student")).startswith("Make the role student")
        assert (await place.press(ADA, "Make it so")).startswith("The role student gives now: ")
        told = await place.line(ADA, "/invite student kuka1")
        assert told.startswith("Invitation as student on kuka1.")
        assert "To make" not in await place.line(ADA, "/invite operator zzzzzzz")


async def test_whose_right_to_give_ends_makes_changes_and_takes_back_no_role() -> None:
    async with house() as place:
        await make(place, GUEST)
        await place.line(ADA, "/grant Bo admin for 1h")
        for line in ("guest may omni:wave", "guest off", "mine may omni:wave"):
            assert await place.line(BO, f"/role {line}") == (
                "A role stays for good, and your own right to give it ends. Ada or Eve can. "
                "Nothing was done."
            )
        assert list(own(place)) == ["guest"]
        assert (await place.line(BO, "/role guest")).startswith("guest (made in a chat)")


async def test_a_role_that_is_changed_counts_at_once_and_ends_what_moves_under_it() -> None:
    async with house() as place:
        place.robot("omni").work_s = 60.0
        await make(place, GUEST)
        await give(place, "Vi")
        await place.line(VI, "omni move 1 m")
        assert place.gateway.rooms.organiser.holder("omni") is not None
        told = await place.line(ADA, "/role guest may omni:wave")
        assert told == (
            f"Change the role guest from {GIVES} to omni:wave? It changes what Vi may do."
        )
        await place.press(ADA, "Make it so")
        await place.quiet()
        assert "Ada made the role guest: omni:wave." in place.told(VI).splitlines()
        assert place.gateway.rooms.organiser.holder("omni") is None
        await place.line(VI, "omni move 1 m")
        assert place.acted() == 1


async def test_a_role_outlives_a_restart_and_the_act_is_on_the_record() -> None:
    store, clock = WritingStore(), ManualClock()
    first = House(store, clock)
    async with first.open():
        await make(first, GUEST)
        await give(first, "Vi")
    memory = await store.open()
    assert [fact.key for fact in memory.facts[ROLE]] == ["guest"]
    again = House(store, clock)
    async with again.open():
        assert own(again)["guest"].limits == ("omni:move distance <= 1 m",)
        await again.line(VI, "omni move 2 m")
        assert again.acted() == 0
        await again.line(VI, "omni wave")
        assert again.acted() == 1


async def test_the_file_wins_over_a_role_of_the_same_name_and_says_so_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with house() as place:
        book = place.gateway.authority.rolebook
        book.file = replace(
            book.file, roles={**book.file.roles, "guest": Role(scopes=("omni:read",))}
        )
        with caplog.at_level(logging.WARNING, "rosic.organiser"):
            for records in (book.make("guest", Role(scopes=("*:*",)), "p", 1),) * 2:
                for record in records:
                    if isinstance(record, Fact):
                        book.apply(record)
                    else:
                        assert isinstance(record, Decided)
                        assert record.act == "role"
        assert book.rulebook.roles["guest"].scopes == ("omni:read",)
        assert not book.own
        assert len(caplog.records) == 1


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ("guest may omny:move", "No robot or group is called 'omny:move'."),
        ("guest may omni:mvoe", "omni has no skill 'mvoe'."),
        ("guest may *:nothing", "No robot of '*' has a skill 'nothing'."),
        ("guest may operatr", "No role is called 'operatr'. Did you mean operator?"),
        ("guest may guest", "The role guest includes itself: guest includes guest."),
        ("guest may omni:move with distance <= 1 kg", "On omni,"),
        ("guest may omni:move with force <= 5 N", "No skill given here has a parameter 'force'"),
        ("guest may", "To make one, write for example: /role guest may ROBOT:SKILL"),
        ("guest may fleet:lock", "Rights about the place as a whole"),
        ("guest may admin", "Rights about the place as a whole"),
        ("viewer may omni:move", "The role viewer is one of this place's configuration"),
        ("tutor off", "The role tutor is one of this place's configuration"),
        ("omni may omni:move", "A role cannot be called"),
        ("guest off", "No role is called"),
        ("guest wants omni:move", "To make one, write for example"),
    ],
)
async def test_a_mistake_is_said_as_the_files_check_says_it_and_nothing_changes(
    what: str, said: str
) -> None:
    async with house() as place:
        epoch = place.gateway.authority.rights.epoch
        told = await place.line(ADA, f"/role {what}")
        expected = said.replace("omny:move", "omny")
        assert told.startswith(expected), told
        assert not own(place)
        assert place.gateway.authority.rights.epoch == epoch


async def test_a_loop_through_another_role_is_refused() -> None:
    async with house() as place:
        await make(place, GUEST)
        await make(place, "/role visitor may guest")
        told = await place.line(ADA, "/role guest may visitor")
        assert "includes itself" in told
        told = await place.line(ADA, "/role guest off")
        assert told == "The role guest is included in visitor. Nothing was done."
        assert own(place)["guest"].scopes == ("omni:move", "omni:wave")


async def test_who_gives_no_rights_makes_no_role_and_nobody_makes_more_than_is_theirs() -> None:
    async with house() as place:
        refused = (
            "Roles are for whoever gives rights here. Ada or Eve can. Nothing was done. What you "
            "may do says: me"
        )
        for line in ("/role", GUEST, "/role guest off"):
            assert await place.line(BO, line) == refused
        for what in ("omni:move", "*:move", "kuka1:grant", "kuka1:move senior"):
            told = await place.line(TIM, f"/role guest may {what}")
            assert told.startswith("You cannot give"), told
        assert not own(place)
        await make(place, "/role helper may kuka1:move", TIM)
        await make(place, GUEST)
        for line in ("/role guest may kuka1:move", "/role guest off"):
            assert (await place.line(TIM, line)).startswith("You cannot give")
        assert own(place)["guest"].scopes == ("omni:move", "omni:wave")


async def test_nobody_widens_a_role_that_they_hold_themselves() -> None:
    async with house(Eve="registrar") as place:
        await make(place, GUEST)
        await give(place, "Eve")
        told = await place.line(EVE, "/role guest may *:*")
        assert told.startswith("What you have rests on that role")
        assert own(place)["guest"].scopes == ("omni:move", "omni:wave")


async def test_an_open_invitation_keeps_a_role() -> None:
    async with house() as place:
        await make(place, GUEST)
        await place.line(ADA, "/invite guest for 2h")
        told = await place.line(EVE, "/role guest off")
        assert told == "The role guest is named in an open invitation of Ada. Nothing was done."
        assert "guest" in own(place)


async def test_roles_are_spoken_of_in_private_only() -> None:
    async with house() as place:
        before = len(place.chat.told)
        await place.say(GUEST, account=ADA, chat="lab", kind=ChatKind.GROUP)
        assert "private chat" in place.told("lab", before)
        assert not own(place)


async def test_a_tap_after_the_rules_have_changed_says_why_it_is_asked_again() -> None:
    async with house() as place:
        question = await place.line(ADA, GUEST)
        first = place.shown(ADA, "Make it so")
        await make(place, "/role other may omni:wave")
        told = await place.press_again(ADA, *first)
        changed = "Nothing was done yet: something has changed here since you were asked."
        assert told == f"{changed}\n{question}"
        assert "guest" not in own(place)
        await place.press(ADA, "Make it so")
        assert "guest" in own(place)


async def test_what_cannot_be_written_changes_nothing() -> None:
    store = BrokenStore()
    place = House(store)
    async with place.open():
        await place.line(ADA, GUEST)
        epoch = place.gateway.authority.rights.epoch
        store.broken = True
        await place.press(ADA, "Make it so")
        store.broken = False
        assert not own(place)
        assert place.gateway.authority.rights.epoch == epoch
