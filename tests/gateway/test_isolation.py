"""I11: nothing that is decided for one person rests on another's container.

What somebody is answered, and what robots do for them, is the same to the letter whatever the
others keep, prefer or choose, and also when the others' containers have been erased.
"""

from __future__ import annotations

from random import Random
from typing import TYPE_CHECKING, NamedTuple

import pytest

from rosic.errors import NotPermitted
from tests.gateway.place import ADA, BO, VI, Place

if TYPE_CHECKING:
    from collections.abc import Iterator

PRIVATE = (
    "/settings units imperial",
    "/settings units metric",
    "/settings robot omni",
    "/settings robot kuka1",
    "/settings speed 0.2 m/s",
    "/settings zone Asia/Tokyo",
    "/data plan = theirs",
    "/data note = also theirs",
    "use kuka1",
    "use swarm",
    "use omni",
    "/mydata",
    "/archive on",
    "status",
    "/me",
)
BOS = (
    "/settings",
    "/data plan = mine",
    "omni move 50 cm",
    "move 0.5 m back",
    "wave",
    "/data",
    "/data plan",
    "use cf1",
    "wave",
    "omni look",
    "/mydata",
    "/slots omni",
    "robots",
    "status",
    "/settings units imperial",
    "omni move 2 ft",
    "/settings",
    "kuka1 wave",
    "swarm wave",
)


class Seen(NamedTuple):
    """What one person was shown, and what robots did."""

    told: tuple[str, ...]
    acted: dict[str, int]


async def bos_day(others: tuple[tuple[str, str], ...], *, erased: bool = False) -> Seen:
    """Let the others say things, then Bo; return what Bo saw.

    Args:
        others: Account and words, said in turn with Bo's.
        erased: Whether Vi is forgotten before Bo's second half.
    """
    told: list[str] = []
    waiting: Iterator[tuple[str, str]] = iter(others)
    async with Place().open() as place:
        for number, line in enumerate(BOS):
            if erased and number == len(BOS) // 2:
                await place.say("/forget me", account=VI, chat=VI)
                await place.tap(*place.button("Forget me for good"), account=VI)
            await place.clock.advance(1.0)
            for account, text in (next(waiting, ("", "")), next(waiting, ("", ""))):
                if text:
                    await place.say(text, account=account, chat=account, message=f"{account}{text}")
                else:
                    await place.clock.advance(0.001)
            await place.say(line, account=BO, chat=BO, message=f"bo{number}")
            await place.clock.advance(1.0)
        for out in (t.outbound for t in place.chat.told):
            if out.chat.id == BO:
                labels = [(b.label, b.command) for row in out.buttons for b in row]
                told.append(f"{out.text} {labels}")
        return Seen(tuple(told), {name: place.acted(name) for name in place.gateway.robots})


@pytest.mark.parametrize("seed", range(8))
async def test_what_others_keep_changes_nothing_for_one(seed: int) -> None:
    chance = Random(seed)  # noqa: S311 - a seed makes it repeatable
    others = tuple(
        (chance.choice((ADA, VI)), f"{chance.choice(PRIVATE)}") for _ in range(2 * len(BOS))
    )
    alone = await bos_day(())
    assert alone.acted["omni"] >= 2
    assert len(alone.told) >= len(BOS)
    assert await bos_day(others) == alone


async def test_a_container_that_is_erased_changes_nothing_for_others() -> None:
    others = tuple((VI, text) for text in PRIVATE[:8])
    assert await bos_day(others, erased=True) == await bos_day(())


async def test_what_somebody_keeps_is_read_by_others_only_if_they_were_let() -> None:
    async with Place().open() as place:
        await place.say("/data plan = mine alone", account=BO, chat=BO)
        data_context = place.gateway.kernel.containers
        assert data_context is not None
        shelf = data_context.shelf
        directory = place.gateway.rooms.authoriser.directory
        bo, vi, ada = (directory.named(name)[0].id for name in ("Bo", "Vi", "Ada"))
        for reader in (vi, ada):
            with pytest.raises(NotPermitted):
                shelf.latest(reader, bo, "plan")
        async with place.gateway.access.changes.turn() as turn:
            await turn.write(shelf.lending.lend(bo, vi, "plan"))
        kept = shelf.latest(vi, bo, "plan")
        assert kept is not None
        assert kept.value == "mine alone"
        with pytest.raises(NotPermitted):
            shelf.latest(ada, bo, "plan")
        async with place.gateway.access.changes.turn() as turn:
            await turn.write(shelf.lending.take_back(bo, "plan", vi))
        with pytest.raises(NotPermitted):
            shelf.latest(vi, bo, "plan")
