from __future__ import annotations

import asyncio
import hashlib
from typing import TYPE_CHECKING

import pytest
import vodozemac

from rosic.contracts.verification import VerificationEnd
from rosic.errors import MessengerFault
from rosic.messengers.matrix.signed_json import canonical_json, to_base64
from rosic.messengers.matrix.verification import (
    CANCEL,
    DONE,
    LIVE_AT_MOST,
    READY,
    REQUEST,
)
from tests.messengers.matrix_identities import (
    ADA,
    EVE,
    ROBOT,
    Account,
    Device,
    Person,
)
from tests.messengers.matrix_wire import ROOM, Event, Pair

if TYPE_CHECKING:
    from collections.abc import Callable


@pytest.fixture
async def pair() -> Pair:
    pair = Pair()
    await pair.robot.cross_signing.start()
    await pair.ada.cross_signing.start()
    return pair


COMPARED = {(VerificationEnd.COMPARED, "")}


# ---- as it should be ----


@pytest.mark.parametrize("room", ["", ROOM])
@pytest.mark.parametrize("who", ["robot", "ada"])
async def test_either_begins_and_both_know_each_other_afterwards(
    pair: Pair, who: str, room: str
) -> None:
    name = await pair.begin(pair.robot if who == "robot" else pair.ada, room=room)
    assert not await pair.robot.trusts(ADA, "PHONE")
    [ours], [theirs] = pair.robot.codes, pair.ada.codes
    assert ours.emoji == theirs.emoji
    assert len(ours.emoji) == 7
    assert ours.decimals == ()
    assert ours.text == theirs.text
    assert (ours.user, ours.device, ours.verification) == (ADA, "PHONE", name)

    await pair.confirm(name)
    assert pair.ends() == COMPARED
    assert all(result.master for result in pair.robot.results + pair.ada.results)
    assert await pair.robot.trusts(ADA, "PHONE")
    assert await pair.ada.trusts(ROBOT, "ROBOTDEV")
    kinds = [kind for kind in pair.wire.kinds() if kind != "done"]
    request = "message" if room else "request"
    assert kinds == [request, "ready", "start", "accept", "key", "key", "mac", "mac"]


async def test_what_was_compared_is_known_after_a_restart(pair: Pair) -> None:
    await pair.confirm(await pair.begin(pair.ada))
    again = Account(pair.homeserver, pair.robot.device, pair.robot.folder)
    await again.cross_signing.start()
    assert await again.cross_signing.is_verified_device(ADA, "PHONE")


async def test_the_order_in_which_people_confirm_does_not_matter(pair: Pair) -> None:
    name = await pair.begin(pair.ada)
    await pair.ada.emoji.confirm(name)
    await pair.wire.carry()
    assert pair.robot.results == pair.ada.results == []
    assert not await pair.robot.trusts(ADA, "PHONE")

    await pair.robot.emoji.confirm(name)
    await pair.wire.carry()
    assert pair.ends() == COMPARED


@pytest.mark.parametrize("room", ["", ROOM])
async def test_both_may_start_at_once(pair: Pair, room: str) -> None:
    """The robot asks her, and when she is ready she starts at the same time as it does."""
    name = await pair.robot.emoji.begin(ADA, room=room)

    def and_start(event: Event) -> list[Event]:
        one = pair.ada.emoji._live[name]
        assert one.exchange is not None
        [(kind, content)] = one.exchange.start()
        to = room or f"{ROBOT} ROBOTDEV"
        pair.wire.put(to, {"type": kind, "sender": ADA, "content": content})
        return [event]

    pair.wire.change[READY] = and_start
    await pair.wire.carry()
    await pair.confirm(name)
    assert pair.wire.kinds().count("start") == 2
    accepts = [event for _, event in pair.wire.sent if event["type"].endswith("accept")]
    assert [event["sender"] for event in accepts] == [ROBOT]  # hers counts: she comes first
    assert pair.ends() == COMPARED
    assert pair.robot.codes[0].emoji == pair.ada.codes[0].emoji


