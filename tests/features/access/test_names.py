"""Whom somebody means: names with spaces, shared names, names that nobody has."""

from __future__ import annotations

from tests.features.access.access_handlers import ADA, DI, ED, a_hall

LOCKED = "Cy Young is locked: nothing they send is carried out until an admin unlocks them."


async def test_an_unknown_name_gets_offers() -> None:
    async with a_hall() as hall:
        assert await hall.say(ADA, "/lock Cy Yuong") == (
            'I know nobody called "Cy Yuong". Nothing was done.'
        )
        assert hall.labels(ADA) == ["/lock Cy Young"]
        assert await hall.tap(ADA, "/lock Cy Young") == LOCKED
        for said in ("young", "Cy", "c"):
            await hall.say(ADA, f"/revoke {said}")
            assert hall.labels(ADA) == ["/revoke Cy Young"], said
        await hall.say(ADA, "/revoke Xaver")
        assert hall.labels(ADA) == []
        # In a group nobody is told who is known here.
        await hall.in_group(ADA, "/lock Cy")
        assert hall.labels("g") == []


async def test_two_of_one_name_are_told_apart() -> None:
    async with a_hall() as hall:
        await hall.knows(DI, "Cy Young", "viewer")
        await hall.knows(ED, "Cy Young")
        assert await hall.say(ADA, "/lock Cy Young") == (
            '3 people are called "Cy Young". Which one?'
        )
        assert hall.labels(ADA) == [
            "Cy Young, operator",
            "Cy Young, viewer",
            "Cy Young, without a role of their own",
        ]
        assert await hall.tap(ADA, "Cy Young, viewer") == LOCKED
        assert hall.ended == [("p-4", True)]
        # Only one of them can be unlocked, so there is nothing to ask.
        assert await hall.say(ADA, "/unlock Cy Young") == "Cy Young is unlocked."
        assert await hall.in_group(ADA, "/lock Cy Young") == (
            '3 people are called "Cy Young". Ask me in a private chat, where I can show you which. '
            "Nothing was done."
        )
        await hall.say(ADA, "/revoke Cy Young")
        assert (await hall.tap(ADA, "Cy Young, operator")).startswith("End the access of Cy Young")
        await hall.tap(ADA, "Revoke")
        assert not hall.directory.has_good_key("p-3")
