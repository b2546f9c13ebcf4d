"""Two people with one code tap at once, through a whole gateway: exactly one is in."""

from __future__ import annotations

from random import Random
from typing import TYPE_CHECKING

import pytest

from rosic.authoriser.invitation import Given, Wanted
from tests.rooms.pipeline.place import Place
from tests.rooms.pipeline.test_one_lease import UnevenStore

if TYPE_CHECKING:
    from rosic.core.message import Button

NOT_GOOD = "This code is not good here. Ask whoever invited you for a new one. Nothing was done."
# Used codes count as wrong ones: fifty of them within an hour would open the breaker.
APART_S = 100.0
IN = "You are in, as viewer."


async def invited(place: Place) -> str:
    access = place.gateway.access
    wanted = Wanted(
        given=Given(roles=("viewer",), robots=(), lasts_s=None), needs_confirmation=False
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
            assert place.gateway.access.tally["code-used"] == number + 1
            first_won += won == [pair[0]]
            await place.clock.advance(APART_S)
    assert rounds // 4 < first_won < rounds - rounds // 4, "chance decides who wins"


async def test_one_of_two_redeemers_is_in_over_200_rounds() -> None:
    await race(200)


@pytest.mark.campaign
@pytest.mark.limit(3600)
async def test_one_of_two_redeemers_is_in_over_10000_rounds() -> None:
    await race(10_000)
