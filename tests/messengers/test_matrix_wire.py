"""A homeserver that does its worst at the wire: what it cannot do to people who order and stop."""

from __future__ import annotations

import asyncio
from time import thread_time
from typing import TYPE_CHECKING, Any, Self

import pytest

from rosic.core.message import Chat, ChatKind, MessageValidity, Outbound
from tests.messengers.matrix_homeserver import EncryptingDevice
from tests.messengers.matrix_lab import ADA, BOB, EVE, HostileLab, hostile_lab, moves
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

ROOM, OTHER = "!room:example.org", "!other:example.org"
GO = "omni move 1 m"
STEP_S = 0.02
"""No input holds the event loop longer (I15)."""
TRIES = 3


@pytest.fixture
async def lab(tmp_path: Path) -> AsyncIterator[HostileLab]:
    async with hostile_lab(tmp_path) as found:
        yield found


async def entered(lab: HostileLab, *rooms: str) -> None:
    for room in rooms or (ROOM,):
        key = lab.ada.phone.room_key(lab.server, room)
        await lab.gives(joined={room: lab.entering(ADA)}, to_device=[key])
    await lab.gives()
    await lab.listens()


async def test_what_ada_says_moves_and_what_others_say_does_not(lab: HostileLab) -> None:
    await entered(lab)
    await lab.gives({ROOM: [lab.sealed(lab.ada.phone, ROOM, GO)]})
    assert moves(await lab.hears(GO))
    await lab.gives({ROOM: [lab.plain(ADA, "omni move 2 m")]})
    assert not moves(await lab.hears("omni move 2 m"))


async def test_a_message_that_was_held_back_is_backlog(lab: HostileLab) -> None:
    await entered(lab)
    held = lab.sealed(lab.ada.phone, ROOM, GO)
    await lab.gives({ROOM: [lab.sealed(lab.ada.phone, ROOM, "status")]})
    await lab.hears("status")
    await lab.clock.advance(1)
    await lab.gives({ROOM: [held | {"origin_server_ts": lab.now_ms}]})
    found = await lab.hears(GO)
    assert not moves(found)
    assert found.sent_ns < found.received_ns


async def test_of_a_room_with_a_gap_that_room_alone_is_backlog(lab: HostileLab) -> None:
    await entered(lab, ROOM, OTHER)
    lab.server.messages = lambda _room: {"chunk": [lab.plain(BOB, "status")], "end": None}
    said = [lab.sealed(lab.ada.phone, ROOM, GO)]
    gap = {"timeline": {"events": said, "limited": True, "prev_batch": "p1"}}
    answer: dict[str, Any] = {
        ROOM: gap,
        OTHER: {"timeline": {"events": [lab.sealed(lab.ada.phone, OTHER, "go")]}},
    }
    await lab.gives(joined=answer)
    assert moves(await lab.hears("go"))
    assert not moves(await lab.hears(GO))
    assert [one.text for one in lab.inbox.heard if one.chat.id == ROOM] == ["status", GO]
    assert not lab.messenger.catching_up()


async def test_a_room_whose_messages_cannot_be_had_holds_up_no_stop_and_no_other_room(
    lab: HostileLab,
) -> None:
    await entered(lab, ROOM, OTHER)
    lab.server.messages = lambda _room: {"no": "chunk"}
    events = [lab.sealed(lab.ada.phone, ROOM, GO), lab.sealed(lab.ada.phone, ROOM, "stop")]
    gap = {"timeline": {"events": events, "limited": True, "prev_batch": "p1"}}
    await lab.gives(joined={ROOM: gap})
    await lab.hears("stop")
    await lab.gives({OTHER: [lab.sealed(lab.ada.phone, OTHER, "go")]})
    assert moves(await lab.hears("go"))
    assert GO not in [one.text for one in lab.inbox.heard]
    for _ in range(12):
        await lab.clock.advance(4)
        await lab.gives()
    assert not moves(await lab.hears(GO))


async def test_a_stop_is_handed_over_before_the_keys_beside_it_are_looked_at(
    lab: HostileLab,
) -> None:
    await entered(lab, ROOM, OTHER)
    keys = [lab.eve.phone.room_key(lab.server, f"!{n}:example.org") for n in range(300)]
    said = [lab.sealed(lab.ada.phone, OTHER, f"status {n}") for n in range(100)]
    await lab.gives({OTHER: said, ROOM: [lab.sealed(lab.ada.phone, ROOM, "stop")]}, to_device=keys)
    await lab.hears("status 99")
    assert lab.inbox.heard[0].text == "stop"


