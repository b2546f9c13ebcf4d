"""Unlocking: who is told, and what it waits for."""

from __future__ import annotations

from rosic.authoriser import keys_messages
from rosic.features.access.revoke_lock import AccessNotices
from tests.features.access.access_handlers import ADA, BO, CY, BrokenStore, a_hall


async def test_an_admin_who_is_unlocked_or_whose_key_is_taken_is_told_once() -> None:
    async with a_hall() as hall:
        await hall.say(ADA, "/lock Bo")
        before = len(hall.chat.told)
        await hall.say(ADA, "/unlock Bo")
        assert hall.told(BO, before) == (
            "Ada unlocked you. You may do again what you could before."
        )
        notices = AccessNotices(hall.registry, hall.admin_policy)
        bo = hall.directory.named("Bo")[0]
        before = len(hall.chat.told)
        notices.key_taken(bo, "p-1")
        await hall.quiet()
        assert hall.told(BO, before) == keys_messages.KEY_TAKEN
        notices.key_taken(bo, "p-3")
        await hall.quiet()
        assert "took" in hall.told(ADA, before)


async def test_unlocking() -> None:
    async with a_hall() as hall:
        assert await hall.say(ADA, "/unlock") == (
            "Who shall have their access back? Write: /unlock NAME."
        )
        await hall.say(ADA, "/lock Cy Young")
        assert await hall.say(BO, "/unlock") == (
            "Who shall have their access back? Write: /unlock NAME. Locked now: Cy Young."
        )
        assert await hall.in_group(BO, "/unlock") == (
            "Who shall have their access back? Write: /unlock NAME."
        )
        assert await hall.say(BO, "/unlock Cy Young") == "Cy Young is unlocked."
        assert hall.last(CY).text == "Bo unlocked you. You may do again what you could before."
        assert hall.last(ADA).text == "Bo unlocked Cy Young."
        assert (await hall.say(CY, "/me")).startswith("You are Cy Young.")
        assert await hall.say(BO, "/unlock Cy Young") == (
            "Cy Young is not locked. Nothing was done."
        )
        assert await hall.say(ADA, "/unlock me") == ('I know nobody called "me". Nothing was done.')
        assert await hall.say(ADA, "/unlock Ada") == (
            "Another admin has to unlock you. Nothing was done."
        )


async def test_unlocking_waits_for_the_disk() -> None:
    store = BrokenStore()
    async with a_hall(store) as hall:
        await hall.say(ADA, "/lock Cy Young")
        store.broken = True
        said = await hall.say(ADA, "/unlock Cy Young")
        assert said.startswith("I cannot write this down now, so nothing was changed.")
        assert hall.locks.locked("p-3")