async def test_an_event_that_is_brought_twice_is_taken_once(pair: Pair) -> None:
    for kind in ("ready", "start", "accept", "key", "mac", "done"):
        pair.wire.change[f"m.key.verification.{kind}"] = lambda event: [event, event]
    pair.wire.change[REQUEST] = lambda event: [event, event]
    await pair.confirm(await pair.begin(pair.ada))
    assert pair.ends() == COMPARED


async def test_of_several_devices_the_first_to_answer_is_the_one(pair: Pair) -> None:
    laptop = pair.end(ADA, "LAPTOP")
    laptop.folder.files = dict(pair.ada.folder.files)
    await laptop.cross_signing.start()

    name = await pair.begin(pair.robot)
    assert len(pair.robot.codes) == 1
    assert [result.code for result in laptop.results] == ["m.accepted"]
    await pair.robot.emoji.confirm(name)
    await pair.ada.emoji.confirm(name)
    await pair.wire.carry()
    assert await pair.robot.trusts(ADA, "PHONE")
    assert await pair.robot.trusts(ADA, "LAPTOP")


async def test_somebody_without_cross_signing_has_their_device_compared(pair: Pair) -> None:
    eve = pair.end(EVE, "PHONE")
    name = await eve.emoji.begin(ROBOT)
    await pair.wire.carry()
    await eve.emoji.confirm(name)
    await pair.robot.emoji.confirm(name)
    await pair.wire.carry()
    assert [(result.end, result.master) for result in pair.robot.results] == [
        (VerificationEnd.COMPARED, False)
    ]
    assert await pair.robot.trusts(EVE, "PHONE")


# ---- as it should not be ----


async def test_codes_that_are_not_the_same_end_it_for_both(pair: Pair) -> None:
    name = await pair.begin(pair.ada)
    await pair.robot.emoji.reject(name)
    await pair.wire.carry()
    assert pair.ends() == {(VerificationEnd.CANCELLED, "m.mismatched_sas")}
    assert pair.ada.results[0].by_them
    assert not pair.robot.results[0].by_them
    with pytest.raises(MessengerFault):
        await pair.robot.emoji.confirm(name)
    assert not await pair.robot.trusts(ADA, "PHONE")


async def test_nothing_can_be_confirmed_before_it_is_shown_or_twice(pair: Pair) -> None:
    name = await pair.ada.emoji.begin(ROBOT)
    for bad in (name, "other"):
        with pytest.raises(MessengerFault):
            await pair.ada.emoji.confirm(bad)
    await pair.wire.carry()
    await pair.ada.emoji.confirm(name)
    await pair.ada.emoji.confirm(name)
    await pair.wire.carry()
    assert pair.ends() == {(VerificationEnd.CANCELLED, "m.unexpected_message")}


async def test_a_homeserver_between_them_shows_two_codes(pair: Pair) -> None:
    """It answers each of them with a key of its own; the commitment it makes is its own, too."""
    own = vodozemac.Sas().public_key.to_base64()

    def promise(event: Event) -> list[Event]:
        start = next(e for _, e in pair.wire.sent if e["type"].endswith("start"))
        said = own.encode() + canonical_json(start["content"])
        content = {**event["content"], "commitment": to_base64(hashlib.sha256(said).digest())}
        return [{**event, "content": content}]

    def replace_key(event: Event) -> list[Event]:
        return [{**event, "content": {**event["content"], "key": own}}]

    pair.wire.change["m.key.verification.accept"] = promise
    pair.wire.change["m.key.verification.key"] = replace_key
    await pair.begin(pair.ada)
    [ours], [theirs] = pair.robot.codes, pair.ada.codes
    assert ours.emoji != theirs.emoji


