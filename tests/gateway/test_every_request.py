"""The authorisation key is asked for with every request: what reads, writes or is tapped."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.app.features import command_table
from tests.gateway.place import BO, Place
from tests.gateway.test_rights import who

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from typing import TypeAlias

    End: TypeAlias = "Callable[[Place], Awaitable[None]]"

ENDED = "Your access here has ended. The admin of this place can renew it."
READS = ("status", "help", "help omni", "use omni", "robots", "omni look")
WRITES = ("omni wave", "omni move 1 m", "swarm wave", "resume omni")


async def revoked(place: Place) -> None:
    keys = place.gateway.access.keys
    key = keys.current(who(place, "Bo"))
    assert key is not None
    async with place.gateway.access.changes.turn() as turn:
        await turn.write(keys.revoke(key.id, "test").records)


async def expired(place: Place) -> None:
    keys = place.gateway.access.keys
    async with place.gateway.access.changes.turn() as turn:
        await turn.write(keys.issue(who(place, "Bo"), "test", lasts_s=60)[1])
    await place.say("status", account=BO, chat=BO)  # somebody who is talking already
    await place.clock.advance(61.0)


@pytest.mark.parametrize("end", [revoked, expired])
async def test_without_a_good_key_nothing_is_done_and_nothing_is_told(end: End) -> None:
    async with Place().open() as place:
        await place.say("use omni", account=BO, chat=BO)
        button, under = place.button("Wave")
        await place.clock.advance(31.0)
        await end(place)
        counters = place.gateway.access.counters
        before = counters["key-revoked"] + counters["key-expired"]
        lines = (*READS, *WRITES, *(f"/{verb} omni" for verb in sorted(command_table().words)))
        for line in lines:
            await place.clock.advance(30.0)  # whoever has no access is answered seldom
            assert await place.say(line, account=BO, chat=BO) == ENDED, line
        await place.clock.advance(30.0)
        assert await place.tap(button, under, account=BO) == ENDED
        assert counters["key-revoked"] + counters["key-expired"] == before + len(lines) + 1, (
            "each counts"
        )
        assert [place.acted(robot) for robot in ("omni", "cf1", "cf2", "kuka1")] == [0, 0, 0, 0]
