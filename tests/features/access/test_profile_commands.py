"""`/me`, `/people` and `/security`: who is who, for those who may know."""

from __future__ import annotations

import msgspec

from rosic.core.policy.roles import Grant
from rosic.core.records import KeyIssued
from rosic.features.access.profile_commands import MOST_CHARACTERS, MOST_LINES
from rosic.gateway.commands import ONLY_IN_PRIVATE
from tests.features.access.access_handlers import ADA, BO, CY, DI, ED, a_hall

HOUR_NS = 3_600_000_000_000
NOT_YOURS = "Looking after people is for admins. Ada or Bo can. Nothing was done."


async def test_me_says_who_what_and_until_when() -> None:
    async with a_hall() as hall:
        until_ns = hall.clock.wall_ns() + 2 * HOUR_NS
        given = (
            Grant(
                id="g1",
                role="operator",
                robots=("kuka1",),
                limits=("distance <= 2 m",),
                expires_ns=until_ns,
            ),
            Grant(id="g2", scopes=("swarm:look",)),
            Grant(id="g3", role="admin", expires_ns=hall.clock.wall_ns()),
        )
        await hall.knows(DI, "Di", "junior", grants=given)
        hall.slots = ("KUKA1 tomorrow 14:00 to 15:00",)
        assert (await hall.say(DI, "/me")).splitlines() == [
            "You are Di.",
            "Your rights: junior, with distance <= 1 m",
            "  also operator on kuka1, with distance <= 2 m, until tomorrow 00:13",
            "  also look on swarm",
            "CF1, CF2 and OMNI: move (distance <= 1 m) and look; not wave or resume",
            "KUKA1: move (distance <= 1 m or distance <= 2 m), wave and look",
            "Authenticator: not set up. /authenticator begins.",
            "This chat: readable by its provider, who could also write in your name.",
            "Your next times:",
            "  KUKA1 tomorrow 14:00 to 15:00",
        ]
        hall.slots = ()
        assert (await hall.say(DI, "/me")).splitlines()[-1] == "Your next times: none."


async def test_me_of_a_viewer_and_of_somebody_without_rights() -> None:
    async with a_hall() as hall:
        await hall.knows(DI, "Di", "viewer")
        assert "CF1, CF2, KUKA1 and OMNI: you may look, and stop it" in await hall.say(DI, "/me")
        await hall.knows(ED, "Ed")
        assert (await hall.say(ED, "/me")).splitlines()[:2] == [
            "You are Ed.",
            "You have no rights now. An admin can give you some.",
        ]


async def test_me_says_when_the_key_ends() -> None:
    async with a_hall() as hall:
        key = msgspec.structs.replace(
            hall.directory.key_of("p-3") or hall.keys.of("p-3")[0],
            id="k-short",
            expires_ns=hall.clock.wall_ns() + HOUR_NS,
        )
        async with hall.changes.turn() as turn:
            revoked = hall.keys.revoke("k-3", "p-1")
            await turn.write((KeyIssued(key=key), *revoked.records))
        assert "Your access ends: 23:13" in await hall.say(CY, "/me")


async def test_me_is_for_nobody_else() -> None:
    async with a_hall() as hall:
        assert await hall.in_group(CY, "/me") == ONLY_IN_PRIVATE
        await hall.say(ADA, "/lock Cy Young")
        assert await hall.say(CY, "/me") == "Your access is locked. Ask an admin."


async def test_people_are_listed_for_admins() -> None:
    async with a_hall() as hall:
        await hall.knows(DI, "di")
        await hall.say(ADA, "/lock Cy Young")
        await hall.knows(ED, "Ed", "viewer")
        await hall.say(ADA, "/revoke Ed")
        await hall.tap(ADA, "Revoke")
        assert (await hall.say(ADA, "/people")).splitlines() == [
            "Ada (you) · admin",
            "Bo · admin",
            "Cy Young · operator · locked by Ada",
            "di · has no rights now",
        ]
        assert await hall.say(ADA, "/people ed") == "Ed · has no access any more"
        assert await hall.say(ADA, "/people young") == "Cy Young · operator · locked by Ada"
        assert await hall.say(ADA, "/people xy") == 'I know nobody whose name holds "xy".'


async def test_people_are_nobody_elses_business() -> None:
    async with a_hall() as hall:
        assert await hall.say(CY, "/people") == NOT_YOURS
        assert await hall.in_group(ADA, "/people") == ONLY_IN_PRIVATE
        assert await hall.say(CY, "/security") == NOT_YOURS
        assert await hall.in_group(ADA, "/security") == ONLY_IN_PRIVATE


async def test_a_long_list_is_cut() -> None:
    async with a_hall() as hall:
        for number in range(100):
            await hall.knows(str(1_000 + number), f"Guest {number:03}", "viewer")
        lines = (await hall.say(ADA, "/people")).splitlines()
        assert len(lines) == MOST_LINES + 1
        assert lines[-1] == f"And {103 - MOST_LINES} more: /people and a part of the name."
        assert len(await hall.say(ADA, "/people guest 04")) < 400


async def test_what_is_too_long_for_a_message_is_cut_at_a_line() -> None:
    async with a_hall() as hall:
        for number in range(MOST_LINES):
            await hall.knows(str(1_000 + number), f"{number:03} " + "x" * 200, "viewer")
        said = await hall.say(ADA, "/people")
        assert len(said) < MOST_CHARACTERS + 40
        assert said.splitlines()[-1].endswith(" more lines.")


async def test_the_security_report() -> None:
    async with a_hall() as hall:
        await hall.say(DI, "join ABCD-0000")
        await hall.invited("operator kuka1 for 2h")
        await hall.say(ADA, "/lock Cy Young")
        said = await hall.say(BO, "/security")
        assert said.startswith("Authentication: p50 0.000 ms, p99 0.000 ms, over the last")
        assert "  codes that never were: 1" in said
        assert "  Cy Young, by Ada, for 1 second now" in said
        assert "  operator on kuka1 for 2 hours, by Ada, i" in said
