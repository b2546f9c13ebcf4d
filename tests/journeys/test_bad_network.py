"""Whatever the network, a proxy or Telegram does to a call: told once, acted once, token kept."""

from __future__ import annotations

import asyncio
from collections import defaultdict
from random import Random
from typing import TYPE_CHECKING, Any, get_args

import pytest

from rosic.testing.telegram.faults import FaultKind
from tests.journeys.fleet import ROBOTS, TOKEN
from tests.journeys.lab import Lab, lab
from tests.journeys.reading import Reply, read_reply, summarised
from tests.journeys.verdict import Said, judge

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from tests.journeys.running import Launcher

SECRET = TOKEN.partition(":")[2]
POLLS, WORDS = ("getUpdates",), ("sendMessage", "editMessageText")
TROUBLE: dict[str, list[tuple[str, Sequence[str], dict[str, Any]]]] = {
    "storms of 429": [("too_many_requests", (*WORDS, *POLLS), {"times": 4, "retry_after_s": 1})],
    "502": [("bad_gateway", (*WORDS, *POLLS), {"times": 2})],
    "truncated": [("truncated", (*WORDS, *POLLS), {"times": 1})],
    "errors": [("error", (*WORDS, *POLLS), {"times": 2, "code": 500})],
    "resets": [("reset", (*WORDS, *POLLS), {"times": 2}), ("drop_answer", WORDS, {"times": 1})],
    "hangs": [("hang", POLLS, {"seconds": 1.5}), ("hang_after", WORDS, {"seconds": 0.5})],
}
ROUNDS = 8


def test_every_fault_of_the_server_is_met_here() -> None:
    met = {kind for orders in TROUBLE.values() for kind, _, _ in orders}
    assert met == set(get_args(FaultKind))


async def give(place: Lab, said: list[Said], chance: Random) -> None:
    """Have two people say something, each of them to any robot."""
    for user in (place.ada, place.bo):
        robot = chance.choice(ROBOTS)
        message = await place.say(user, f"{robot} hop")
        said.append(Said(user, user, message, f"{robot} hop", (robot,)))


async def replies(place: Lab) -> dict[tuple[int, int], list[Reply]]:
    found: dict[tuple[int, int], list[Reply]] = defaultdict(list)
    for chat in (place.ada, place.bo):
        for message in await place.control.messages(chat, by_bot=True):
            if message["reply_to"] is not None or summarised(message):
                found[chat, message["reply_to"] or 0].append(read_reply(message))
    return found


async def judged(place: Lab, said: list[Said], within_s: float) -> list[str]:
    """Wait until everything was told, or the time is over; return what is wrong."""

    async def wrong() -> list[str]:
        return judge(said, await replies(place), place.counter.events).wrong

    async def nothing() -> bool:
        return not await wrong()

    await place.until(nothing, within_s)
    return await wrong()


def nowhere(place: Lab, secret: str) -> list[str]:
    """Return the files of a whole journey that hold a secret; the configuration must."""
    files = [file for file in place.folder.rglob("*") if file.is_file() and file != place.config]
    assert any(file.suffix == ".log" and file.stat().st_size for file in files)
    return [str(file) for file in files if secret.encode() in file.read_bytes()]


@pytest.mark.limit(400)
@pytest.mark.parametrize("what", TROUBLE)
async def test_everything_is_told_and_nothing_done_twice(
    tmp_path: Path, launcher: Launcher, what: str
) -> None:
    chance = Random(7)  # noqa: S311 - a seed makes it repeatable
    async with lab(tmp_path, launcher) as place:
        gateway = await place.start()
        said: list[Said] = []
        for turn in range(ROUNDS):
            kind, methods, details = TROUBLE[what][turn % len(TROUBLE[what])]
            for method in methods:
                await place.control.call("fail", kind=kind, method=method, **details)
            await give(place, said, chance)
            await asyncio.sleep(0.3)
        await place.control.call("calm")

        async def acted() -> bool:
            return place.acted() > 0

        while not await acted():  # on a slow machine everything before may have expired
            await give(place, said, chance)
            await place.until(acted, 10.0)
        assert await judged(place, said, 180.0) == []
        assert not gateway.is_gone()
        assert nowhere(place, SECRET) == []
        assert await place.control.violations() == []


@pytest.mark.limit(400)
async def test_updates_that_come_twice_in_disorder_and_under_wild_numbers(
    tmp_path: Path, launcher: Launcher
) -> None:
    chance = Random(9)  # noqa: S311 - a seed makes it repeatable
    async with lab(tmp_path, launcher) as place:
        await place.start()
        said: list[Said] = []
        for turn in range(ROUNDS):
            await place.control.call("duplicate", new_id=turn % 2 == 0)
            await place.control.call("reorder")
            await give(place, said, chance)
            await asyncio.sleep(0.2)
            if turn in {3, 5}:
                await place.drained()
                await place.control.call("jump", next_update_id=2_000_000_000 // turn)

        assert await judged(place, said, 180.0) == []
        assert nowhere(place, SECRET) == []


@pytest.mark.limit(400)
async def test_a_token_known_to_somebody_else_freezes_motion_and_the_admins_hear_of_it(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        await place.start()
        await place.ask(place.bo, "ant hop", "done ")
        await place.control.call("foreign_webhook", url="https://example.org/mine")

        await place.reads(place.ada, "go to another address (a webhook is set)")

        assert not [
            one
            for one in await place.control.messages(place.bo, by_bot=True)
            if "webhook" in one["text"]
        ]
        await place.control.call("foreign_webhook", url="")
        await place.say(place.bo, "bee hop")
        await place.reads(place.bo, "Nothing was done.")
        assert place.acted() == 1
        assert nowhere(place, SECRET) == []
