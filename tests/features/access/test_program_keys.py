"""Keys of programs in a chat: shown once, to whoever may give their rights, and kept nowhere."""

from __future__ import annotations

import re

import pytest

from rosic.core.message import ChatKind
from rosic.core.secret import Secret
from rosic.errors import Unrecognised
from tests.features.access.access_gateway import EVE, TIM, House
from tests.gateway.place import ADA, BO

SECRET = re.compile(r"rosic_k[0-9a-f]+_[A-Za-z0-9_-]+")
DAY_S = 86_400.0


def secret_in(text: str) -> Secret:
    found = SECRET.findall(text)
    assert len(found) == 1, text
    return Secret(found[0])


async def test_a_key_is_shown_once_and_its_program_may_what_was_given_until_it_ends() -> None:
    house = House()
    async with house.open():
        told = await house.line(ADA, "/key create Hal operator on omni for 30 days")
        assert told.startswith("Hal is known now, a program: operator on omni for 30 days.")
        programs, organiser = house.gateway.access.programs, house.gateway.rooms.organiser
        address = programs.identify(secret_in(told))
        hal = house.gateway.rooms.authoriser.directory.at(address)
        assert hal is not None
        assert organiser.allows(hal[0].id, "omni", "move")
        assert not organiser.allows(hal[0].id, "kuka1", "move")
        listed = await house.line(ADA, "/key list")
        assert listed == "Hal: operator on omni, for 30 days; by Ada"
        assert not SECRET.search(listed)
        house.clock.jump_wall(30 * DAY_S + 1)
        with pytest.raises(Unrecognised):
            programs.identify(secret_in(told))


async def test_without_a_length_a_key_ends_all_the_same() -> None:
    house = House()
    async with house.open():
        told = await house.line(ADA, '/key create "Hal 9" operator')
        assert "Hal 9 is known now, a program: operator for 90 days." in told


async def test_a_message_with_a_key_goes_by_a_tap_and_its_words_go_where_it_cannot() -> None:
    house = House()
    async with house.open():
        told = await house.line(ADA, "/key create Hal operator on omni")
        button, message = house.shown(ADA, "Take it out of this chat")
        assert SECRET.search(house.chat.shown(message).text)
        await house.tap(button, message)
        assert not SECRET.search(house.chat.shown(message).text)
        house.gateway.access.programs.identify(secret_in(told))


@pytest.mark.parametrize(
    ("who", "line", "why"),
    [
        (ADA, "/key create Hal admin", "A program gives nobody rights"),
        (ADA, "/key create Hal tutor on kuka1", "A program gives nobody rights"),
        (ADA, "/key create Ada operator on omni", "Somebody is called Ada already"),
        (ADA, "/key create Hal", "How is the program called, and what may it?"),
        (ADA, "/key create Hal driver on omni", "driver"),
        (ADA, "/key frobnicate", "A program has a key of its own"),
        (ADA, "/key rotate Nobody", "There is no program of that name"),
        (ADA, "/key revoke Nobody", "There is no program of that name"),
        (BO, "/key create Hal viewer on omni", "it is more than you may give"),
        (TIM, "/key create Hal operator on omni", "it is more than you may give"),
        (TIM, "/key create Hal operator", "it is more than you may give"),
    ],
)
async def test_what_cannot_be_given_is_refused_in_a_sentence(who: str, line: str, why: str) -> None:
    house = House()
    async with house.open():
        before = len(list(house.gateway.rooms.authoriser.directory.people()))
        told = await house.line(who, line)
        assert why in told
        assert not SECRET.search(told)
        assert len(list(house.gateway.rooms.authoriser.directory.people())) == before


async def test_nobody_is_shown_a_key_where_others_read_along() -> None:
    house = House()
    async with house.open():
        await house.say("/key create Hal operator", account=ADA, chat="g", kind=ChatKind.GROUP)
        _, told = house.last()
        assert not SECRET.search(told.text)
        assert "private" in told.text


async def test_whoever_gives_rights_on_a_robot_makes_keys_for_that_robot_alone() -> None:
    house = House()
    async with house.open():
        told = await house.line(TIM, "/key create Kim viewer on kuka1 for 2 days")
        assert "Kim is known now" in told
        assert "Kim: " in await house.line(TIM, "/key list")
        assert "no key of a program" in await house.line(BO, "/key list")


async def test_a_new_key_takes_the_place_of_the_old_one_which_stays_good_for_a_while() -> None:
    house = House()
    async with house.open():
        programs = house.gateway.access.programs
        old = secret_in(await house.line(ADA, "/key create Hal operator on omni for 30 days"))
        told = await house.line(ADA, "/key rotate Hal for 1 hour")
        assert told.startswith("Hal has a new key. The old one is good for another 60 minutes.")
        new = secret_in(told)
        assert programs.identify(old) == programs.identify(new)
        assert (await house.line(ADA, "/key list")).splitlines() == [
            "Hal: operator on omni, for 30 days; by Ada",
            "Hal, the older key: replaced by a newer key, good for another 60 minutes",
        ]
        await house.clock.advance(3_601)
        assert len((await house.line(ADA, "/key list")).splitlines()) == 1
        with pytest.raises(Unrecognised):
            programs.identify(old)
        programs.identify(new)
        newest = secret_in(await house.line(ADA, "/key rotate Hal now"))
        with pytest.raises(Unrecognised):
            programs.identify(new)
        house.clock.jump_wall(30 * DAY_S)
        with pytest.raises(Unrecognised):
            programs.identify(newest)


async def test_whoever_may_not_give_what_a_program_holds_gets_no_key_of_it() -> None:
    house = House()
    async with house.open():
        await house.line(ADA, "/key create Hal operator on omni for 30 days")
        told = await house.line(TIM, "/key rotate Hal")
        assert "There is no program of that name" in told
        assert not SECRET.search(told)


async def test_a_key_is_taken_back_after_asking_and_at_once() -> None:
    house = House()
    async with house.open():
        secret = secret_in(await house.line(ADA, "/key create Hal operator on omni"))
        asked = await house.line(EVE, "/key revoke Hal")
        assert asked.startswith("End every key of Hal for good?")
        house.gateway.access.programs.identify(secret)
        assert "Hal has no good key any more." in await house.press(EVE, "End Hal")
        with pytest.raises(Unrecognised):
            house.gateway.access.programs.identify(secret)


async def test_what_somebody_made_ends_with_their_own_access() -> None:
    house = House()
    async with house.open():
        secret = secret_in(await house.line(EVE, "/key create Hal operator on omni"))
        await house.line(ADA, "/revoke Eve")
        await house.press(ADA, "Revoke")
        with pytest.raises(Unrecognised):
            house.gateway.access.programs.identify(secret)


async def test_no_archive_keeps_a_key() -> None:
    house = House()
    async with house.open():
        await house.line(ADA, "/archive on")
        secret = secret_in(await house.line(ADA, "/key create Hal operator on omni"))
        await house.line(ADA, f"this is it: {secret.reveal()}")
        await house.quiet()
        kept = repr(house.store.__dict__)
        assert "(not kept)" in kept
        assert secret.reveal() not in kept