class LongestStep:
    """Measures how much of the processor one step took, while it is entered.

    Attributes:
        longest_s: At the most.
    """

    def __enter__(self) -> Self:
        self.longest_s = 0.0
        self._task = asyncio.create_task(self._look())
        return self

    def __exit__(self, *_error: object) -> None:
        self._task.cancel()

    async def _look(self) -> None:
        before = thread_time()
        while True:
            await asyncio.sleep(0)
            now = thread_time()
            self.longest_s, before = max(self.longest_s, now - before), now


FLOODS = ("messages", "keys", "members", "giant state", "long messages", "rooms")


def flood(lab: HostileLab, what: str) -> dict[str, Any]:
    """Return an answer that is as long as anybody may make one."""
    joined = {"membership": "join"}
    if what == "keys":
        names = [f"!{n}:example.org" for n in range(200)]
        return {"to_device": {"events": [lab.eve.phone.room_key(lab.server, n) for n in names]}}
    if what == "rooms":
        return {"joined": {f"!{n}:example.org": lab.entering(EVE) for n in range(400)}}
    if what in {"messages", "long messages"}:
        said = [lab.sealed(lab.ada.phone, ROOM, f"status {n}") for n in range(500)]
        long = [lab.plain(EVE, "x" * 60_000) for _ in range(100)]
        events = said if what == "messages" else long
        return {"joined": {ROOM: {"timeline": {"events": events}}}}
    levels = {"users": {f"@{n}:example.org": n for n in range(3_000)}}
    events = [lab.state("m.room.power_levels", "", levels) for _ in range(30)]
    if what == "members":
        events = [lab.state("m.room.member", f"@{n}:x", joined) for n in range(20_000)]
    return {"joined": {ROOM: {"state": {"events": events}}}}


async def longest_step_s(lab: HostileLab, answer: dict[str, Any]) -> float:
    joined = answer.pop("joined", {})
    number = lab.server.gives({"rooms": {"join": joined}, **answer})
    with LongestStep() as step:
        await lab.server.taken(number)
        await lab.gives()
    return step.longest_s


async def test_no_answer_takes_the_event_loop_for_long(lab: HostileLab) -> None:
    await entered(lab)
    within_s = STEP_S * pace()
    for what in FLOODS:
        # Whatever takes long in itself does so each time; the machine has other things to do.
        steps_s = [await longest_step_s(lab, flood(lab, what))]
        while min(steps_s) > within_s and len(steps_s) < TRIES:
            steps_s.append(await longest_step_s(lab, flood(lab, what)))
        assert min(steps_s) <= within_s, f"{what}: {steps_s}"


async def test_a_person_with_devices_without_end_is_looked_at_in_short_steps(
    lab: HostileLab,
) -> None:
    await entered(lab)
    for number in range(300):
        lab.server.adds(EncryptingDevice(ADA, f"D{number}"))
    await lab.gives(device_lists={"changed": [ADA]})
    with LongestStep() as step:
        await lab.gives({ROOM: [lab.sealed(lab.ada.phone, ROOM, GO)]})
        assert moves(await lab.hears(GO))
    assert step.longest_s <= STEP_S * pace()


async def test_what_is_said_is_given_to_devices_that_were_compared_alone(lab: HostileLab) -> None:
    await entered(lab)
    await lab.gives({ROOM: lab.members(EVE, BOB)})
    lab.server.adds(EncryptingDevice(ADA, "INSERTED"))
    await lab.gives(device_lists={"changed": [ADA]})
    lab.server.given.clear()
    await lab.messenger.send(Outbound(chat=Chat("matrix", ROOM, ChatKind.GROUP), text="hello"))
    assert lab.server.given == [(ADA, "PHONE")]
    assert lab.server.sent[-1][1] == "m.room.encrypted"


async def test_admins_are_told_of_a_forgery_once(lab: HostileLab) -> None:
    await entered(lab)
    eve = lab.eve.phone
    await lab.gives({ROOM: lab.members(EVE)}, to_device=[eve.room_key(lab.server, ROOM)])
    await lab.messenger._trust._cross_signing.look_up(EVE)  # type: ignore[union-attr]
    for number in range(5):
        forged = lab.sealed(eve, ROOM, f"omni move {number} m", sender=ADA)
        await lab.gives({ROOM: [forged]})
        assert (await lab.hears(f"omni move {number} m")).standing is MessageValidity.ANONYMOUS
    assert len([one for one in lab.alarms if ADA in one]) == 1
