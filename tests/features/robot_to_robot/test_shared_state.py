"""shareData and getSharedData: who may, how much, how old, and what outlives a restart."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.contracts.robot import UTTERANCE_BYTES
from rosic.core.robot.dialogue_protocol import DATA_BYTES, ROBOT_BYTES, TOPICS_A_ROBOT
from rosic.features.access import AccessFeature
from rosic.features.personal_data import PersonalDataFeature
from rosic.features.personal_data.archive_recorder import ArchivingMessenger
from rosic.features.robot_to_robot import RobotToRobotFeature
from rosic.features.robot_to_robot.digest import EVERY_S
from rosic.features.robot_to_robot.subscriptions import PAIR_PACE
from rosic.stores.memory import MemoryStore
from tests.features.robot_to_robot.peers import PeerRobots
from tests.gateway.place import ADA, BO, STRANGER, VI

if TYPE_CHECKING:
    from collections.abc import Iterable


async def say(here: PeerRobots, text: str, account: str = ADA) -> str:
    return await here.say(text, account=account, chat=account)


def texts(here: PeerRobots, account: str, since: int) -> Iterable[str]:
    return [t.outbound.text for t in list(here.chat.told)[since:] if t.outbound.chat.id == account]


async def test_what_a_robot_shares_another_reads_with_its_sender_and_its_age() -> None:
    async with PeerRobots().open() as here:
        answer = await here.says("omni", "share", topic="road", data={"wet": True, "at": [1, 2]})
        assert answer["ok"] is True
        await here.clock.advance(7)
        got = await here.says("cf1", "get", robot="omni", topic="road")
        assert (got["ok"], got["found"], got["from"]) == (True, True, "omni")
        assert got["data"] == {"wet": True, "at": [1, 2]}
        assert 7 <= got["age_s"] < 7.5
        assert got["id"] == answer["id"]
        await here.says("omni", "share", topic="road", data="dry")
        newest = await here.says("cf1", "get", robot="omni")
        assert (newest["topic"], newest["data"]) == ("road", "dry"), "the newest of all topics"


async def test_nothing_shared_is_said_and_no_error() -> None:
    async with PeerRobots().open() as here:
        got = await here.says("cf1", "get", robot="omni", topic="road")
        assert (got["ok"], got["found"]) == (True, False)


async def test_rights_are_checked_like_a_persons() -> None:
    async with PeerRobots().open() as here:
        refused = await here.says("kuka1", "share", topic="road", data=1)
        assert refused["why"].startswith("kuka1 has no key of its own here.")
        refused = await here.says("cf2", "get", robot="omni")
        assert refused["why"] == "I know no robot called omni.", "it may not read it, nor know it"
        await here.says("cf1", "share", topic="road", data=1)
        assert (await here.says("cf2", "get", robot="cf1"))["found"] is True
        refused = await here.says("cf2", "help", what="stuck")
        assert (refused["ok"], refused["code"]) == (False, "not-permitted")
        assert here.messaging.circle.shared_state.of("kuka1") == ()


async def test_a_robot_whose_key_is_taken_back_or_that_is_locked_is_heard_no_more() -> None:
    async with PeerRobots().open() as here:
        await say(here, "/lock cf1")
        assert (await here.says("cf1", "share", topic="road", data=1))["ok"] is False
        assert (await here.says("cf1", "unfollow", robot="omni"))["ok"] is False
        assert "omni has no access any more" in await here.revoke("omni")
        refused = await here.says("omni", "share", topic="road", data=1)
        assert (refused["ok"], refused["code"]) == (False, "unrecognised")
        assert await say(here, "/shared") == "No robot that you may see shares anything now."


async def test_data_of_10_mb_is_refused_in_a_sentence_and_nothing_is_kept() -> None:
    async with PeerRobots().open() as here:
        large = b'{"kind":"share","ref":"r","topic":"map","data":"' + b"x" * 10_000_000 + b'"}'
        here.robot("omni").speak(large, 0)
        await here.quiet()
        [answer] = here.heard("omni")
        assert (answer["ok"], answer["code"]) == (False, "out-of-bounds")
        assert answer["why"] == (
            f"That is too large: at most {UTTERANCE_BYTES // 1024} KiB are taken at once. "
            "Nothing of it was kept."
        )
        refused = await here.says("omni", "share", topic="map", data="x" * DATA_BYTES)
        assert f"at most {DATA_BYTES // 1024} KiB" in refused["why"]
        assert (await here.says("cf1", "get", robot="omni"))["found"] is False


async def test_topics_and_bytes_of_one_robot_are_bounded() -> None:
    async with PeerRobots().open() as here:
        shared_state = here.messaging.circle.shared_state
        for number in range(TOPICS_A_ROBOT):
            here.speaks("omni", "share", topic=f"t{number}", data=number)
            await here.clock.advance(0.06)
        assert len(shared_state.of("omni")) == TOPICS_A_ROBOT
        refused = await here.says("omni", "share", topic="one_more", data=1)
        assert "at most 32 topics" in refused["why"]
        piece = "x" * (DATA_BYTES - 10)
        for number in range(ROBOT_BYTES // DATA_BYTES + 1):
            here.speaks("omni", "share", topic=f"t{number}", data=piece)
            await here.clock.advance(0.06)
        assert sum(len(shared.data) for shared in shared_state.of("omni")) <= ROBOT_BYTES


async def test_what_is_not_of_the_published_form_is_refused_with_what_is_wrong() -> None:
    async with PeerRobots().open() as here:
        for words in (
            b"",
            b"{",
            b"[]",
            b'{"kind":"fly"}',
            b"\xff",
            b'{"kind":"share","topic":"a"}',
            b'{"kind":"share","topic":"A b","data":1}',
            b"[" * 50_000,
            b'{"kind":"share","topic":"a","data":1,"from":"cf1"}',
        ):
            here.robot("omni").heard.clear()
            here.robot("omni").speak(words, 0)
            await here.clock.advance(0.1)
            [answer] = here.heard("omni")
            assert (answer["ok"], answer["code"]) == (False, "not-understood"), words
        assert here.messaging.circle.shared_state.of("omni") == ()


async def test_it_is_forgotten_when_it_is_too_old() -> None:
    async with PeerRobots().open() as here:
        await here.says("omni", "share", topic="road", data=1, keep_s=30)
        await here.clock.advance(29)
        assert (await here.says("cf1", "get", robot="omni"))["found"] is True
        await here.clock.advance(2)
        assert (await here.says("cf1", "get", robot="omni"))["found"] is False


async def test_the_newest_and_who_follows_outlive_a_restart() -> None:
    store = MemoryStore()
    async with PeerRobots(store).open() as here:
        await here.says("cf1", "follow", robot="omni", topic="road")
        await say(here, "/shared omni follow")
        for number in range(5):
            await here.says("omni", "share", topic="road", data=number)
        await here.clock.advance(6)
    async with PeerRobots(store).open() as here:
        got = await here.says("cf1", "get", robot="omni", topic="road")
        assert (got["data"], got["age_s"] >= 0) == (4, True)
        before = len(here.chat.told)
        await here.says("omni", "share", topic="road", data="after")
        assert here.heard("cf1", "shared")[-1]["data"] == "after"
        await here.clock.advance(EVERY_S + 1)
        assert texts(here, ADA, before) == ['omni shares road: "after"']


async def test_a_follower_hears_at_a_pace_and_in_the_end_the_newest() -> None:
    async with PeerRobots().open() as here:
        await here.says("cf1", "follow", robot="omni")
        here.robot("cf1").heard.clear()
        for number in range(200):
            here.speaks("omni", "share", topic="road", data=number)
            await here.clock.advance(0.05)
        heard = here.heard("cf1", "shared")
        assert len(heard) <= PAIR_PACE.burst + PAIR_PACE.per_s * 10.5
        await here.clock.advance(1)
        assert here.heard("cf1", "shared")[-1]["data"] == 199
        await here.says("cf1", "unfollow", robot="omni")
        here.robot("cf1").heard.clear()
        here.speaks("omni", "share", topic="road", data="alone")
        await here.clock.advance(2)
        assert here.heard("cf1") == []


async def test_a_follower_whose_right_ends_hears_nothing_more() -> None:
    async with PeerRobots().open() as here:
        await here.says("cf2", "follow", robot="cf1")
        await say(here, "/lock cf2")
        here.robot("cf2").heard.clear()
        here.speaks("cf1", "share", topic="road", data=1)
        await here.clock.advance(2)
        assert here.heard("cf2") == []


async def test_people_read_it_who_may_read_the_robot() -> None:
    async with PeerRobots().open() as here:
        await here.says("omni", "share", topic="road", data={"wet": "\u202eyes"})
        await here.clock.advance(3)
        assert await say(here, "/shared") == 'omni · road (3 s ago): {"wet":"yes"}'
        assert await say(here, "/shared omni road", VI) == 'omni · road (3 s ago):\n{"wet":"yes"}'
        assert await say(here, "/shared cf1", VI) == "cf1 shares nothing now."
        assert await say(here, "/shared nobody") == "I know no robot called nobody."
        assert "wet" not in await say(here, "/shared omni road", STRANGER)


async def test_a_chat_that_follows_reads_a_digest_and_can_interrupt() -> None:
    async with PeerRobots().open() as here:
        said = await say(here, "/shared omni road follow", BO)
        assert said.startswith("From now on you read here what omni shares on road.")
        before = len(here.chat.told)
        for number in range(10):
            here.speaks("omni", "share", topic="road", data=number)
            here.speaks("omni", "share", topic="other", data=number)
            await here.clock.advance(0.2)
        await here.clock.advance(EVERY_S)
        assert texts(here, BO, before) == ["omni shares road: 9 (and 9 before it)"]
        button, under = here.button("Silence omni")
        told = await here.tap(button, under, BO)
        assert "omni is silenced among the robots" in told
        refused = await here.says("omni", "share", topic="road", data="unheard")
        assert refused["why"] == "You are silenced for now; a person did that."
        assert await say(here, "/shared omni road", BO) != "unheard"
        told = await say(here, "/quiet omni off", BO)
        assert set(told.split("\n")) == {"omni is heard among the robots again."}
        assert (await here.says("omni", "share", topic="road", data=1))["ok"] is True
        assert await say(here, "/quiet omni", VI) == "Only who may operate omni silences it."


async def test_who_follows_a_robot_no_more_reads_nothing_of_it_whatever_the_topic() -> None:
    async with PeerRobots().open() as here:
        for topic in ("road ", "map ", ""):
            await say(here, f"/shared omni {topic}follow", BO)
        told = await say(here, "/shared omni road unfollow", BO)
        assert told == "You read no more here of what omni shares on road."
        await say(here, "/shared omni road follow", ADA)
        told = await say(here, "/shared omni unfollow", BO)
        assert told == "You read no more here of what omni shares."
        before = len(here.chat.told)
        for topic in ("road", "map"):
            await here.says("omni", "share", topic=topic, data=1)
        await here.clock.advance(2 * EVERY_S)
        assert texts(here, BO, before) == []
        assert texts(here, ADA, before) == ["omni shares road: 1"]


async def test_what_a_robot_shares_lies_in_its_own_container_and_goes_with_it() -> None:
    store = MemoryStore()
    async with PeerRobots(store).open() as here:
        await here.says("omni", "share", topic="road", data="where I was")
        await here.says("omni", "help", what="stuck at the back door")
        await here.clock.advance(6)
        letters = [fact.letter for fact in await store.container_facts("omni") if fact.letter]
        assert {bytes(letter.content) for letter in letters} == {
            b'"where I was"',
            b"stuck at the back door",
        }
        erasing = here.gateway.features.get(PersonalDataFeature).erasing
        assert erasing is not None
        await erasing.erase_other("omni", "operator")
        assert (await here.says("cf1", "get", robot="omni"))["found"] is False
        assert "back door" not in await say(here, "/assist")
        await here.clock.advance(6)
    async with PeerRobots(store).open() as here:
        assert (await here.says("cf1", "get", robot="omni"))["found"] is False


async def test_a_digest_is_in_the_archive_of_the_chat_that_reads_it() -> None:
    async with PeerRobots().open() as here:
        await say(here, "/archive on")
        await say(here, "/shared omni road follow")
        here.speaks("omni", "share", topic="road", data=7)
        await here.clock.advance(EVERY_S)
        assert "omni shares road: 7" in texts(here, ADA, 0)
        kept = await here.store.facts("archived", "", 1_000)  # type: ignore[attr-defined]
        told = [fact.letter.content for fact in kept if fact.letter is not None]
        assert any(b"omni shares road: 7" in content for content in told)


async def test_whoever_speaks_to_chats_speaks_through_the_archive() -> None:
    async with PeerRobots().open() as here:
        gateway = here.gateway
        digests, retracting = (
            gateway.features.get(RobotToRobotFeature).messaging.circle.digests,
            gateway.features.get(AccessFeature).retracting,
        )
        for speakers in (digests._messengers, retracting._messengers):
            assert all(isinstance(one, ArchivingMessenger) for one in speakers.values())