async def test_a_key_that_was_not_promised_ends_it(pair: Pair) -> None:
    own = vodozemac.Sas().public_key.to_base64()
    seen: list[Event] = []

    def replace_second(event: Event) -> list[Event]:
        seen.append(event)
        if len(seen) == 1:
            return [event]
        return [{**event, "content": {**event["content"], "key": own}}]

    pair.wire.change["m.key.verification.key"] = replace_second
    await pair.begin(pair.ada)
    assert (VerificationEnd.CANCELLED, "m.mismatched_commitment") in pair.ends()


def _changed(name: str, value: object) -> Callable[[Event], list[Event]]:
    return lambda event: [{**event, "content": {**event["content"], name: value}}]


@pytest.mark.parametrize(
    ("kind", "name", "value", "code"),
    [
        ("ready", "methods", ["m.qr_code.scan.v1"], "m.unknown_method"),
        ("ready", "methods", None, "m.unknown_method"),
        ("ready", "from_device", 7, "m.unknown_method"),
        ("ready", "from_device", "NOBODY", "m.key_mismatch"),
        ("start", "method", "m.other", "m.unknown_method"),
        ("start", "from_device", "NOBODY", "m.invalid_message"),
        ("start", "hashes", ["md5"], "m.unknown_method"),
        ("start", "key_agreement_protocols", ["curve25519"], "m.unknown_method"),
        ("start", "message_authentication_codes", ["hkdf-hmac-sha256"], "m.unknown_method"),
        ("start", "short_authentication_string", [], "m.unknown_method"),
        ("start", "short_authentication_string", "emoji", "m.unknown_method"),
        ("start", "extra", 0.5, "m.invalid_message"),
        ("start", "extra", 7, "m.mismatched_commitment"),
        ("accept", "hash", "md5", "m.unknown_method"),
        ("accept", "key_agreement_protocol", "curve25519", "m.unknown_method"),
        ("accept", "message_authentication_code", "hkdf-hmac-sha256", "m.unknown_method"),
        ("accept", "short_authentication_string", None, "m.unknown_method"),
        ("accept", "commitment", None, "m.invalid_message"),
        ("accept", "commitment", "", "m.mismatched_commitment"),
        ("key", "key", None, "m.invalid_message"),
        ("key", "key", "short", "m.invalid_message"),
        ("key", "key", "A" * 43, "m.invalid_message"),
        ("mac", "mac", None, "m.invalid_message"),
        ("mac", "mac", {}, "m.key_mismatch"),
        ("mac", "mac", {str(number): "" for number in range(17)}, "m.invalid_message"),
        ("mac", "keys", None, "m.invalid_message"),
        ("mac", "keys", "x", "m.key_mismatch"),
    ],
)
async def test_whatever_is_wrong_ends_it_and_nothing_is_trusted(
    pair: Pair, kind: str, name: str, value: object, code: str
) -> None:
    pair.wire.change[f"m.key.verification.{kind}"] = _changed(name, value)
    verification = await pair.begin(pair.ada)
    if kind == "mac":
        await pair.confirm(verification)
    assert (VerificationEnd.CANCELLED, code) in pair.ends()
    assert {end for end, _ in pair.ends()} == {VerificationEnd.CANCELLED}
    assert not await pair.robot.trusts(ADA, "PHONE")
    assert not await pair.ada.trusts(ROBOT, "ROBOTDEV")


async def test_a_master_key_that_the_homeserver_replaced_ends_it(pair: Pair) -> None:
    """What her device vouches for is not what the robot was shown."""
    forged = Person(ADA)
    honest = pair.homeserver.shown["master_keys"][ADA]
    pair.homeserver.shown["master_keys"][ADA] = forged.shown_master()
    pair.homeserver.shown["self_signing_keys"][ADA] = forged.shown_self_signing()
    name = await pair.begin(pair.ada)
    pair.homeserver.shown["master_keys"][ADA] = honest
    await pair.confirm(name)
    assert (VerificationEnd.CANCELLED, "m.key_mismatch") in pair.ends()
    assert not await pair.robot.trusts(ADA, "PHONE")


