"""People with one code tap at once, two or ten thousand, through a whole gateway: one is in."""

from __future__ import annotations

from random import Random
from typing import TYPE_CHECKING

import pytest

from rosic.authoriser.invitations import InvitationRequest, InvitedRights
from tests.gateway.place import Place
from tests.gateway.test_one_lease import UnevenStore

if TYPE_CHECKING:
    from rosic.core.message import Button

OFFERED = 2_000  # so many strangers can hold a button that is good; the oldest are forgotten
WAVE = 500
NOT_GOOD = "This code is not good here. Ask whoever invited you for a new one. Nothing was done."
# Used codes count as wrong ones: fifty of them within an hour open the breaker.
APART_S = 100.0
IN = "You are in, as viewer."


async def invited(place: Place) -> str:
    access = place.gateway.access
    wanted = InvitationRequest(
        given=InvitedRights(roles=("viewer",), robots=(), lasts_s=None), needs_confirmation=False
    )
    ada = place.gateway.rooms.authoriser.directory.named("Ada")[0].id
    async with access.changes.turn() as turn:
        offer = access.enrolment.invitations.invite(wanted, ada)
        await turn.write(offer.records)
    return offer.code.reveal()


async def race(rounds: int) -> None:
    """Let two people nobody knows yet tap Join on the same invitation, again and again."""
    chance = Random(21)  # noqa: S311 - a seed makes it repeatable
    place = Place(UnevenStore(chance))
    first_won = 0
    async with place.open():
        for number in range(rounds):
            code = await invited(place)
            pair = [f"{side}{number}" for side in ("a", "b")]
            buttons: list[tuple[Button, str]] = []
            for account in pair:
                await place.say(code, account=account, chat=account)
                buttons.append(place.button("Join"))
            before = len(place.gateway.rooms.authoriser.directory._people)
            turns = list(zip(pair, buttons, strict=True))
            chance.shuffle(turns)
            place.chat.told.clear()
            for account, (button, under) in turns:
                place.chat.tap(button, under=under, account=account)
            await place.quiet()
            told = {t.outbound.chat.id: t.outbound.text for t in place.chat.told}
            won = [account for account in pair if told[account].startswith(IN)]
            assert len(won) == 1, told
            (lost,) = set(pair) - set(won)
            assert told[lost] == NOT_GOOD
            assert len(place.gateway.rooms.authoriser.directory._people) == before + 1
            assert place.gateway.access.counters["code-used"] == number + 1
            first_won += won == [pair[0]]
            await place.clock.advance(APART_S)
    assert rounds // 4 < first_won < rounds - rounds // 4, "chance decides who wins"


async def test_one_of_two_redeemers_is_in_over_200_rounds() -> None:
    await race(200)


@pytest.mark.campaign
@pytest.mark.limit(3600)
async def test_one_of_two_redeemers_is_in_over_10000_rounds() -> None:
    await race(10_000)


async def shown_to(place: Place, crowd: list[str], code: str) -> dict[str, tuple[Button, str]]:
    """Let each say the code; return the Join button that each was shown."""
    joins: dict[str, tuple[Button, str]] = {}
    for first in range(0, len(crowd), WAVE):
        place.chat.told.clear()
        for account in crowd[first : first + WAVE]:
            place.chat.say(code, account=account, chat=account)
        await place.quiet()
        for told in place.chat.told:
            row = told.outbound.buttons[0]
            joins[told.outbound.chat.id] = next(b for b in row if b.label == "Join"), told.message
    assert joins.keys() == set(crowd)
    return joins


async def rush(redeemers: int) -> None:
    """Let a crowd of strangers tap Join on one and the same invitation at once."""
    chance = Random(redeemers)  # noqa: S311 - a seed makes it repeatable
    place = Place(UnevenStore(chance))
    crowd = [f"c{number}" for number in range(redeemers)]
    async with place.open():
        people = place.gateway.rooms.authoriser.directory._people
        before, code = set(people), await invited(place)
        joins = await shown_to(place, crowd, code)
        chance.shuffle(crowd)
        place.chat.told.clear()
        for account in crowd:
            button, under = joins[account]
            place.chat.tap(button, under=under, account=account)
        counters, rivals = place.gateway.access.counters, min(redeemers, OFFERED) - 1
        for _ in range(redeemers):
            await place.quiet()
            if counters["code-used"] >= rivals:
                break
        await place.quiet()
        won = [
            told.outbound.chat.id for told in place.chat.told if told.outbound.text.startswith(IN)
        ]
        assert len(won) == 1
        (newcomer,) = set(people) - before
        assert [address.account for address in people[newcomer].addresses] == won
        # Fifty that were too late look like guessing: the admins hear of it, once.
        assert (counters["code-used"], counters["code-breaker"]) == (rivals, 1)


async def test_one_of_300_redeemers_of_one_code_is_in() -> None:
    await rush(300)


@pytest.mark.campaign
@pytest.mark.limit(3600)
async def test_one_of_10000_redeemers_of_one_code_is_in() -> None:
    await rush(10_000)
