"""Whose a live card is: it shows what its owner may see, in their language, and goes with them."""

from __future__ import annotations

import msgspec
import pytest

from rosic.core.message import ChatKind
from rosic.core.robot.skill import Parameter, Skill
from rosic.features.dashboard import DashboardFeature
from rosic.features.dashboard.dashboards import CARDS_A_PERSON
from rosic.stores.memory import MemoryStore
from tests.gateway.place import BO, FLEET, VI
from tests.gateway.shown_cards import GROUP, SlowMessenger, showing

KIND = ChatKind.GROUP


async def test_in_a_group_it_says_whose_eyes_it_has() -> None:
    async with showing(roles={"Vi": "narrow"}) as shown:
        text = await shown.begins("/card", account=VI, **GROUP)
        assert text.startswith("What Vi may see:\nomni: free")
        assert "kuka1" not in text
        text = await shown.begins("/card", **GROUP)
        assert text.startswith("What Ada may see:")
        assert "kuka1" in text
        first, second = shown.cards("-7")
        assert shown.place.chat.shown(first).text == "This card has ended: a newer one is below."
        assert first != second


async def test_nobody_has_more_than_twenty_cards_and_whoever_has_keeps_them() -> None:
    async with showing() as shown:
        for number in range(CARDS_A_PERSON):
            assert await shown.begins("/card", account=VI, chat=f"-{number + 1}", kind=KIND)
        told = await shown.place.say("/card", account=VI, chat="-99", kind=KIND)
        assert told == "You have 20 cards in other chats already. End one there with /card off."
        cards = shown.place.gateway.features.get(DashboardFeature).robots
        assert len(cards) == CARDS_A_PERSON
        assert await shown.begins("/card", account=BO, chat="-99", kind=KIND), "another has none"
        told = await shown.place.say("/card", account=VI, chat="-99", kind=KIND)
        assert told.startswith("You have 20 cards"), "nor do they take another's over"
        assert await shown.begins("/card omni", account=VI, chat="-3", kind=KIND), "a newer one"
        await shown.place.say("/card off", account=VI, chat="-4", kind=KIND)
        assert await shown.begins("/card", account=VI, chat="-99", kind=KIND)


async def test_a_robot_that_one_may_not_see_cannot_be_named() -> None:
    async with showing(roles={"Vi": "narrow"}) as shown:
        told = await shown.place.say("/card kuka1", account=VI, chat=VI)
        assert told == "There is no robot and no group called kuka1 here."


async def test_what_somebody_says_to_a_robot_is_not_repeated_to_others() -> None:
    tell = Skill(id="tell", title="Tell", parameters={"words": Parameter(text=True)})
    omni = msgspec.structs.replace(FLEET[0], skills={tell.id: tell})
    async with showing(fleet=(omni, *FLEET[1:])) as shown:
        await shown.begins("/card omni", account=VI)
        await shown.place.say("omni tell my door code is 4711")
        assert shown.place.acted() == 1
        await shown.pass_s(4)
        assert "  sent 0: Tell\n" in shown.text(VI)
        assert not any("4711" in t.outbound.text for t in shown.edits(VI))


async def test_what_may_be_seen_no_more_is_gone_within_a_second() -> None:
    async with showing(roles={"Vi": "narrow"}) as shown:
        await shown.place.say("/grant Vi operator kuka1 for 20 s")
        assert "kuka1" in await shown.begins("/card", account=VI)
        await shown.pass_s(19)
        assert "kuka1" in shown.text(VI)
        await shown.pass_s(2)
        assert "kuka1" not in shown.text(VI)
        assert "omni" in shown.text(VI)


async def test_words_that_wait_for_their_turn_are_taken_back_with_the_right() -> None:
    async with showing(chat=SlowMessenger, roles={"Vi": "narrow"}) as shown:
        await shown.place.say("/grant Vi operator kuka1 for 20 s")
        await shown.begins("/card", account=VI)
        chat = shown.place.chat
        assert isinstance(chat, SlowMessenger)
        chat.slow_s = 30.0
        await shown.pass_s(16)
        shown.place.robot("kuka1").online = False
        await shown.pass_s(3)
        chat.slow_s = 0.0
        await shown.pass_s(2)
        assert "kuka1" not in shown.text(VI)
        await shown.pass_s(30)
        assert not any("kuka1: free · not there" in t.outbound.text for t in shown.edits(VI))


@pytest.mark.parametrize("revoked", [False, True])
async def test_a_lock_and_a_revocation_end_it_at_once(revoked: bool) -> None:
    async with showing() as shown:
        await shown.begins("/card", account=BO)
        if revoked:
            await shown.place.revoke("Bo")
        else:
            await shown.place.say("/lock Bo")
        await shown.place.quiet()
        seen = shown.place.chat.shown(shown.cards(BO)[-1])
        assert seen.text.startswith("This card has ended: whoever asked for it may see no robot")
        assert not seen.buttons
        assert not len(shown.place.gateway.features.get(DashboardFeature).robots)


async def test_it_goes_with_its_owner() -> None:
    store = MemoryStore()
    async with showing(store) as shown:
        await shown.begins("/card", account=BO)
        await shown.place.say("/forget me", account=BO, chat=BO)
        await shown.place.tap(*shown.place.button("Forget me for good"), account=BO)
        await shown.pass_s(2)
        seen = shown.place.chat.shown(shown.cards(BO)[-1])
        assert seen.text == "This card has ended. /card begins a new one."
        assert not [fact for fact in await store.facts("card", "", 10) if fact.body]


async def test_each_owner_reads_it_in_their_own_language_whoever_gave_the_order() -> None:
    async with showing() as shown:
        await shown.place.say("/settings language deutsch", account=VI, chat=VI)
        shown.place.robot("omni").work_s = 1_000.0
        await shown.place.say("omni move 1 m")
        shown.place.robot("kuka1").work_s = 1_000.0
        await shown.place.say("/settings language deutsch")
        await shown.place.say("kuka1 move 1 m")
        text = await shown.begins("/card omni kuka1", account=VI)
        for robot in ("omni", "kuka1"):
            assert f"{robot}: Ada · Verbindung gut\n  gesendet 0: " in text
        assert text.count("  empfangen 0: ") == 2
        text = await shown.begins("/card omni kuka1", account=BO)
        assert text.count("  sent 0: ") == 2
        for robot in ("omni", "kuka1"):
            shown.finish(robot)
        await shown.pass_s(4)
        assert shown.text(BO).count("now: done 0") == 2
        assert shown.text(VI).count("jetzt: fertig 0") == 2