async def test_a_device_key_that_the_homeserver_replaced_ends_it(pair: Pair) -> None:
    forged = Device(ADA, "PHONE")
    pair.homeserver.shown["device_keys"][ADA]["PHONE"] = forged.shown()
    await pair.confirm(await pair.begin(pair.ada))
    assert (VerificationEnd.CANCELLED, "m.key_mismatch") in pair.ends()
    assert not await pair.robot.trusts(ADA, "PHONE")


@pytest.mark.parametrize("kind", ["ready", "start", "accept", "key", "mac", "cancel", "done"])
async def test_nobody_else_takes_part(pair: Pair, kind: str) -> None:
    """Eve says the same as the other, before them: it is passed over, and theirs counts."""
    full = f"m.key.verification.{kind}"
    pair.wire.change[full] = lambda event: [
        {**event, "sender": EVE, "content": {**event["content"], "from_device": "X"}},
        event,
    ]
    name = await pair.begin(pair.ada)
    await pair.robot.emoji.on_to_device(
        {
            "type": CANCEL,
            "sender": EVE,
            "content": {"transaction_id": name, "code": "m.user"},
        }
    )
    await pair.confirm(name)
    assert pair.ends() == COMPARED


async def test_a_verification_stays_where_it_was_begun(pair: Pair) -> None:
    name = await pair.begin(pair.ada, room=ROOM)
    cancel = {"type": CANCEL, "sender": ADA, "content": {"code": "m.user", "transaction_id": name}}
    await pair.robot.emoji.on_to_device(cancel)
    link = {"rel_type": "m.reference", "event_id": name}
    elsewhere = {**cancel, "content": {"code": "m.user", "m.relates_to": link}}
    await pair.robot.emoji.on_room_event("!other:example.org", elsewhere)
    await pair.confirm(name)
    assert pair.ends() == COMPARED


async def test_what_came_before_its_time_ends_it(pair: Pair) -> None:
    for kind in ("accept", "key", "mac", "start", "unknown"):
        name = await pair.ada.emoji.begin(ROBOT)
        event = {
            "type": f"m.key.verification.{kind}",
            "sender": ROBOT,
            "content": {"transaction_id": name},
        }
        await pair.ada.emoji.on_to_device(event)
        await pair.wire.carry()
        assert pair.ada.results.pop().code == "m.unexpected_message"


async def test_a_stranger_is_passed_over_in_silence(pair: Pair) -> None:
    pair.robot.strangers.add(ADA)
    for room in ("", ROOM):
        await pair.begin(pair.ada, room=room)
    assert pair.wire.kinds() == ["request", "cancel", "message"]
    assert pair.robot.results == []
    assert pair.robot.codes == []


@pytest.mark.parametrize("late_s", [-601.0, 301.0])
async def test_a_request_of_another_time_is_passed_over(pair: Pair, late_s: float) -> None:
    event = {
        "type": REQUEST,
        "sender": ADA,
        "content": {
            "from_device": "PHONE",
            "methods": ["m.sas.v1"],
            "transaction_id": "t",
            "timestamp": pair.clock.wall_ns() // 10**6 + int(late_s * 1000),
        },
    }
    await pair.robot.emoji.on_to_device(event)
    assert pair.wire.sent == []


async def test_a_request_to_somebody_else_in_the_room_is_passed_over(pair: Pair) -> None:
    await pair.ada.emoji.begin(EVE, room=ROOM)
    await pair.wire.carry()
    assert pair.wire.kinds() == ["message"]


async def test_one_that_lasts_too_long_ends(pair: Pair) -> None:
    name = await pair.begin(pair.ada)
    await pair.clock.advance(601.0)
    with pytest.raises(MessengerFault):
        await pair.robot.emoji.confirm(name)
    await pair.ada.emoji.expire()
    await pair.wire.carry()
    assert pair.ends() == {(VerificationEnd.CANCELLED, "m.timeout")}


async def test_a_person_has_one_at_a_time(pair: Pair) -> None:
    first = await pair.begin(pair.ada)
    second = await pair.begin(pair.ada)
    with pytest.raises(MessengerFault):
        await pair.robot.emoji.confirm(first)
    pair.robot.results.clear()
    pair.ada.results.clear()
    await pair.confirm(second)
    assert pair.ends() == COMPARED


async def test_there_are_never_many_at_once(pair: Pair) -> None:
    ends = [pair.end(f"@{number}:example.org", "DEV") for number in range(LIVE_AT_MOST + 3)]
    for end in ends:
        await end.emoji.begin(ROBOT)
    await pair.wire.carry()
    assert len(pair.robot.emoji._live) == LIVE_AT_MOST


async def test_what_cannot_be_kept_is_said_to_both(pair: Pair) -> None:
    name = await pair.begin(pair.ada)
    pair.robot.folder.full = True
    await pair.confirm(name)
    assert pair.robot.results[0].end is VerificationEnd.NOT_KEPT
    assert not await pair.robot.trusts(ADA, "PHONE")


async def test_a_homeserver_that_is_away_ends_it(pair: Pair) -> None:
    name = await pair.begin(pair.ada)
    pair.wire.broken = True
    await pair.robot.emoji.confirm(name)
    assert pair.robot.results[0].end is VerificationEnd.CANCELLED
    with pytest.raises(MessengerFault):
        await pair.robot.emoji.begin(ADA)
    with pytest.raises(MessengerFault):
        await pair.robot.emoji.begin(ADA, room=ROOM)
    assert pair.robot.emoji._live == {}
    await pair.ada.emoji.reject(name)


async def test_keys_that_cannot_be_looked_up_end_it(pair: Pair) -> None:
    name = await pair.ada.emoji.begin(ROBOT)
    pair.homeserver.away = True
    await pair.wire.carry()
    pair.homeserver.away = False
    assert [result.verification for result in pair.robot.results] == [name]
    assert pair.ends() == {(VerificationEnd.CANCELLED, "m.user")}


async def test_an_answer_that_is_faster_than_the_id_is_waited_for(pair: Pair) -> None:
    """In a room the id is that of the event, which its sender may learn after the answer."""
    before = pair.robot.in_room

    async def slow(room: str, kind: str, content: Event) -> str:
        found = await before(room, kind, content)
        if content.get("msgtype") == REQUEST:
            await pair.wire.carry()
            await asyncio.sleep(0)
        return found

    pair.robot.in_room = slow  # type: ignore[method-assign]
    await pair.confirm(await pair.begin(pair.robot, room=ROOM))
    assert pair.ends() == COMPARED


@pytest.mark.parametrize(
    "event",
    [
        {},
        {"type": 1, "sender": ADA, "content": {}},
        {"type": REQUEST, "sender": ADA, "content": None},
        {"type": REQUEST, "sender": ADA, "content": {}},
        {"type": REQUEST, "sender": ADA, "content": {"transaction_id": "x" * 300}},
        {"type": REQUEST, "sender": ADA, "content": {"transaction_id": "x", "timestamp": True}},
        {"type": DONE, "sender": ADA, "content": {"transaction_id": "x"}},
        {"type": DONE, "sender": ADA, "content": {"m.relates_to": []}},
        {"type": "m.room.message", "sender": ADA, "content": {"msgtype": REQUEST, "to": ROBOT}},
        {
            "type": "m.room.message",
            "sender": ADA,
            "event_id": "$x",
            "content": {"msgtype": REQUEST, "to": EVE},
        },
        {"type": "m.other", "sender": ADA, "content": {"transaction_id": "x"}},
    ],
)
async def test_what_is_malformed_is_passed_over(pair: Pair, event: Event) -> None:
    await pair.robot.emoji.on_to_device(event)
    await pair.robot.emoji.on_room_event(ROOM, event)
    assert pair.wire.sent == []
